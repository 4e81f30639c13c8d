"""Reach: some cell of the object is within the arm's length of the shoulder and inside its sector (5.1.2).

A rough reach, as people perceive it: head, torso and base must not collide, the arm is not looked at. Who holds the
object reaches it without effort. An arm that was not tracked can be stretched out all the same, for its shoulder
hangs on the torso; only whether its hand holds the object is then unknown, unless the object is farther away than the
whole arm.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.judge import NO_ARM, Among, Miss, Outcome
from taskgist.perspective.reaching.by_hand import ByHand
from taskgist.perspective.reaching.sector import DIGITS, NOWHERE, Cloud, reaching

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
        self._judge, self._stances, self._points, placed = judge, stances, cloud.points, stances.placed
        self._by_arm = {
            arm: reaching(placed.shoulders[:, arm], placed.carriers[:, arm], judge.arm(arm), cloud)
            for arm in judge.arms
        }
        self.hopeful: NDArray[np.bool_] = np.zeros(len(stances), dtype=np.bool_)
        for reached in self._by_arm.values():
            self.hopeful |= reached.nearest != NOWHERE

    def beyond(self, margin_m: float) -> bool:
        """Whether all points are farther than this beyond every arm, from every stance."""
        lengths_m = {arm: self._judge.arm(arm).profile.length_m + margin_m for arm in self._by_arm}
        return all(bool((reached.gap_m > lengths_m[arm]).all()) for arm, reached in self._by_arm.items())

    def able(self, index: int) -> list[int]:
        """The arms that reach some point from a stance, the nearer shoulder's first."""
        able = [arm for arm, reached in self._by_arm.items() if reached.nearest[index] != NOWHERE]
        return sorted(able, key=lambda arm: round(float(self._by_arm[arm].reach_m[index]), DIGITS))

    def outcomes(self, index: int) -> Iterator[Outcome | Miss]:
        """How those arms reach the object."""
        return (self._stretched(arm, index) for arm in self.able(index))

    def miss(self) -> Miss:
        """Why the hopeless stances reach nothing: the arm that misses the object least."""
        if not self._by_arm:
            return NO_ARM
        arm = min(self._by_arm, key=lambda arm: float(self._by_arm[arm].gap_m[~self.hopeful].min()))
        shoulders = self._stances.placed.shoulders[:, arm]
        return self._by_arm[arm].miss(shoulders, self._judge.arm(arm).profile, self._points, ~self.hopeful)

    def _stretched(self, arm: int, index: int) -> Outcome:
        reached, side = self._by_arm[arm], self._judge.arm(arm).profile.side
        point, distance_m = self._points[reached.nearest[index]], float(reached.reach_m[index])
        return Outcome(
            actions=(stretch(side),),
            merit=round(distance_m, DIGITS),
            evidence=lambda: {"arm": side, "point_m": point.tolist(), "distance_m": distance_m},
        )
