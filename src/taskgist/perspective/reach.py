"""Reach: some cell of the object is within the arm's length of the shoulder and inside its sector (5.1.2).

A rough reach, as people perceive it: head, torso and base must not collide, the arm is not looked at. Who holds the
object reaches it without effort. An arm that was not tracked can be stretched out all the same, for its shoulder
hangs on the torso; only whether its hand holds the object is then unknown, unless the object is farther away than the
whole arm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.candidates import Candidates, Table, carry
from taskgist.perspective.effort import Held, Miss, OutOfReach, Quantity, Reached, Reason, stretch
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Screening, Viewpoint
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.profile import Arm
from taskgist.world.contacts import hand_known
from taskgist.world.geometry.linkage import POSE

# --- The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2). Compiled.
#
# Shoulders are given in the frame of what carries the arm, x forward and z up; the right arm's azimuth is mirrored.

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
    """The first of some candidates from which an arm reaches one of some points; ``stop`` if there is none.

    Args:
        table: The candidates.
        shoulders: Which frame each arm's shoulder is, (a,).
        sectors: Of these arms, (a, 6).
        points: Metres, (k, 3).
        middle: Centre of a ball that holds the points, (3,).
        radius_m: Its radius.
        start: From which candidate on,
        stop: and before which.
        nearest: Written, for the candidate found: the nearest point that each arm reaches, −1 for none, (a,); of
            equally near ones the first.
        reach_m: Written: how far it is, (a,).
        missed: Kept up to date: of the candidates passed over, the one from which each arm misses least, (a,).
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


@compiled_part
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
    """Whether all points are farther than a margin beyond every arm, from every candidate; arguments as above."""
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


@compiled_part
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


def out_of_reach(arm: Arm, shoulder: Array, points: Array) -> Miss:
    """Why an arm reaches none of some points, (k, 3), from a shoulder, (3,)."""
    gap_m = float(np.linalg.norm(points - shoulder, axis=1).min())
    if gap_m <= arm.length_m:
        text = f"outside the sector of the {arm.side} arm"
        return Miss(Reason.OUT_OF_SECTOR, text, hindrance=OutOfReach(arm.side))
    beyond_m = gap_m - arm.length_m
    far = f"{beyond_m:.2f} m" if beyond_m >= 0.005 else f"{1000 * beyond_m:.1f} mm"
    text = f"{gap_m:.2f} m from the {arm.side} shoulder, {far} beyond the arm"
    return Miss(Reason.TOO_FAR, text, Quantity(beyond_m, "m"), OutOfReach(arm.side, beyond_m))


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


# --- What the judges of reach and grasp share: arms that are stretched out, and level 0, which is holding.
#
# Only the agent's own hands matter. One that was not tracked leaves it unknown, unless the object rests on something
# or is farther away than the whole arm.

WHOLE_ARM = 1.25
"""A hand holds nothing farther from its shoulder than this times the arm's length (ours; a human's is 1.1)."""
PARTS: tuple[tuple[str, ...], ...] = ((), ("torso",), ("torso",), ("torso", "legs"), ("torso", "legs"))
"""Parts that must be tracked to judge each level."""
NO_ARM = Miss(Reason.NO_ARM, "no arm may be stretched out")
NO_SURFACE = Miss(Reason.NO_SURFACE, "has no surface")
NOT_HELD = Miss(Reason.NOT_HELD, "not held")


def usable_arms(here: Viewpoint) -> tuple[tuple[int, ...], Array]:
    """The arms that an agent may stretch out: their indices, and lengths and sectors for compiled functions, (a, 6)."""
    arms = here.agent.arms
    usable = tuple(index for index, arm in enumerate(arms) if stretch(arm.profile.side) in here.actions)
    return usable, np.array([arms[index].sector for index in usable]).reshape(-1, 6)


class ArmJudge:
    """Judges an ability of the arms towards one object.

    Args:
        here: Whose, and from where.
        target: The object.

    Attributes:
        arms: Indices of those that may be stretched out.
        sectors: Their lengths and sectors for compiled functions, (a, 6).
    """

    def __init__(self, here: Viewpoint, target: Target) -> None:
        self._here, self.target = here, target
        self.arms, self.sectors = usable_arms(here)

    @cached_property
    def surface(self) -> PointCloud:
        """The object's cells."""
        return PointCloud.of(self.target.points)

    def arm(self, index: int) -> ArmIndices:
        """An arm of the agent by its index."""
        return self._here.agent.arms[index]

    def unknown(self, level: int) -> str | None:
        """The shoulders are where the torso is; legs matter from their level on; hands for holding only."""
        return self._here.untracked(PARTS[level]) if level else self._hand_unknown()

    def _hand_unknown(self) -> str | None:
        """Sentence about a hand that was not tracked and might hold the object; None if there is none."""
        here = self._here
        if self.target.name in here.held:
            return None
        stage, agent = here.stage.show(here.state), here.agent
        for arm in agent.arms:
            if not hand_known(stage, agent, arm) and self._could_hold(arm) and not here.is_supported(self.target):
                return f"{agent.name}'s {arm.profile.side} hand not tracked, and it might hold the object"
        return None

    def _could_hold(self, arm: ArmIndices) -> bool:
        """Whether the object is near enough to the arm's shoulder in the state that the stage shows."""
        shoulder = self._here.stage.shoulder(arm).position
        nearest = float(np.linalg.norm(self.target.points - shoulder, axis=1).min(initial=np.inf))
        return nearest <= WHOLE_ARM * arm.profile.length_m

    def without_effort(self) -> Hit | FindMiss:
        """Level 0: held, or not."""
        side = self._here.held.get(self.target.name)
        return (lambda: NOT_HELD) if side is None else Hit(partial(Held, side))


class Reach(ArmJudge):
    """Judges the ability to reach one object."""

    def screen(self, candidates: Candidates) -> Screening:
        """What the arms reach from some candidates."""
        return ReachScreening(self, candidates, self.surface)


class ReachScreening:
    """What each arm reaches from n candidates, of points of the object.

    Args:
        judge: Whose arms.
        candidates: The candidates.
        cloud: The points.
    """

    def __init__(self, judge: ArmJudge, candidates: Candidates, cloud: PointCloud) -> None:
        self._judge, self._candidates, self._cloud = judge, candidates, cloud
        shoulders = candidates.torso.frames.first_shoulder + np.array(judge.arms, dtype=np.intp)
        self._where = (candidates.table, shoulders, judge.sectors, cloud.points, cloud.middle, cloud.radius_m)
        count = len(judge.arms)
        self._nearest, self._reach_m = np.empty(count, dtype=np.intp), np.empty(count)
        self._missed, self._gap_m = np.full(count, NOWHERE), np.full(count, np.inf)

    def next(self, start: int, stop: int) -> int:
        """The first candidate from which an arm reaches one of the points."""
        if not len(self._cloud.points):
            return stop
        return first_in_reach(*self._where, start, stop, self._nearest, self._reach_m, self._missed, self._gap_m)

    def beyond(self, margin_m: float) -> bool:
        """Whether all points are farther than this beyond every arm, from every candidate."""
        return beyond(*self._where, margin_m)

    def able(self, index: int) -> list[int]:
        """Which of the judge's arms reach some point from such a candidate, the nearer shoulder's first."""
        self.next(index, index + 1)
        columns = np.flatnonzero(self._nearest != NOWHERE).tolist()
        return sorted(columns, key=lambda column: round(float(self._reach_m[column]), DIGITS))

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """How those arms reach the object."""
        return iter([self._stretched(column) for column in self.able(index)])

    def miss(self) -> Miss | None:
        """Why the candidates passed over reach nothing: the arm that misses the object least."""
        if not self._judge.arms:
            return NO_ARM
        if not len(self._cloud.points):
            return NO_SURFACE
        column = int(np.argmin(self._gap_m))
        if self._missed[column] == NOWHERE:
            return None
        arm = self._judge.arms[column]
        shoulder = self._candidates.shoulder(int(self._missed[column]), arm)
        return out_of_reach(self._judge.arm(arm).profile, shoulder.position, self._cloud.points)

    def _stretched(self, column: int) -> Hit:
        side, distance_m = self._judge.arm(self._judge.arms[column]).profile.side, float(self._reach_m[column])
        point = self._cloud.points[self._nearest[column]]
        return Hit(
            lambda: Reached(side, vector(point), distance_m),
            actions=(stretch(side),),
            cost=round(distance_m, DIGITS),
        )
