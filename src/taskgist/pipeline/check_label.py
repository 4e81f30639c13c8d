"""What happens in a recording, and what its label says of it: roles, start, end, and facts that are unknown there.

The label is held against who has the thing when (``recognition.turns``), as it is inferred from the whole recording.
Who is said to give and who has the thing first must be the same; what travels is held by somebody; what has been given
or put down is not in the air; and what happens has begun and ended within the recording.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product

import numpy as np

from taskgist.common.arrays import Indices
from taskgist.facts import vocabulary as v
from taskgist.facts.values import UNKNOWN, Observation, Raw
from taskgist.observe.attributes import snapshot
from taskgist.observe.evidence import GRAVITY_M_S2, acceleration_m_s2
from taskgist.observe.observer import Observer
from taskgist.pipeline.findings import Finding, known_in, travels
from taskgist.recognition.turns import GIVING, Change, Turn, changes_of_hands, turns_of
from taskgist.recording.recording import Label, Recording
from taskgist.settings import Settings
from taskgist.world.contacts import hand_gap_m, hand_known
from taskgist.world.stage import Stage

OF_THE_AGENT = frozenset({"posture", "hands"})
"""Attributes of the target agent alone; all others are said of the object."""
FARTHEST_M = 3.0
"""Beyond this, gaps to hands are not measured."""
ROUNDING_S = 1e-6
BY_HAND = "set it right: taskgist label RECORDING"


def label_findings(recording: Recording, observer: Observer, settings: Settings) -> Iterator[Finding]:
    """All of these checks; without a label, only what travels by itself is told.

    Args:
        recording: The recording.
        observer: One of it.
        settings: What counts.
    """
    label = recording.label
    if label is None:
        yield Finding("unfit", "label", "there is none", "set one: taskgist label RECORDING --help")
    for name in label.target_objects if label else recording.scene.objects:
        yield from travels_alone(recording, observer, name, settings)
    if label is None:
        return
    for name in label.target_objects:
        turns = turns_of(observer, name)
        yield from roles(label, name, turns, changes_of_hands(observer, name, turns))
        yield from begins(recording, label, observer, name, settings)
        yield from ends_in_the_air(recording, label, observer, name)
        yield from ends_with_the_file(recording, label, observer, name, turns, settings)
    yield from unknown_facts(recording, label, observer, settings)


# --- Who has it.


def roles(label: Label, name: str, turns: tuple[Turn, ...], changes: tuple[Change, ...]) -> Iterator[Finding]:
    """Whether the performing agent has the thing, and gives it to the target agent, where the task says so.

    Args:
        label: The label.
        name: One of its objects.
        turns: Who has it when.
        changes: When it changes hands.
    """
    performer, targets = label.performing_agent, label.target_agents
    within = [turn for turn in turns if turn.start_s <= label.end_s + ROUNDING_S and turn.end_s > label.start_s]
    who = " and ".join(dict.fromkeys(turn.agent for turn in within))
    if not targets or label.task.lower() not in GIVING:
        if within and not any(turn.agent == performer for turn in within):
            yield Finding(
                "warning",
                "label",
                f"{performer} is said to {label.task}, but only {who} has {name}, from {within[0].start_s:.2f} s on",
                f"if that was not meant: {BY_HAND} --performer {within[0].agent}",
            )
        return
    given = [c for c in changes if c.giver == performer and c.taker in targets and c.taken_s < label.end_s + 1.0]
    given = [change for change in given if change.kept_s > label.start_s]
    taken = [c for c in changes if c.taker == performer and c.giver in targets]
    taken = [change for change in taken if label.start_s < change.time_s < label.end_s + 1.0]
    if taken and not given:
        change = taken[0]
        yield Finding(
            "unfit",
            "label",
            f"{performer} is said to give {name} to {change.giver}, but {change.giver} has it first, and {performer} "
            f"takes it at {change.time_s:.2f} s",
            f"{BY_HAND} --performer {change.giver} --target {performer}",
        )
    elif given and label.end_s < given[-1].taken_s - ROUNDING_S:
        change = given[-1]
        yield Finding(
            "unfit",
            "label",
            f"it ends {change.taken_s - label.end_s:.2f} s before {change.taker} has {name}",
            f"{BY_HAND} --end {change.time_s:.2f}",
        )
    elif within and not any(turn.agent == performer for turn in within):
        yield Finding(
            "unfit",
            "label",
            f"{performer} is said to give {name}, but only {who} has it, from {within[0].start_s:.2f} s on",
            "name who gives (--performer) and who takes (--target), or label where both have it",
        )
    elif given and not any(turn.agent in targets and turn.end_s >= label.end_s for turn in within):
        change = given[-1]
        yield Finding(
            "warning",
            "label",
            f"{change.taker} no longer has {name} at its end: only from {change.taken_s:.2f} to {change.kept_s:.2f} s",
            f"{BY_HAND} --end {change.time_s:.2f}",
        )


# --- What travels.


def travels_alone(recording: Recording, observer: Observer, name: str, settings: Settings) -> Iterator[Finding]:
    """Whether a thing travels and nobody holds it, other than in free flight.

    Args:
        recording: The recording.
        observer: One of it.
        name: The thing.
        settings: How long counts.
    """
    if not travels(recording, name):
        return
    label, times_s = recording.label, recording.times_s
    from_s, until_s = (label.start_s, label.end_s) if label else (float(times_s[0]), float(times_s[-1]))
    moving = [i for i in observer.motion(name).intervals if i.value == v.MOVING]
    moving_s = sum(max(min(i.end_s, until_s) - max(i.start_s, from_s), 0.0) for i in moving)
    for placed in observer.placement(name).intervals:
        if placed.value.symbol != v.IN_AIR:
            continue
        for interval in moving:
            start_s = max(interval.start_s, placed.start_s, from_s)
            end_s = min(interval.end_s, placed.end_s, until_s)
            frames = np.flatnonzero((times_s >= start_s) & (times_s <= end_s) & known_in(recording, name))
            if end_s - start_s < settings.checks.travels_s or _flies(recording, name, frames, settings):
                continue
            places = recording.qpos[:, recording.scene.object_slice(name)][frames, :3]
            way_m = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
            yield Finding(
                "unfit" if end_s - start_s > moving_s / 2 else "warning",
                name,
                f"travels {way_m:.2f} m from {start_s:.2f} to {end_s:.2f} s, and nobody holds it"
                f"{_nearest(recording, name, int(frames[len(frames) // 2]))}",
                "check units, axes, transform and offset_s of the sources, and that the hand that holds it is mapped",
            )


def _flies(recording: Recording, name: str, frames: Indices, settings: Settings) -> bool:
    """Whether it falls or flies freely between these frames."""
    places = recording.qpos[:, recording.scene.object_slice(name)][frames, :3]
    acceleration = acceleration_m_s2(recording.times_s[frames].tolist(), np.asarray(places))
    if acceleration is None:
        return False
    return bool(np.linalg.norm(acceleration - GRAVITY_M_S2) < settings.carrying.fall_m_s2)


def _nearest(recording: Recording, name: str, index: int) -> str:
    """The hand that is nearest to a thing in a frame, as a clause."""
    stage = Stage(recording.scene, recording.state(index))
    gaps = [
        (hand_gap_m(stage, arm, name, limit_m=FARTHEST_M), f"{agent}'s {arm.profile.side} hand")
        for agent in stage.scene.agents
        for arm in stage.scene.agent(agent).arms
        if hand_known(stage, stage.scene.agent(agent), arm)
    ]
    if not gaps:
        return ""
    gap_m, whose = min(gaps)
    away = f"{gap_m:.2f} m" if gap_m < FARTHEST_M else f"more than {FARTHEST_M:g} m"
    return f"; the nearest, {whose}, is {away} away in the middle"


# --- Both ends.


def begins(recording: Recording, label: Label, observer: Observer, name: str, settings: Settings) -> Iterator[Finding]:
    """Whether the thing is still at rest when the label starts.

    Args:
        recording: The recording.
        label: Its label.
        observer: One of it.
        name: One of the label's objects.
        settings: What is too late.
    """
    first_s, late_s = float(recording.times_s[0]), settings.checks.begins_s
    soon_s = max(label.start_s, first_s + late_s)
    moving = [i for i in observer.motion(name).intervals if i.value == v.MOVING]
    moving = [i for i in moving if i.start_s <= label.start_s < i.end_s or label.start_s < i.start_s < soon_s]
    if not moving:
        return
    began_s = moving[0].start_s
    if began_s - first_s < late_s:
        when = "in its first frame" if began_s <= first_s else f"{began_s - first_s:.2f} s after its first frame"
        yield Finding(
            "warning",
            "label",
            f"the recording begins too late: {name} moves already {when}, and what was before is not seen",
            "record from before it is touched; what is learned of the start is that of a thing under way",
        )
    else:
        yield Finding(
            "note",
            "label",
            f"{name} is already moving at the start, since {began_s:.2f} s",
            f"start the label earlier: --start {max(began_s - 0.3, first_s):.2f}",
        )


def ends_in_the_air(recording: Recording, label: Label, observer: Observer, name: str) -> Iterator[Finding]:
    """Whether the thing is held by nobody and rests on nothing when the label ends.

    Args:
        recording: The recording.
        label: Its label.
        observer: One of it.
        name: One of the label's objects.
    """
    placed = observer.placement(name).at(label.end_s)
    if placed is None or placed.symbol != v.IN_AIR:
        return
    index = recording.index_at(label.end_s)
    stage = Stage(recording.scene, recording.state(index))
    lowest = stage.bounds(stage.scene.solid_geoms_of(name))[0]
    still = observer.motion(name).at(label.end_s) == v.STATIC
    remedy = "move the end to where somebody holds it or it rests: taskgist label RECORDING --end"
    if still:
        remedy = f"if something stands there, add it as a support with its top at z = {lowest[2]:.2f} m; else {remedy}"
    where = f"{'stands still' if still else 'moves'} in the air, {lowest[2]:.2f} m above z = 0"
    yield Finding(
        "unfit", name, f"{where}, at the label's end ({label.end_s:.2f} s){_nearest(recording, name, index)}", remedy
    )


def ends_with_the_file(
    recording: Recording, label: Label, observer: Observer, name: str, turns: tuple[Turn, ...], settings: Settings
) -> Iterator[Finding]:
    """Whether what happens has come to its end before the recording does.

    Args:
        recording: The recording.
        label: Its label.
        observer: One of it.
        name: One of the label's objects.
        turns: Who has it when.
        settings: How long what is confirmed must last.
    """
    last_s = float(recording.times_s[-1])
    left_s = last_s - label.end_s
    if left_s > settings.timing.minimum_s - ROUNDING_S:
        return
    moves = observer.motion(name).at(label.end_s) == v.MOVING
    has = next((turn.agent for turn in turns if turn.start_s <= label.end_s <= turn.end_s + ROUNDING_S), None)
    unfinished = moves and has == label.performing_agent
    yield Finding(
        "unfit" if unfinished else "warning",
        "label",
        f"the recording ends {left_s:.2f} s after it, "
        + (
            f"while {has} still moves {name}"
            if unfinished
            else f"less than the {settings.timing.minimum_s:g} s that confirm"
        ),
        "record until it is done, and half a second longer"
        if unfinished
        else "record half a second longer, or end it earlier",
    )


# --- What is unknown there.


def unknown_facts(recording: Recording, label: Label, observer: Observer, settings: Settings) -> Iterator[Finding]:
    """Which facts are unknown at the label's ends.

    Args:
        recording: The recording.
        label: Its label.
        observer: One of it.
        settings: All settings.
    """
    stage = Stage(recording.scene)
    ends = (("start", label.start_s), ("end", label.end_s))
    for (end, time_s), (agent, thing) in product(ends, label.pairs):
        stage.show(recording.at(time_s))
        observed = snapshot(stage, observer, agent=agent, name=thing, settings=settings)
        several = len(label.pairs) > 1
        unknown = [name for name, observation in observed.items() if _is_unknown(observation)]
        if set(observed) - OF_THE_AGENT <= set(unknown):
            yield Finding(
                "unfit",
                thing,
                f"no fact can be said of it{f' for {agent}' if several else ''} at the label's {end} ({time_s:.2f} s)",
                "move the label to where object and target agent are tracked",
            )
        elif unknown:
            whose = f" of {thing} for {agent}" if several else ""
            yield Finding(
                "note", f"facts{whose} at the label's {end}", f"unknown: {', '.join(unknown)}", "they are not counted"
            )


def _is_unknown(observation: Observation[Raw]) -> bool:
    value = observation.value
    return value is UNKNOWN or (isinstance(value, Mapping) and all(status is None for status in value.values()))
