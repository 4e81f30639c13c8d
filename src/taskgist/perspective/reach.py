"""Reach: some cell of the object is within the arm's length of the shoulder and inside its sector (5.1.2).

A rough reach, as people perceive it: head, torso and base must not collide, the arm is not looked at. Who holds the
object reaches it without effort. An arm that was not tracked can be stretched out all the same, for its shoulder
hangs on the torso; only whether its hand holds the object is then unknown, unless the object is farther away than the
whole arm.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.candidates import Candidates
from taskgist.perspective.effort import Held, Miss, OutOfReach, Quantity, Reached, Reason, stretch
from taskgist.perspective.sector import DIGITS, NOWHERE, ball_around, beyond, first_in_reach
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Screening, Viewpoint
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.profile import Arm
from taskgist.world.holding import hand_known

# --- The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2).
#
# Shoulders are given in the frame of what carries the arm, x forward and z up; the right arm's azimuth is mirrored.


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
