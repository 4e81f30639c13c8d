"""``taskgist facts``: what can be said of a recording."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.actions import tell_actions
from taskgist.cli.common import JsonOption, RecordingArgument, about, command, console, print_json, progress_bar
from taskgist.cli.relations import intervals_document, print_intervals, tell_relations
from taskgist.common.frozen import Json, thaw
from taskgist.errors import LabelError
from taskgist.facts.predicates import Predicate, known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import TreeOf, tree_of
from taskgist.facts.values import UNKNOWN
from taskgist.language.phrases import listed
from taskgist.learning.explanation import Explanation
from taskgist.observe.attributes import snapshot
from taskgist.observe.observer import Observer
from taskgist.pipeline.explain import explain_recording
from taskgist.pipeline.kept_facts import FactsOverTime, remembered
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
    actions: Annotated[
        bool,
        typer.Option("--actions", help="What was done instead: reach, grasp, lift, carry, place, hand over, look."),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what is true for an agent, when, and what changed.

    Prints every attribute over time, and the effect between the label's start and end. With --relations: who has what
    in sight, looks at it, is near, approaches, touches and carries it, exact to the frame.

    With --actions: what everybody did with which thing, from when to when; --agent and --object choose.

    With --of performer: what the task changes for the agent that performs it (its own effort, hands, posture).

    Where the label has several target agents or objects, each agent's facts on each object are shown, and in the end
    what is the same for all of them.

    Example: taskgist facts handover.mcap

    Example: taskgist facts handover.mcap --agent giver --object baton --at 2.0

    Example: taskgist facts handover.mcap --of performer

    Example: taskgist facts handover.mcap --relations

    Example: taskgist facts handover.mcap --actions
    """
    whose = tree_of(of)
    if actions:
        given = {"--relations": relations or None, "--at": at}
        for option, value in given.items():
            if value is not None:
                raise LabelError("tells of other things than --actions", field=option, hint="leave one of both out")
        document = tell_actions(read(recording), agent, object, quiet=as_json)
        if as_json:
            print_json({"recording": str(recording), **document})
        return
    if not relations and at is None:
        asked: dict[str, Json] = {"agent": agent, "of": of, "object": object, "every_s": every}
        _tell_over_time(recording, asked, whose, as_json=as_json)
        return
    opened = read(recording)
    with about(recording, {"time_s": "--at"}):
        agents, objects = _subjects(opened, agent, object, whose)
        state = None if at is None else opened.at(at)
    observer = Observer(opened.scene, opened)
    documents: list[dict[str, Any]] = []
    for who, what in product(agents, objects):
        if relations:
            documents.append(tell_relations(opened, observer, who, what, state, quiet=as_json))
        elif state is not None:
            documents.append(_tell_instant(opened, observer, who, what, state, quiet=as_json))
    if as_json:
        print_json(documents[0] if len(documents) == 1 else _of_all(documents, None))


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


def _of_all(each: list[dict[str, Any]], effect: Explanation | None) -> dict[str, Any]:
    """The document of several agents or objects: that of each pair, and the effect that is the same for all."""
    agents, objects = (list(dict.fromkeys(document[key] for document in each)) for key in ("agent", "object"))
    return {"agents": agents, "objects": objects, "each": each, "effect": _effect_document(effect)}


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


def _tell_over_time(path: Path, asked: Mapping[str, Json], of: TreeOf, *, as_json: bool) -> None:
    """Print the attributes over time and the effect of each agent and object, or their documents."""
    predicates = known_predicates()

    def watch() -> FactsOverTime:
        return _watched(path, asked, of, predicates, quiet=as_json)

    # What a predicate of the user's own observes may hang on anything: it is asked each time.
    facts = watch() if predicates else remembered(path, asked, watch)
    own = [facts.effect.part(line.agent, line.name) if facts.effect else None for line in facts.timelines]
    if as_json:
        documents = [_timeline_document(line, effect) for line, effect in zip(facts.timelines, own, strict=True)]
        print_json(documents[0] if len(documents) == 1 else _of_all(documents, facts.effect))
        return
    for line, effect in zip(facts.timelines, own, strict=True):
        _print_timeline(line)
        _print_effect(effect)
    if facts.effect is not None and len(facts.timelines) > 1:
        _print_effect(facts.effect)


def _watched(
    path: Path, asked: Mapping[str, Any], of: TreeOf, predicates: tuple[Predicate, ...], *, quiet: bool
) -> FactsOverTime:
    """Watch a recording; with progress, unless quiet."""
    recording = read(path)
    with about(path):
        agents, objects = _subjects(recording, asked["agent"], asked["object"], of)
    observer = Observer(recording.scene, recording)
    effect = _effect(recording, agents, objects, observer)
    with progress_bar(quiet=quiet) as progress:
        lines = [
            timeline(
                recording,
                observer,
                agent=who,
                name=what,
                every_s=asked["every_s"],
                predicates=predicates,
                progress=progress,
                processes=None,
            )
            for who, what in product(agents, objects)
        ]
    return FactsOverTime(tuple(lines), effect)


def _timeline_document(line: Timeline, effect: Explanation | None) -> dict[str, Any]:
    rows = {attribute: intervals_document(intervals) for attribute, intervals in line.rows.items()}
    gaze = [dataclasses.asdict(each) for each in line.gaze]
    document = {"agent": line.agent, "object": line.name, "every_s": line.every_s, "timeline": rows, "gaze": gaze}
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
