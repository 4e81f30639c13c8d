"""The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2). Compiled.

Shoulders are given in the frame of what carries the arm, x forward and z up; the right arm's azimuth is mirrored.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.perspective.candidates import Table, carry
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.geometry.linkage import POSE

ROUNDING = 1e-9
DIGITS = 6
"""Distances that agree to so many digits are equal, wherever the scene stands."""
NOWHERE = -1


def grasps_in_reach(shoulder: Array, arm: ArmIndices, centers: Array, approaches: Array, facing: float) -> Indices:
    """Indices of the grasps that one shoulder reaches, but for those from behind: nearest first, ties in their order.

    Args:
        shoulder: Its position in metres and the orientation of what carries it, a row of 12.
        arm: Length and sector.
        centers: Where the grasps are, metres, (k, 3).
        approaches: Unit directions in which the palm comes, (k, 3).
        facing: Least cosine between the approach and the direction from the shoulder to the grasp.
    """
    found, distances = _grasps_within(shoulder, arm.sector, centers, approaches, facing)
    return found[np.argsort(distances, kind="stable")]


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
        if in_reach(pose, sector, points[k]):
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
def _grasps_within(
    pose: Array, sector: Array, centers: Array, approaches: Array, facing: float
) -> tuple[Indices, Array]:
    """Indices of those grasps, and how far they are, rounded for comparing."""
    found, distances, count = np.empty(len(centers), dtype=np.intp), np.empty(len(centers)), 0
    for k in range(len(centers)):
        at_m, along = distance_m(pose, centers[k]), 0.0
        if at_m > sector[0] + ROUNDING:
            continue
        for axis in range(3):
            along += approaches[k, axis] * (centers[k, axis] - pose[axis])
        if along >= facing * at_m - ROUNDING and in_reach(pose, sector, centers[k]):
            found[count], distances[count] = k, np.rint(at_m * 10.0**DIGITS)
            count += 1
    return found[:count], distances[:count]


@compiled
def distance_m(pose: Array, point: Array) -> float:
    """How far a point is from where a pose is."""
    x, y, z = point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]
    return math.sqrt(x * x + y * y + z * z)


@compiled
def in_reach(pose: Array, sector: Array, point: Array) -> bool:
    """Whether a point lies within an arm's length of a shoulder and in its sector.

    Args:
        pose: The shoulder's position in metres and the orientation of what carries it, (12,).
        sector: Length in metres, whether it is mirrored, and lowest and highest azimuth and elevation, radians, (6,).
        point: Metres, (3,).
    """
    if distance_m(pose, point) > sector[0] + ROUNDING:
        return False
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


@compiled
def ball_around(points: Array) -> tuple[Array, float]:
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
