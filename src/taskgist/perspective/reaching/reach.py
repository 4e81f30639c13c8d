"""Reach: some cell of the object is within the arm's length of the shoulder and inside its sector (5.1.2).

A rough reach, as people perceive it: head, torso and base must not collide, the arm is not looked at. Who holds the
object reaches it without effort. An arm that was not tracked can be stretched out all the same, for its shoulder
hangs on the torso; only whether its hand holds the object is then unknown, unless the object is farther away than the
whole arm.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.judge import NO_ARM, Among, Miss, Outcome
from taskgist.perspective.reaching.by_hand import ByHand
from taskgist.perspective.reaching.sector import DIGITS, NOWHERE, Cloud, beyond, first_in_reach, out_of_reach

Array = NDArray[np.float64]


class Reach(ByHand):
    """Judges the ability to reach one object."""

    def among(self, stances: Stances) -> Among:
        """What the arms reach from some stances."""
        return ReachAmong(self, stances, self.surface)


class ReachAmong:
    """What each arm reaches from n stances, of points of the object.

    Args:
        judge: Whose arms.
        stances: The stances.
        cloud: The points.
    """

    def __init__(self, judge: ByHand, stances: Stances, cloud: Cloud) -> None:
        self._judge, self._stances, self._cloud = judge, stances, cloud
        self._where = (stances.table, judge.shoulders, judge.sectors, cloud.points, cloud.middle, cloud.radius_m)
        count = len(judge.arms)
        self._nearest, self._reach_m = np.empty(count, dtype=np.intp), np.empty(count)
        self._missed, self._gap_m = np.full(count, NOWHERE), np.full(count, np.inf)

    def next(self, start: int, stop: int) -> int:
        """The first stance from which an arm reaches one of the points."""
        if not len(self._cloud.points):
            return stop
        return first_in_reach(*self._where, start, stop, self._nearest, self._reach_m, self._missed, self._gap_m)

    def beyond(self, margin_m: float) -> bool:
        """Whether all points are farther than this beyond every arm, from every stance."""
        return beyond(*self._where, margin_m)

    def able(self, index: int) -> list[int]:
        """Which of the judge's arms reach some point from such a stance, the nearer shoulder's first."""
        self.next(index, index + 1)
        columns = np.flatnonzero(self._nearest != NOWHERE).tolist()
        return sorted(columns, key=lambda column: round(float(self._reach_m[column]), DIGITS))

    def outcomes(self, index: int) -> Iterator[Outcome]:
        """How those arms reach the object."""
        return iter([self._stretched(column) for column in self.able(index)])

    def miss(self) -> Miss | None:
        """Why the stances passed over reach nothing: the arm that misses the object least."""
        if not self._judge.arms:
            return NO_ARM
        if not len(self._cloud.points):
            return Miss(math.inf, "has no surface")
        column = int(np.argmin(self._gap_m))
        if self._missed[column] == NOWHERE:
            return None
        arm = self._judge.arms[column]
        shoulder = self._stances.shoulder(int(self._missed[column]), arm)
        return out_of_reach(self._judge.arm(arm).profile, shoulder.position, self._cloud.points)

    def _stretched(self, column: int) -> Outcome:
        side, distance_m = self._judge.arm(self._judge.arms[column]).profile.side, float(self._reach_m[column])
        point = self._cloud.points[self._nearest[column]]
        return Outcome(
            actions=(stretch(side),),
            merit=round(distance_m, DIGITS),
            evidence=lambda: {"arm": side, "point_m": point.tolist(), "distance_m": distance_m},
        )
