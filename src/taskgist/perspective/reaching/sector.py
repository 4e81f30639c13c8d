"""The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2).

Shoulders are given in the frame of what carries the arm, x forward and z up; the right arm's azimuth is mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Table, carry
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.judge import Miss
from taskgist.world import Arm, ArmIndices
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.linkage import POSE

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
ROUNDING = 1e-9
DIGITS = 6
"""Distances that agree to so many digits are equal, wherever the scene stands."""
NOWHERE = -1


def out_of_reach(arm: Arm, shoulder: Array, points: Array) -> Miss:
    """Why an arm reaches none of some points, (k, 3), from a shoulder, (3,)."""
    gap_m = float(np.linalg.norm(points - shoulder, axis=1).min())
    if gap_m <= arm.length_m:
        return Miss(0.0, f"outside the sector of the {arm.side} arm", lambda: {"arm": arm.side})
    beyond_m = gap_m - arm.length_m
    far = f"{beyond_m:.2f} m" if beyond_m >= 0.005 else f"{1000 * beyond_m:.1f} mm"
    why = f"{gap_m:.2f} m from the {arm.side} shoulder, {far} beyond the arm"
    return Miss(beyond_m, why, lambda: {"arm": arm.side, "beyond_m": beyond_m})


def arms_of(here: Standpoint) -> tuple[int, ...]:
    """Indices of the agent's arms that may be stretched out."""
    arms = here.agent.arms
    return tuple(index for index, arm in enumerate(arms) if stretch(arm.profile.side) in here.actions)


@dataclass(frozen=True, eq=False)
class Cloud:
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
    def of(cls, points: Array) -> Cloud:
        """The cloud of some points, (k, 3)."""
        return cls(points, *_ball(points))


@compiled
def _ball(points: Array) -> tuple[Array, float]:
    """Middle of the box around some points, and how far the farthest is from it."""
    low, high, squared = np.full(3, np.inf), np.full(3, -np.inf), 0.0
    if not len(points):
        return np.zeros(3), 0.0
    for k in range(len(points)):
        for axis in range(3):
            low[axis], high[axis] = min(low[axis], points[k, axis]), max(high[axis], points[k, axis])
    middle = (low + high) / 2
    for k in range(len(points)):
        x, y, z = points[k, 0] - middle[0], points[k, 1] - middle[1], points[k, 2] - middle[2]
        squared = max(squared, x * x + y * y + z * z)
    return middle, math.sqrt(squared)


def grasps_in_reach(shoulder: Array, arm: ArmIndices, centers: Array, approaches: Array, facing: float) -> Indices:
    """Indices of the grasps that one shoulder reaches, but for those from behind: nearest first, ties in their order.

    Args:
        shoulder: Its position in metres and the orientation of what carries it, a row of 12.
        arm: Length and sector.
        centers: Where the grasps are, metres, (k, 3).
        approaches: Unit directions in which the palm comes, (k, 3).
        facing: Least cosine between the approach and the direction from the shoulder to the grasp.
    """
    return _nearest_first(shoulder, arm.sector, centers, approaches, facing)


@compiled
def first_in_reach(
    table: Table,
    shoulders: Indices,
    sectors: Array,
    points: Array,
    middle: Array,
    radius_m: float,
    start: int,
    stop: int,
    nearest: Indices,
    reach_m: Array,
    missed: Indices,
    gap_m: Array,
) -> int:
    """The first of some stances from which an arm reaches one of some points; ``stop`` if there is none.

    Args:
        table: The stances.
        shoulders: Which frame each arm's shoulder is, (a,).
        sectors: Of these arms, (a, 6).
        points: Metres, (k, 3).
        middle: Centre of a ball that holds the points, (3,).
        radius_m: Its radius.
        start: From which stance on,
        stop: and before which.
        nearest: Written, for the stance found: the nearest point that each arm reaches, −1 for none, (a,); of equally
            near ones the first.
        reach_m: Written: how far it is, (a,).
        missed: Kept up to date: of the stances passed over, the one from which each arm misses the points least, (a,).
        gap_m: Kept up to date: how far its shoulder is from the nearest point then, (a,).
    """
    pose, gaps = np.empty(POSE), np.empty(len(shoulders))
    for i in range(start, stop):
        able = False
        for arm in range(len(shoulders)):
            carry(table, i, shoulders[arm], pose)
            nearest[arm], gaps[arm] = NOWHERE, np.inf
            ball_m = distance_m(pose, middle) - radius_m
            if ball_m <= sectors[arm, 0] + ROUNDING or ball_m <= gap_m[arm]:
                nearest[arm], reach_m[arm], gaps[arm] = _nearest(pose, sectors[arm], points)
            able |= nearest[arm] != NOWHERE
        if able:
            return i
        for arm in range(len(shoulders)):
            if gaps[arm] < gap_m[arm]:
                missed[arm], gap_m[arm] = i, gaps[arm]
    return stop


@compiled
def _nearest(pose: Array, sector: Array, points: Array) -> tuple[int, float, float]:
    """The nearest point that a shoulder reaches, −1 for none; how far it is; and how far the nearest of all is."""
    nearest, reach_m, least_m, gap_m = NOWHERE, np.inf, np.inf, np.inf
    for k in range(len(points)):
        at_m = distance_m(pose, points[k])
        gap_m = min(gap_m, at_m)
        if at_m > sector[0] + ROUNDING or round(at_m, DIGITS) >= least_m:
            continue
        if _inside(pose, sector, points[k]):
            nearest, reach_m, least_m = k, at_m, round(at_m, DIGITS)
    return nearest, reach_m, gap_m


@compiled
def beyond(
    table: Table, shoulders: Indices, sectors: Array, points: Array, middle: Array, radius_m: float, margin_m: float
) -> bool:
    """Whether all points are farther than a margin beyond every arm, from every stance; for what is given see above."""
    pose = np.empty(POSE)
    for i in range(len(table.spot)):
        for arm in range(len(shoulders)):
            carry(table, i, shoulders[arm], pose)
            far_m = sectors[arm, 0] + margin_m
            if distance_m(pose, middle) - radius_m > far_m:
                continue
            for k in range(len(points)):
                if distance_m(pose, points[k]) <= far_m:
                    return False
    return True


@compiled
def _nearest_first(pose: Array, sector: Array, centers: Array, approaches: Array, facing: float) -> Indices:
    found, distances, count = np.empty(len(centers), dtype=np.intp), np.empty(len(centers)), 0
    for k in range(len(centers)):
        at_m, along = distance_m(pose, centers[k]), 0.0
        if at_m > sector[0] + ROUNDING:
            continue
        for axis in range(3):
            along += approaches[k, axis] * (centers[k, axis] - pose[axis])
        if along >= facing * at_m - ROUNDING and _inside(pose, sector, centers[k]):
            found[count], distances[count] = k, np.rint(at_m * 10.0**DIGITS)
            count += 1
    return found[np.argsort(distances[:count], kind="mergesort")]


@compiled
def distance_m(pose: Array, point: Array) -> float:
    """How far a point is from where a pose is."""
    x, y, z = point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]
    return math.sqrt(x * x + y * y + z * z)


@compiled
def _inside(pose: Array, sector: Array, point: Array) -> bool:
    """Whether a point lies in the direction of a sector from a shoulder, whose carrier is turned as in a pose."""
    dx, dy, dz = point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]
    x = dx * pose[3] + dy * pose[6] + dz * pose[9]
    y = dx * pose[4] + dy * pose[7] + dz * pose[10]
    z = dx * pose[5] + dy * pose[8] + dz * pose[11]
    azimuth = math.atan2(-y if sector[1] else y, x)
    elevation = math.atan2(z, math.hypot(x, y))
    return bool(
        sector[2] - ROUNDING <= azimuth <= sector[3] + ROUNDING
        and sector[4] - ROUNDING <= elevation <= sector[5] + ROUNDING
    )
