"""``taskgist facts``: what can be said of a recording."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import replace
from itertools import product
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import JsonOption, RecordingArgument, about, command, console, print_json, progress_bar
from taskgist.cli.relations import intervals_document, print_intervals, tell_relations
from taskgist.common.frozen import thaw
from taskgist.errors import LabelError
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import TreeOf, tree_of
from taskgist.facts.values import UNKNOWN
from taskgist.language.phrases import listed
from taskgist.learning.explanation import Explanation
from taskgist.observe.attributes import snapshot
from taskgist.observe.observer import Observer
from taskgist.pipeline.explain import explain_recording
from taskgist.pipeline.timelines import Timeline, timeline
from taskgist.recording.mcap import read
from taskgist.recording.recording import Recording
from taskgist.world.stage import Stage
from taskgist.world.state import State


@command
def facts(
    recording: RecordingArgument,
    agent: Annotated[str | None, typer.Option(help="From whose perspective; default: the label's targets.")] = None,
    of: Annotated[
        str, typer.Option(help="Without --agent: the label's target, or performer (its own tree).")
    ] = "target",
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

    With --of performer: what the task changes for the agent that performs it (its own effort, hands, posture).

    Where the label has several target agents or objects, each agent's facts on each object are shown, and in the end
    what is the same for all of them.

    Example: taskgist facts handover.mcap

    Example: taskgist facts handover.mcap --agent giver --object baton --at 2.0

    Example: taskgist facts handover.mcap --of performer

    Example: taskgist facts handover.mcap --relations
    """
    opened, whose = read(recording), tree_of(of)
    with about(recording, {"time_s": "--at"}):
        agents, objects = _subjects(opened, agent, object, whose)
        state = None if at is None else opened.at(at)
    observer = Observer(opened.scene, opened)
    over_time = not relations and state is None
    effect = _effect(opened, agents, objects, observer) if over_time else None
    documents: list[dict[str, Any]] = []
    for who, what in product(agents, objects):
        if relations:
            document = tell_relations(opened, observer, who, what, state, quiet=as_json)
        elif state is not None:
            document = _tell_instant(opened, observer, who, what, state, quiet=as_json)
        else:
            own = effect.part(who, what) if effect else None
            document = _tell_over_time(opened, observer, who, what, every, own, quiet=as_json)
        documents.append(document)
    if as_json:
        print_json(documents[0] if len(documents) == 1 else _of_all(agents, objects, documents, effect))
    elif effect is not None and len(documents) > 1:
        _print_effect(effect)


def _subjects(
    recording: Recording, agent: str | None, name: str | None, of: TreeOf
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    if agent is not None and of == "performer":
        raise LabelError("--agent says already whose", field="--of", value=of, hint="leave one of both out")
    label = recording.label.alone if recording.label and of == "performer" else recording.label
    if (agent is None or name is None) and label is None:
        raise LabelError("the recording has no label", hint="name --agent and --object")
    agents = (agent,) if agent is not None else label.watched if label else ()
    objects = (name,) if name is not None else label.target_objects if label else ()
    for each in agents:
        recording.scene.agent(each)
    for each in objects:
        recording.scene.object_body(each)
    return agents, objects


def _effect(
    recording: Recording, agents: tuple[str, ...], objects: tuple[str, ...], observer: Observer
) -> Explanation | None:
    """The explanation between the label's ends, as if agents and objects asked for were its targets."""
    label = recording.label
    if label is None:
        return None
    of_performer = agents == (label.performing_agent,)
    label = replace(label, target_agents=() if of_performer else agents, target_objects=objects)
    return explain_recording(recording, label=label, observer=observer)


def _of_all(
    agents: tuple[str, ...], objects: tuple[str, ...], each: list[dict[str, Any]], effect: Explanation | None
) -> dict[str, Any]:
    """The document of several agents or objects: that of each pair, and the effect that is the same for all."""
    return {"agents": list(agents), "objects": list(objects), "each": each, "effect": _effect_document(effect)}


def _effect_document(effect: Explanation | None) -> dict[str, Any] | None:
    return {name: node.to_json() for name, node in effect.nodes.items()} if effect else None


def _tell_instant(
    recording: Recording, observer: Observer, agent: str, name: str, state: State, *, quiet: bool
) -> dict[str, Any]:
    """Print the attributes at one time, unless quiet; their document."""
    observed = snapshot(Stage(recording.scene, state), observer, agent=agent, name=name, predicates=known_predicates())
    if not quiet:
        console.print(Text(f"{name} for {agent} at {state.time_s:.2f} s", style="bold"))
        for attribute, observation in observed.items():
            value = "unknown" if observation.value is UNKNOWN else _value_text(observation.to_json()["value"])
            reason = thaw(observation.evidence.get("reason", ""))
            console.print(f"  {attribute:18}{value}{f'   ({reason})' if reason else ''}")
    attributes = {attribute: observation.to_json() for attribute, observation in observed.items()}
    return {"agent": agent, "object": name, "time_s": state.time_s, "attributes": attributes}


def _tell_over_time(
    recording: Recording,
    observer: Observer,
    agent: str,
    name: str,
    every_s: float,
    effect: Explanation | None,
    *,
    quiet: bool,
) -> dict[str, Any]:
    """Print the attributes over time and the effect, unless quiet; their document."""
    with progress_bar(quiet=quiet) as progress:
        line = timeline(
            recording,
            observer,
            agent=agent,
            name=name,
            every_s=every_s,
            predicates=known_predicates(),
            progress=progress,
            processes=None,
        )
    if not quiet:
        _print_timeline(line)
        _print_effect(effect)
    rows = {attribute: intervals_document(intervals) for attribute, intervals in line.rows.items()}
    gaze = [dataclasses.asdict(each) for each in line.gaze]
    document = {"agent": agent, "object": name, "every_s": every_s, "timeline": rows, "gaze": gaze}
    return {**document, "effect": _effect_document(effect)}


def _value_text(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key}: {item or 'unknown'}" for key, item in value.items())
    return f"{value:.4f}" if isinstance(value, float) else str(value)


def _print_timeline(line: Timeline) -> None:
    console.print(Text.assemble((f"{line.name} for {line.agent}", "bold"), f", sampled every {line.every_s:g} s"))
    for attribute, intervals in line.rows.items():
        if attribute.endswith(".state"):
            continue  # joint angles: --at shows them
        print_intervals(attribute, intervals)
    if line.gaze:
        console.print(Text(f"  gaze of {line.agent}, inferred", style="bold"))
    for each in line.gaze:
        least, most = (f"{math.degrees(angle_rad):.0f}" for angle_rad in each.turned_rad)
        turned = f"{most}°" if least == most else f"{least} to {most}°"
        console.print(
            f"    {each.start_s:6.2f} - {each.end_s:6.2f} s  the eyes turned {turned} towards the {each.towards}"
        )


def _print_effect(effect: Explanation | None) -> None:
    if effect is None:
        return
    agents, things = listed(effect.target_agents), listed(effect.target_objects)
    subject = f"on {'each of ' if len(effect.target_objects) > 1 else ''}{things}"
    subject += f" for {'each of ' if len(effect.target_agents) > 1 else ''}{agents}"
    console.print(
        Text.assemble(("effect", "bold"), f" of {effect.task!r} {subject}, between the label's start and end")
    )
    tree = with_predicates(STANDARD_TREE)
    for node in tree.nodes:
        if node.level < 3:
            found = effect.nodes[node.name]
            reason = thaw(found.evidence.get("reason", "")) if effect.parts else ""
            indent = "    " if node.parent is None else "      "
            value = f"unknown{f' ({reason})' if reason else ''}" if found.value is UNKNOWN else found.value
            console.print(f"{indent}{node.title} = {value}")
