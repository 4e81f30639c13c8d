"""Which of some points arms reach, from one candidate after another, and with a free way. Compiled; see ``arms``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.arms import ROUNDING, Arms, Around, arms_of, distance_m, free_configuration, in_reach
from taskgist.perspective.candidates import Table, carry
from taskgist.perspective.target import ball_around
from taskgist.settings import DEFAULT, ReachModel
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.geometry.linkage import POSE

DIGITS = 6
"""Distances that agree to so many digits are equal, wherever the scene stands."""
NOWHERE = -1
TRIES = 8
"""Points of an object that are tried where its nearest one is out of the arm's way: spread by their distance (ours)."""


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Points, and a ball around them: those far from it need not be looked at one by one.

    Attributes:
        points: Metres, in the world, (k, 3).
        middle: Centre of the ball, (3,).
        radius_m: Its radius.
    """

    points: Array
    middle: Array
    radius_m: float

    @classmethod
    def of(cls, points: Array) -> PointCloud:
        """The cloud of some points, (k, 3)."""
        return cls(points, *ball_around(points))


def grasps_in_reach(
    shoulder: Array,
    arm: ArmIndices,
    centers: Array,
    approaches: Array,
    facing: float,
    *,
    model: ReachModel = DEFAULT.reach.model,
) -> Indices:
    """Indices of the grasps that one shoulder reaches, but for those from behind: nearest first, ties in their order.

    Args:
        shoulder: Its position in metres and the orientation of what carries it, a row of 12.
        arm: What reaches.
        centers: Where the grasps are, metres, (k, 3).
        approaches: Unit directions in which the palm comes, (k, 3).
        facing: Least cosine between the approach and the direction from the shoulder to the grasp.
        model: How reach is judged, ``settings.reach.model``; what is in the way is left aside.
    """
    found, distances = _grasps_within(shoulder, arms_of((arm,), model), centers, approaches, facing)
    return found[np.argsort(distances, kind="stable")]


@compiled
def first_in_reach(
    table: Table,
    shoulders: Indices,
    once: int,
    arms: Arms,
    around: Around,
    points: Array,
    middle: Array,
    radius_m: float,
    start: int,
    stop: int,
    pausing: bool,
    nearest: Indices,
    reach_m: Array,
    missed: Indices,
    gap_m: Array,
    blocked: Indices,
) -> tuple[int, bool]:
    """The first of some candidates from which an arm reaches one of some points; ``stop`` if there is none.

    Args:
        table: The candidates.
        shoulders: Which frame each arm's shoulder is, (a,). Arms may come twice, the second time with their shoulders
            thrust forward: that is tried where they are too short otherwise, not where something is in the way.
        once: How many arms there are.
        arms: These arms.
        around: What may be in their way.
        points: Metres, (k, 3).
        middle: Centre of a ball that holds the points, (3,).
        radius_m: Its radius.
        start: From which candidate on,
        stop: and before which.
        pausing: Whether to end at the first candidate as well from which only what is in the way keeps an arm.
        nearest: Written, for the candidate found: the nearest point that each arm reaches, −1 for none, (a,); of
            equally near ones the first.
        reach_m: Written: how far it is, (a,).
        missed: Kept up to date: of the candidates passed over, the one from which each arm misses least, (a,).
        gap_m: Kept up to date: how far its shoulder is from the nearest point then, (a,).
        blocked: Kept up to date: the first of them from which only what is in its way keeps each arm, −1 for none,
            (a,).

    Returns:
        Which it is, and whether any arm reaches.
    """
    pose, gaps = np.empty(POSE), np.empty(len(shoulders))
    met, within = np.zeros(len(around.solids), dtype=np.intp), np.zeros(len(shoulders), dtype=np.bool_)
    for i in range(start, stop):
        able, pause = False, False
        for arm in range(len(shoulders)):
            nearest[arm], gaps[arm] = NOWHERE, np.inf
            if once <= arm and within[arm - once]:
                continue
            within[arm] = False
            carry(table, i, shoulders[arm], pose)
            ball_m = distance_m(pose, middle) - radius_m
            if ball_m > arms.sectors[arm, 0] + ROUNDING and ball_m > gap_m[arm]:
                continue
            found, reach_m[arm], gaps[arm] = _nearest(pose, arms, arm, points)
            within[arm] = found != NOWHERE
            nearest[arm] = _free_point(pose, arms, arm, points, found, around, met)
            if nearest[arm] != NOWHERE:
                reach_m[arm], able = distance_m(pose, points[nearest[arm]]), True
            elif found != NOWHERE and blocked[arm] == NOWHERE:
                blocked[arm], pause = i, pausing
        if able or pause:
            return i, able
        for arm in range(len(shoulders)):
            if gaps[arm] < gap_m[arm]:
                missed[arm], gap_m[arm] = i, gaps[arm]
    return stop, False


@compiled_part
def _nearest(pose: Array, arms: Arms, arm: int, points: Array) -> tuple[int, float, float]:
    """The nearest point that a shoulder reaches, −1 for none; how far it is; and how far the nearest of all is."""
    nearest, reach_m, least_m, gap_m = NOWHERE, np.inf, np.inf, np.inf
    for k in range(len(points)):
        at_m = distance_m(pose, points[k])
        gap_m = min(gap_m, at_m)
        if at_m > arms.sectors[arm, 0] + ROUNDING or round(at_m, DIGITS) >= least_m:
            continue
        if in_reach(pose, arms, arm, points[k]):
            nearest, reach_m, least_m = k, at_m, round(at_m, DIGITS)
    return nearest, reach_m, gap_m


@compiled
def _free_point(pose: Array, arms: Arms, arm: int, points: Array, nearest: int, around: Around, met: Indices) -> int:
    """Of the points that an arm reaches, given the nearest or −1, the nearest with a free way; −1 if none has."""
    if nearest == NOWHERE or not around.asked:
        return nearest
    if free_configuration(pose, arms, arm, points[nearest], around, met) >= 0:
        return nearest
    inside, away, count = np.empty(len(points), dtype=np.intp), np.empty(len(points)), 0
    for k in range(len(points)):
        if in_reach(pose, arms, arm, points[k]):
            inside[count], away[count] = k, round(distance_m(pose, points[k]), DIGITS)
            count += 1
    tries, order = min(count, TRIES), np.argsort(away[:count], kind="mergesort")
    for t in range(1, tries):
        k = inside[order[t if count <= TRIES else t * (count - 1) // (TRIES - 1)]]
        if free_configuration(pose, arms, arm, points[k], around, met) >= 0:
            return int(k)
    return NOWHERE


@compiled
def beyond(
    table: Table, shoulders: Indices, arms: Arms, points: Array, middle: Array, radius_m: float, margin_m: float
) -> bool:
    """Whether all points are farther than a margin beyond every arm, from every candidate; arguments as above."""
    pose = np.empty(POSE)
    for i in range(len(table.spot)):
        for arm in range(len(shoulders)):
            carry(table, i, shoulders[arm], pose)
            far_m = arms.sectors[arm, 0] + margin_m
            if distance_m(pose, middle) - radius_m > far_m:
                continue
            for k in range(len(points)):
                if distance_m(pose, points[k]) <= far_m:
                    return False
    return True


@compiled
def _grasps_within(pose: Array, arms: Arms, centers: Array, approaches: Array, facing: float) -> tuple[Indices, Array]:
    """Indices of those grasps of the one arm, and how far they are, rounded for comparing."""
    found, distances, count = np.empty(len(centers), dtype=np.intp), np.empty(len(centers)), 0
    for k in range(len(centers)):
        at_m, along = distance_m(pose, centers[k]), 0.0
        if at_m > arms.sectors[0, 0] + ROUNDING:
            continue
        for axis in range(3):
            along += approaches[k, axis] * (centers[k, axis] - pose[axis])
        if along >= facing * at_m - ROUNDING and in_reach(pose, arms, 0, centers[k]):
            found[count], distances[count] = k, np.rint(at_m * 10.0**DIGITS)
            count += 1
    return found[:count], distances[:count]
