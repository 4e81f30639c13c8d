"""``taskgist facts``: what can be said of a recording."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import JsonOption, RecordingArgument, about, command, console, print_json, progress_bar
from taskgist.cli.relations import intervals_document, print_intervals, print_relations
from taskgist.common.frozen import thaw
from taskgist.errors import LabelError
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import UNKNOWN, Observation
from taskgist.learning.explanation import Explanation, explain
from taskgist.observe.attributes import snapshot
from taskgist.observe.observer import Observer
from taskgist.pipeline.explain import episode_of
from taskgist.pipeline.timelines import Timeline, timeline
from taskgist.recording.mcap import read
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT
from taskgist.world.stage import Stage


@command
def facts(
    recording: RecordingArgument,
    agent: Annotated[str | None, typer.Option(help="From whose perspective; default: the label's target.")] = None,
    object: Annotated[str | None, typer.Option("--object", help="Of which object; default: the label's.")] = None,  # noqa: A002
    at: Annotated[float | None, typer.Option(help="Only at this time, with evidence; seconds.")] = None,
    every: Annotated[float, typer.Option(min=0.02, help="Seconds between samples of the timeline.")] = 0.5,
    relations: Annotated[
        bool, typer.Option("--relations", help="Relations instead: sight, attention, places, touching, carrying.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what is true for an agent, when, and what changed.

    Prints every attribute over time, and the effect between the label's start and end. With --relations: who has what
    in sight, looks at it, is near, approaches, touches and carries it, exact to the frame.

    Example: taskgist facts handover.mcap

    Example: taskgist facts handover.mcap --agent giver --object baton --at 2.0

    Example: taskgist facts handover.mcap --relations
    """
    opened = read(recording)
    with about(recording, {"time_s": "--at"}):
        agent, object = _subject(opened, agent, object)  # noqa: A001
        state = None if at is None else opened.at(at)
    observer = Observer(opened.scene, opened)
    if relations:
        print_relations(opened, observer, agent, object, state, as_json=as_json)
        return
    if state is not None:
        stage = Stage(opened.scene, state)
        observed = snapshot(stage, observer, agent=agent, name=object, predicates=known_predicates())
        _print_instant(agent, object, state.time_s, observed, as_json=as_json)
        return
    with progress_bar(quiet=as_json) as progress:
        line = timeline(
            opened, observer, agent=agent, name=object, every_s=every, predicates=known_predicates(), progress=progress
        )
        effect = _effect(opened, agent, object, observer)
    if as_json:
        print_json(_timeline_document(line, effect))
    else:
        _print_timeline(line)
        _print_effect(effect)


def _subject(recording: Recording, agent: str | None, name: str | None) -> tuple[str, str]:
    label = recording.label
    if (agent is None or name is None) and label is None:
        raise LabelError("the recording has no label", hint="name --agent and --object")
    agent = agent or (label.target_agent if label else "")
    name = name or (label.target_object if label else "")
    recording.scene.agent(agent)
    recording.scene.object_body(name)
    return agent, name


def _effect(recording: Recording, agent: str, name: str, observer: Observer) -> Explanation | None:
    """The explanation between the label's ends, as if agent and object asked for were its targets."""
    label = recording.label
    if label is None:
        return None
    other = label.target_agent if agent == label.performing_agent else label.performing_agent
    label = replace(label, performing_agent=other, target_agent=agent, target_object=name)
    tree = with_predicates(STANDARD_TREE)
    episode = episode_of(recording, label=label, predicates=known_predicates(), observer=observer)
    return explain(episode, tree, DEFAULT)


def _print_instant(agent: str, name: str, at: float, observed: dict[str, Observation[Any]], *, as_json: bool) -> None:
    if as_json:
        print_json(
            {"agent": agent, "object": name, "time_s": at, "attributes": {k: o.to_json() for k, o in observed.items()}}
        )
        return
    console.print(Text(f"{name} for {agent} at {at:.2f} s", style="bold"))
    for attribute, observation in observed.items():
        value = "unknown" if observation.value is UNKNOWN else _value_text(observation.to_json()["value"])
        reason = thaw(observation.evidence.get("reason", ""))
        console.print(f"  {attribute:18}{value}{f'   ({reason})' if reason else ''}")


def _value_text(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key}: {item or 'unknown'}" for key, item in value.items())
    return f"{value:.4f}" if isinstance(value, float) else str(value)


def _timeline_document(line: Timeline, effect: Explanation | None) -> dict[str, Any]:
    rows = {attribute: intervals_document(intervals) for attribute, intervals in line.rows.items()}
    values = {name: node.to_json() for name, node in effect.nodes.items()} if effect else None
    return {"agent": line.agent, "object": line.name, "every_s": line.every_s, "timeline": rows, "effect": values}


def _print_timeline(line: Timeline) -> None:
    console.print(Text.assemble((f"{line.name} for {line.agent}", "bold"), f", sampled every {line.every_s:g} s"))
    for attribute, intervals in line.rows.items():
        if attribute.endswith(".state"):
            continue  # joint angles: --at shows them
        print_intervals(attribute, intervals)


def _print_effect(effect: Explanation | None) -> None:
    if effect is None:
        return
    subject = f"on {effect.target_object} for {effect.target_agent}"
    console.print(
        Text.assemble(("effect", "bold"), f" of {effect.task!r} {subject}, between the label's start and end")
    )
    tree = with_predicates(STANDARD_TREE)
    for node in tree.nodes:
        if node.level < 3:
            value = effect.nodes[node.name].value
            indent = "    " if node.parent is None else "      "
            console.print(f"{indent}{node.title} = {'unknown' if value is UNKNOWN else value}")
