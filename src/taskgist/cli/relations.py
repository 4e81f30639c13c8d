"""Relations of a recording as ``taskgist facts --relations`` tells them, and how it tells intervals."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from rich.text import Text

from taskgist.cli.common import console, progress_bar
from taskgist.facts.values import UNKNOWN, Observation
from taskgist.observe.frames import Interval
from taskgist.observe.observer import Observer
from taskgist.observe.relations import distance, distance_change
from taskgist.observe.relations_over_time import Relations, RelationsOverTime, relations_of
from taskgist.perspective.effort import assumed_gaze
from taskgist.recording.recording import Recording
from taskgist.world.stage import Stage
from taskgist.world.state import State


def tell_relations(
    recording: Recording, observer: Observer, agent: str, name: str, state: State | None, *, quiet: bool
) -> dict[str, Any]:
    """Print the relations between an agent and an object: over time, or in one state with what they stand on.

    Args:
        recording: The recording.
        observer: One of it.
        agent: From whose view.
        name: The object.
        state: The only state that is asked for.
        quiet: Print nothing.

    Returns:
        The document that says the same.
    """
    if state is not None:
        return _tell_moment(agent, name, state.time_s, _of_moment(recording, observer, agent, name, state), quiet=quiet)
    with progress_bar(quiet=quiet) as progress:
        rows = RelationsOverTime(observer, recording, progress=progress).of(agent, name)
    change = _distance_change(recording, agent, name)
    if not quiet:
        console.print(Text.assemble((f"{name} and {agent}", "bold"), ", exact to the frame"))
        for relation, intervals in rows.items():
            print_intervals(relation, intervals)
        if change:
            console.print(f"  between the label's start and end the distance: {change}")
    relations = {relation: intervals_document(intervals) for relation, intervals in rows.items()}
    return {"agent": agent, "object": name, "relations": relations, "distance_change": change}


def intervals_document(intervals: Iterable[Interval[Any]]) -> list[dict[str, Any]]:
    """Intervals as documents have them."""
    return [{"value": i.value, "start_s": round(i.start_s, 4), "end_s": round(i.end_s, 4)} for i in intervals]


def print_intervals(title: str, intervals: Iterable[Interval[Any]]) -> None:
    """Print the intervals of one fact below its title."""
    console.print(Text(f"  {title}", style="bold"))
    for i in intervals:
        console.print(f"    {i.start_s:6.2f} - {i.end_s:6.2f} s  {_text(i.value)}")


def _text(value: str | bool | None) -> str:
    if value is None:
        return "unknown"
    return value if isinstance(value, str) else "yes" if value else "no"


def _of_moment(recording: Recording, observer: Observer, agent: str, name: str, state: State) -> Relations:
    """What is so in one state, and, as confirmed by then, what needs time."""
    found = relations_of(Stage(recording.scene, observer.as_confirmed(state)), agent, name)
    for relation, value in RelationsOverTime(observer, recording).at(agent, name, state.time_s).items():
        found.setdefault(relation, Observation(UNKNOWN if value is None else value))
    return found


def _tell_moment(agent: str, name: str, time_s: float, found: Relations, *, quiet: bool) -> dict[str, Any]:
    if not quiet:
        console.print(Text(f"{name} and {agent} at {time_s:.2f} s", style="bold"))
        for relation, observation in found.items():
            value = None if observation.value is UNKNOWN else observation.value
            shown = _evidence_text(observation.to_json()["evidence"])
            console.print(f"  {relation:22}{_text(value)}{f'   ({shown})' if shown else ''}")
    relations = {relation: observation.to_json() for relation, observation in found.items()}
    return {"agent": agent, "object": name, "time_s": time_s, "relations": relations}


def _evidence_text(evidence: Any) -> str:
    parts = []
    if "share" in evidence:
        parts.append(f"{evidence['share']:.0%} in sight")
        parts += [f"{owner} hides {share:.0%}" for owner, share in evidence["blockers"].items()]
    if "metres" in evidence:
        parts.append(f"{evidence['metres']:.2f} m")
    if "bearing_rad" in evidence:
        bearing = math.degrees(evidence["bearing_rad"])
        parts.append(f"{abs(bearing):.0f}° to the {'right' if bearing < 0 else 'left'}")
    if evidence.get("off_rad") is not None:
        parts.append(f"{math.degrees(evidence['off_rad']):.0f}° beside the gaze")
    if "eyes_towards" in evidence:
        parts.append(assumed_gaze(evidence["eyes_towards"], evidence["eyes_rad"]))
    return ", ".join(parts)


def _distance_change(recording: Recording, agent: str, name: str) -> str | None:
    """How the distance changed between the label's start and end; None without a label, or where it is unknown."""
    label = recording.label
    if label is None:
        return None
    stage = Stage(recording.scene)
    before = distance(stage.show(recording.at(label.start_s)), agent, name)
    after = distance(stage.show(recording.at(label.end_s)), agent, name)
    return None if before is None or after is None else distance_change(before, after)
