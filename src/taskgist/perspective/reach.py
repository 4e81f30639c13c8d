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
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.perspective.actions import stretch
from taskgist.perspective.candidates import Stances
from taskgist.perspective.effort import NO_ARM, Among, Miss, Outcome, Why, untracked_parts
from taskgist.perspective.sector import DIGITS, NOWHERE, ball_around, beyond, first_in_reach
from taskgist.perspective.viewpoint import Standpoint, Target
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.profile import Arm
from taskgist.world.holding import hand_known, holding_of

# --- Held: level 0 of reach and grasp.
#
# Only the agent's own hands matter. One that was not tracked leaves it unknown, unless the object rests on something
# or is farther away than the whole arm.

WHOLE_ARM = 1.25
"""A hand holds nothing farther from its shoulder than this times the arm's length (ours; a human's is 1.1)."""


class Hold:
    """Whether the agent holds the object: level 0 of reach and grasp.

    Args:
        here: Whose, and from where.
        target: The object.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        self._here, self._target = here, target

    @property
    def side(self) -> str | None:
        """Side of the hand that holds the object; None if no hand is known to."""
        return self._here.held.get(self._target.name)

    @property
    def unknown(self) -> str | None:
        """Why it is unknown: a hand that was not tracked might hold the object."""
        if self.side is not None:
            return None
        here = self._here
        stage, agent = here.stage.show(here.state), here.agent
        for arm in agent.arms:
            if not hand_known(stage, agent, arm) and self._could_hold(arm) and not self._at_rest():
                return f"{agent.name}'s {arm.profile.side} hand not tracked, and it might hold the object"
        return None

    def outcome(self) -> Outcome | Why:
        """Held, or not."""
        if self.side is None:
            return lambda: Miss(math.inf, "not held")
        return Outcome(evidence=lambda: {"arm": self.side, "held": True})

    def _could_hold(self, arm: ArmIndices) -> bool:
        shoulder = self._here.stage.shoulder(arm).position
        nearest = float(np.linalg.norm(self._target.points - shoulder, axis=1).min(initial=np.inf))
        return nearest <= WHOLE_ARM * arm.profile.length_m

    def _at_rest(self) -> bool:
        contact, target = self._here.settings.contact, self._target
        self._here.consulted.target.add_balls(target.centers, target.radii_m + contact.container_m)
        holding = holding_of(self._here.stage, target.name, contact)
        return holding is not None and bool(holding.support or holding.container)


# --- Points to be reached, and which arms may reach for them.


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
        return cls(points, *ball_around(points))


# --- What the judges of reach and grasp share: arms that are stretched out, and level 0, which is holding.

PARTS: tuple[tuple[str, ...], ...] = ((), ("torso",), ("torso",), ("torso", "legs"), ("torso", "legs"))
"""Parts that must be tracked to judge each level."""


class ByHand:
    """Judges an ability of the hands towards one object.

    Args:
        here: Whose, and from where.
        target: The object.

    ``arms`` are the indices of those that may be stretched out.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        self._here, self.target = here, target
        self._stage, self._agent = here.stage, here.agent
        self.arms = arms_of(here)
        self._hold = Hold(here, target)

    @cached_property
    def surface(self) -> Cloud:
        """The object's cells."""
        return Cloud.of(self.target.points)

    @cached_property
    def sectors(self) -> Array:
        """Lengths and sectors of these arms for compiled functions, (a, 6)."""
        return np.array([self.arm(index).sector for index in self.arms]).reshape(-1, 6)

    @cached_property
    def shoulders(self) -> NDArray[np.intp]:
        """Which of the agent's frames their shoulders are, (a,)."""
        return self._here.first_shoulder + np.array(self.arms, dtype=np.intp)

    def arm(self, index: int) -> ArmIndices:
        """An arm of the agent by its index."""
        return self._agent.arms[index]

    def unknown(self, level: int) -> str | None:
        """The shoulders are where the torso is; legs matter from their level on; hands for holding only."""
        if level == 0:
            return self._hold.unknown
        return untracked_parts(self._here.state, self._agent.name, PARTS[level])

    def without_effort(self) -> Outcome | Why:
        """Level 0: held."""
        return self._hold.outcome()


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
