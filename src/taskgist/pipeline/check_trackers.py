"""What trackers bring that cannot be: frames that disagree, lost trackers that go on, people off the floor.

Each check says by how much, and what would mend it:

- A thing that moves with a hand is at the hand. If it is somewhere else the whole way, the two were tracked in
  different frames; the shift that brings one to the other is found from all these moments (``disagreeing_frames``).
- Nobody stands as still as a number that is repeated (``frozen_poses``), and nothing turns to exactly the same
  orientation from one frame to the next (``lost_orientations``): lost trackers report their last pose, or none.
- People stand on the floor (``off_the_floor``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.facts import vocabulary as v
from taskgist.importing.floor import floor_problem, floor_remedy, off_the_floor_m
from taskgist.observe.frames import Interval
from taskgist.observe.holding import Hand
from taskgist.observe.observer import Observer
from taskgist.pipeline.findings import Finding, Severity, known_in, runs, some, travels, vector_text
from taskgist.recognition.turns import RESTING
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Checks, Settings
from taskgist.world.contacts import POINT_SPACING_M, hand_gap_m, hand_known, object_points
from taskgist.world.stage import Stage

LOOKS = 60
"""In as many frames at most it is looked which hands move with a thing."""
WINDOW_S = 0.2
"""Window over which velocities are measured there."""
SLOWEST_M_S = 0.15
"""What moves more slowly does not show who moves with it."""
FARTHEST_M = 2.0
"""Hands farther away than this move with a thing by chance."""
FEWEST = 5
"""As many frames at least show that a hand moves with a thing."""
SAME_SHIFT_M = 0.08
"""Shifts that differ by less are one."""
GAP_FACTOR = 3.0
"""Samples farther apart than this many usual steps do not follow each other."""
LEAST_YAW_RAD = math.radians(2.0)
SPREAD_M = 0.3
"""Places that lie within this distance do not show whether frames are turned against each other."""


def tracker_findings(recording: Recording, observer: Observer, settings: Settings = DEFAULT) -> Iterator[Finding]:
    """All of these checks.

    Args:
        recording: The recording.
        observer: One of it.
        settings: What counts.
    """
    yield from disagreeing_frames(recording, observer, settings)
    yield from frozen_poses(recording, observer, settings.checks)
    yield from lost_orientations(recording, settings.checks)
    yield from off_the_floor(recording, settings)


# --- Hands beside a thing that moves with them.


@dataclass(frozen=True, eq=False)
class Along:
    """A moment in which a hand holds a thing that moves, or moves like it.

    Attributes:
        hand: Whose, and which.
        gap_m: Between the two, metres, not negative.
        place: The thing's middle, metres, (3,).
        shift: What would bring the thing to the hand, metres, (3,).
    """

    hand: Hand
    gap_m: float
    place: Array
    shift: Array


def disagreeing_frames(recording: Recording, observer: Observer, settings: Settings = DEFAULT) -> Iterator[Finding]:
    """Hands that are away from what moves with them.

    Args:
        recording: The recording.
        observer: One of it.
        settings: Distances that count.
    """
    limits = settings.checks
    for name in recording.scene.objects:
        if not travels(recording, name):
            continue
        moments = _moving_along(recording, observer, name, limits)
        of_agent = {agent: [m for m in moments if m.hand[0] == agent] for agent in recording.scene.agents}
        of_agent = {agent: found for agent, found in of_agent.items() if len(found) >= FEWEST}
        apart = {agent: found for agent, found in of_agent.items() if _is_apart(found, limits)}
        others = [agent for agent in of_agent if agent not in apart]
        shifts = [np.median([moment.shift for moment in found], axis=0) for found in apart.values()]
        one = not others and all(np.linalg.norm(shift - shifts[0]) < SAME_SHIFT_M for shift in shifts)
        every = [moment for found in apart.values() for moment in found]
        for agent, found in apart.items():
            least_m, gap_m, most_m = _quartiles_m(found)
            sides = " and ".join(sorted({moment.hand[1] for moment in found}))
            severity: Severity = "unfit" if most_m > limits.apart_most_m else "warning"
            problem = (
                f"moves with {agent}'s {sides} hand, {100 * gap_m:.0f} cm away from it (median of {len(found)} moments"
                f", half of them {100 * least_m:.0f} to {100 * most_m:.0f} cm): their trackers' frames do not agree"
            )
            remedy = _mended(name, every) if one else _mended(agent, [_other_way(moment) for moment in found])
            yield Finding(severity, name, problem, remedy)


def _quartiles_m(moments: list[Along]) -> tuple[float, float, float]:
    least_m, median_m, most_m = np.quantile([moment.gap_m for moment in moments], (0.25, 0.5, 0.75)).tolist()
    return least_m, median_m, most_m


def _is_apart(moments: list[Along], limits: Checks) -> bool:
    """Whether hand and thing are apart all the way, or, where frames are turned against each other, on a part of it."""
    _, median_m, most_m = _quartiles_m(moments)
    return median_m > limits.apart_m or most_m > limits.apart_most_m


def _other_way(moment: Along) -> Along:
    """The shift that would bring the hand to the thing."""
    return Along(moment.hand, moment.gap_m, moment.place + moment.shift, -moment.shift)


def _mended(name: str, moments: list[Along]) -> str:
    """The transform of a source that brings things to hands, or hands to things."""
    places, shifts = np.array([moment.place for moment in moments]), np.array([moment.shift for moment in moments])
    shift = np.median(shifts, axis=0)
    left_m = float(np.median(np.linalg.norm(shifts - shift, axis=1)))
    yaw_rad, turned_shift, turned_left_m = _turned(places, places + shifts)
    if abs(yaw_rad) > LEAST_YAW_RAD and left_m > SAME_SHIFT_M / 2 and turned_left_m < left_m / 2:
        transform = f"{{ position_m = {vector_text(turned_shift)}, yaw_deg = {math.degrees(yaw_rad):.1f} }}"
        return f"give {name}'s source transform = {transform}, after the one that it has"
    if left_m > SAME_SHIFT_M and left_m > np.linalg.norm(shift) / 2:
        return f"no one shift of {name}'s source mends it ({100 * left_m:.0f} cm are left): check its axes and offset_s"
    return (
        f"give {name}'s source transform = {{ position_m = {vector_text(shift)} }}, added to what it has "
        f"({100 * left_m:.0f} cm are left)"
    )


def _turned(places: Array, wanted: Array) -> tuple[float, Array, float]:
    """The turn about the vertical and the shift that best bring places to others, and the median of what is left."""
    middle, wanted_middle = places.mean(axis=0), wanted.mean(axis=0)
    a, b = places - middle, wanted - wanted_middle
    if np.linalg.norm(np.ptp(places[:, :2], axis=0)) < SPREAD_M:
        return 0.0, wanted_middle - middle, float(np.median(np.linalg.norm(a - b, axis=1)))
    yaw_rad = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a[:, :2] * b[:, :2]).sum()))
    turn = np.array([[math.cos(yaw_rad), -math.sin(yaw_rad), 0], [math.sin(yaw_rad), math.cos(yaw_rad), 0], [0, 0, 1]])
    left_m = float(np.median(np.linalg.norm(a @ turn.T - b, axis=1)))
    return yaw_rad, wanted_middle - turn @ middle, left_m


def _moving_along(recording: Recording, observer: Observer, name: str, limits: Checks) -> list[Along]:
    """The moments in which a hand moves with a thing that rests on nothing.

    It is the hand that holds the thing; where none is near enough to hold it, the nearest of those that move like it.
    """
    times_s, stage = recording.times_s, Stage(recording.scene)
    moves = _within(times_s, [i for i in observer.motion(name).intervals if i.value == v.MOVING])
    moves &= ~_within(times_s, [i for i in observer.placement(name).intervals if i.value.symbol in RESTING])
    moves &= known_in(recording, name)
    middles = cache(lambda index: _middle(stage, recording, name, index))
    palms = cache(lambda index: _palms(stage, recording, index))
    found = []
    for index in some(np.flatnonzero(moves), LOOKS).tolist():
        holds = [hold for hold in observer.holds(float(times_s[index])) if hold.object == name]
        hands = [(hold.agent, hold.side) for hold in holds if (hold.agent, hold.side) in palms(index)]
        if not holds:
            around = _around(recording, name, index)
            hands = _like(around, times_s, middles, palms, limits) if around else []
        if hands:
            found.append(_nearest(stage, recording, name, index, hands, palms(index), middles(index)))
    return [moment for moment in found if moment.gap_m < FARTHEST_M]


def _within(times_s: Array, intervals: Iterable[Interval[Any]]) -> Mask:
    """Frames in any of these intervals, (N,)."""
    found = np.zeros(len(times_s), dtype=np.bool_)
    for interval in intervals:
        found |= (times_s >= interval.start_s) & (times_s < interval.end_s)
    return found


def _around(recording: Recording, name: str, index: int) -> tuple[int, int, int] | None:
    """Frames half a window before and after one, with it; None where the thing was not tracked there."""
    times_s = recording.times_s
    ends_s = np.clip(times_s[index] + np.array([-0.5, 0.5]) * WINDOW_S, times_s[0], times_s[-1])
    before, after = (recording.index_at(float(time_s)) for time_s in ends_s)
    return (before, index, after) if before < after and known_in(recording, name)[[before, after]].all() else None


def _like(
    around: tuple[int, int, int],
    times_s: Array,
    middles: Callable[[int], Array],
    palms: Callable[[int], dict[Hand, Array]],
    limits: Checks,
) -> list[Hand]:
    """The hands that move like a thing around a frame."""
    before, index, after = around
    seconds = float(times_s[after] - times_s[before])
    thing_m_s = (middles(after) - middles(before)) / seconds
    speed_m_s = float(np.linalg.norm(thing_m_s))
    if speed_m_s < SLOWEST_M_S:
        return []
    hands = [hand for hand in palms(index) if hand in palms(before) and hand in palms(after)]
    moving_m_s = {hand: (palms(after)[hand] - palms(before)[hand]) / seconds for hand in hands}
    return [hand for hand in hands if np.linalg.norm(moving_m_s[hand] - thing_m_s) < limits.along * speed_m_s]


def _nearest(
    stage: Stage,
    recording: Recording,
    name: str,
    index: int,
    hands: list[Hand],
    palms: dict[Hand, Array],
    middle: Array,
) -> Along:
    stage.show(recording.state(index))
    gaps_m = {
        (agent, side): max(hand_gap_m(stage, stage.scene.agent(agent).arm(side), name, limit_m=FARTHEST_M), 0.0)
        for agent, side in hands
    }
    hand = min(gaps_m, key=lambda each: gaps_m[each])
    points = object_points(stage, name, POINT_SPACING_M)
    ways = palms[hand] - (points if len(points) else middle[None])  # a palm that holds it is at its surface
    return Along(hand, gaps_m[hand], middle, ways[np.linalg.norm(ways, axis=1).argmin()])


def _middle(stage: Stage, recording: Recording, name: str, index: int) -> Array:
    stage.show(recording.state(index))
    return np.asarray(stage.geom_centers(stage.scene.geoms_of(name)).mean(axis=0))


def _palms(stage: Stage, recording: Recording, index: int) -> dict[Hand, Array]:
    """Where the palms of the tracked hands are in a frame, metres, (3,) each."""
    stage.show(recording.state(index))
    bodies = [stage.scene.agent(name) for name in stage.scene.agents]
    return {
        (body.name, arm.profile.side): stage.site(arm.palm_site).position
        for body in bodies
        for arm in body.arms
        if hand_known(stage, body, arm)
    }


# --- Trackers that were lost, and went on reporting.


def frozen_poses(recording: Recording, observer: Observer, limits: Checks) -> Iterator[Finding]:
    """People, and things that rest on nothing, whose pose stays exactly the same in the midst of a motion.

    What is lost stops or goes on from one frame to the next; what comes to rest does so by and by. People who stand
    exactly still without that are told of in a note; only simulated people and robots do so.

    Args:
        recording: The recording.
        observer: One of it.
        limits: How long counts.
    """
    if recording.provenance.simulated:
        return
    scene, times_s = recording.scene, recording.times_s
    for name in scene.agents:
        if any(arm.human_stature_m for arm in scene.agent(name).arms):
            base, joints = scene.base_slice(name), scene.joint_indices(name)
            columns = np.concatenate((np.arange(base.start, base.stop), joints))
            yield from _frozen(recording, name, columns, _seen(recording, name), limits)
    for name in scene.objects:
        free = scene.object_slice(name)
        columns, known = np.arange(free.start, free.stop), known_in(recording, name)
        if not list(_frozen(recording, name, columns, known, limits)):
            continue
        placements = observer.placement(name).intervals
        beside = [i for i in placements if i.value.symbol is None or i.value.symbol in RESTING]
        yield from _frozen(recording, name, columns, known & ~_within(times_s, beside), limits)


def _seen(recording: Recording, agent: str) -> Mask:
    """Frames in which an agent was tracked, or at least a part of it."""
    parts = [known_in(recording, f"{agent}/{part}") for part in recording.scene.parts(agent)]
    return known_in(recording, agent) & (np.any(parts, axis=0) if parts else True)


def _frozen(recording: Recording, name: str, columns: Indices, counts: Mask, limits: Checks) -> Iterator[Finding]:
    """Where these columns of the positions stay the same, in frames that count."""
    times_s = recording.times_s
    steps = np.abs(np.diff(np.asarray(recording.qpos[:, columns]), axis=0)).max(axis=1)
    steps = np.where(counts[1:] & counts[:-1], steps, np.nan)
    found = [(first, last + 1) for first, last in runs(steps == 0.0)]
    found = [span for span in found if times_s[span[1]] - times_s[span[0]] >= limits.frozen_s]
    beside = [steps[[each for each in (first - 1, last) if 0 <= each < len(steps)]] for first, last in found]
    abrupt = [bool((step > limits.abrupt).any()) for step in beside]
    spans = [span for span, sudden in zip(found, abrupt, strict=True) if sudden]
    still = not spans and name in recording.scene.agents
    spans = found if still else spans
    if not spans:
        return
    seconds = [(float(times_s[first]), float(times_s[last])) for first, last in spans]
    start_s, end_s = max(seconds, key=lambda span: span[1] - span[0])
    more = f", and {len(spans) - 1} times more" if len(spans) > 1 else ""
    problem = f"its pose is exactly the same for {end_s - start_s:.2f} s, from {start_s:.2f} to {end_s:.2f} s{more}"
    if still:
        yield Finding("note", name, f"{problem}, as nobody stands", "check that it was tracked then")
    else:
        yield Finding(
            _at_the_ends(recording, name, seconds),
            name,
            f"{problem}, in the midst of a motion: a lost tracker repeats what it saw last",
            "leave those samples empty, or drop them: what was not tracked is then unknown",
        )


def _at_the_ends(recording: Recording, name: str, spans: list[tuple[float, float]]) -> Severity:
    """Unfit where it concerns what is looked at when the label starts or ends."""
    label = recording.label
    if label is None or name not in (label.performing_agent, *label.watched, *label.target_objects):
        return "warning"
    hit = any(start_s <= time_s <= end_s for start_s, end_s in spans for time_s in (label.start_s, label.end_s))
    return "unfit" if hit else "warning"


def lost_orientations(recording: Recording, limits: Checks) -> Iterator[Finding]:
    """Things that turn from one frame to the next to the identity, or again and again to one orientation.

    Args:
        recording: The recording.
        limits: How large a turn counts.
    """
    scene, times_s = recording.scene, recording.times_s
    for name in scene.objects:
        known = np.flatnonzero(known_in(recording, name))
        wxyz = np.asarray(recording.qpos[:, scene.object_slice(name)])[known, 3:]
        if len(known) < 2:
            continue
        wxyz = wxyz * np.where(wxyz[:, :1] < 0.0, -1.0, 1.0)
        cosines = np.abs(np.sum(wxyz[1:] * wxyz[:-1], axis=1)).clip(0.0, 1.0)
        steps_s = np.diff(times_s[known])
        next_one = steps_s < GAP_FACTOR * np.median(steps_s)  # in a gap it may have turned
        jumps = np.flatnonzero((2.0 * np.arccos(cosines) > limits.turned_rad) & next_one) + 1
        lost = _landed(wxyz, jumps)
        if not lost.any():
            continue
        frames = known[lost]
        spans = [(float(times_s[frame]), float(times_s[frame])) for frame in frames]
        what = "the identity" if _is_identity(wxyz[lost][0]) else "one and the same"
        yield Finding(
            _at_the_ends(recording, name, spans),
            name,
            f"its orientation is {what} in {len(frames)} of {len(known)} frames, first at {times_s[frames[0]]:.2f} s, "
            f"and turned by {_largest_deg(cosines[jumps - 1]):.0f}° in the next: that is a lost tracker's",
            "import it with identity_is_lost = true, or leave those samples empty: they are unknown then",
        )


def _landed(wxyz: Array, jumps: Indices) -> Mask:
    """Frames with the identity, if it jumps from or to that, or with what it seldom is and jumps to again, (n,)."""
    lost = np.zeros(len(wxyz), dtype=np.bool_)
    for jump in jumps.tolist():
        for beside in (jump - 1, jump):
            same = (wxyz == wxyz[beside]).all(axis=1)
            again = beside == jump and same[jumps].sum() > 1 and same.mean() < 0.5  # how it really lies comes back, too
            if _is_identity(wxyz[beside]) or again:
                lost |= same
    return lost


def _is_identity(wxyz: Array) -> bool:
    return bool((wxyz == (1.0, 0.0, 0.0, 0.0)).all())


def _largest_deg(cosines: Array) -> float:
    return math.degrees(2.0 * math.acos(float(cosines.min())))


# --- The floor.


def off_the_floor(recording: Recording, settings: Settings = DEFAULT) -> Iterator[Finding]:
    """People under the floor, or over it.

    Args:
        recording: The recording.
        settings: Heights that count.
    """
    stage = Stage(recording.scene)
    for name in recording.scene.agents:
        height_m = off_the_floor_m(recording, name, stage, settings)
        if height_m is None:
            continue
        severity: Severity = "unfit" if abs(height_m) > settings.checks.off_floor_most_m else "warning"
        yield Finding(severity, name, floor_problem(height_m), floor_remedy(name, height_m))
