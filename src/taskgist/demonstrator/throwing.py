"""Dropping and throwing: steps that end with a thing on its own way."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.releasing import ends_in_air, hand_at, let_go, watch
from taskgist.demonstrator.steps import carry_to
from taskgist.demonstrator.swing import Swing
from taskgist.errors import SceneError

Array = NDArray[np.float64]

ARM_SHARE = 0.72
"""Share of the arm's length at which a throwing hand swings about its shoulder."""
BACK_RAD, ON_RAD = math.radians(30.0), math.radians(30.0)
"""How far it swings before and behind where it lets go."""
SWING_KNOTS, MOMENTS = 8, 100
"""Hands on the way of a swing, and moments of it at which its speed is looked at."""
STAYS_S = 0.4
"""How long a hand stays where it has let something go."""
WATCHED_S = 1.2
"""How long somebody watches what it has thrown before it takes the hand back, at most."""


@dataclass(frozen=True)
class LetFall:
    """Let go of what is held.

    Attributes:
        dropped: Whether the demonstration is over while it falls; else once it rests.
    """

    dropped: bool

    def play(self, acting: Acting) -> None:
        """Open the hand and watch it fall.

        Raises:
            SceneError: It is dropped, but does not fall far enough; or it shall rest, and rolls on and on.
        """
        since_s, thing = acting.now_s, acting.holding().thing
        motion = let_go(acting, since_s)
        acting.look(thing)
        if self.dropped:
            ends_in_air(acting, since_s, motion)
        elif not motion.rests:
            raise SceneError("it does not come to rest", where=acting.performer, field=thing, hint="let it fall lower")
        acting.wait(STAYS_S)
        watch(acting, since_s + motion.duration_s)


@dataclass(frozen=True)
class Throw:
    """Throw what is held, underarm: the arm swings about its shoulder and lets go half-way.

    Attributes:
        goal_m: Where it shall come down, (3,).
        flight_s: How long it shall fly there.
    """

    goal_m: tuple[float, float, float]
    flight_s: float

    def play(self, acting: Acting) -> None:
        """Bring it to where the swing begins, swing, let go, watch it fly.

        Raises:
            SceneError: It meets something too soon, or the hand does not get there.
        """
        thing, swing = acting.holding().thing, _aimed(acting, np.array(self.goal_m), self.flight_s)
        carry_to(acting, swing.hand(-BACK_RAD), lower=False)
        acting.look(acting.target)
        released_s = _swung(acting, swing)
        motion = let_go(acting, released_s)
        acting.look(thing)
        ends_in_air(acting, released_s, motion)
        acting.wait(STAYS_S)
        watch(acting, released_s + min(motion.duration_s, WATCHED_S))


def _aimed(acting: Acting, goal: Array, flight_s: float) -> Swing:
    """The swing of the acting hand that sends what it holds to a goal."""
    body, side = acting.body, acting.holding().side
    radius = ARM_SHARE * body.agent.arm(side).profile.length_m
    return Swing.to(goal, flight_s=flight_s, shoulder=body.shoulder(acting.state, side), radius_m=radius, side=side)


def _swung(acting: Acting, swing: Swing) -> float:
    """Let the hand swing, so fast that it has the right speed where it lets go; gives when that is."""
    carry, since_s = acting.holding(), acting.now_s
    way = [swing.hand(angle) for angle in np.linspace(-BACK_RAD, ON_RAD, SWING_KNOTS)[1:]]
    torso = acting.body.posture(acting.state)[:2]
    acting.move(carry.side, way, torso_rad=torso, phase="over", duration_s=1.0)
    hands = [hand_at(acting, carry.side, since_s + share) for share in np.linspace(0.0, 1.0, MOMENTS + 1)]
    nearest = int(np.argmin([np.linalg.norm(hand.palm - swing.hand(0.0).palm) for hand in hands[1:-1]])) + 1
    before, after = (carry.pose(hands[nearest + step])[:3] for step in (-1, 1))
    speed_m_s = float(np.linalg.norm(after - before)) * MOMENTS / 2
    duration_s = speed_m_s / swing.speed_m_s  # it took a second, and was that fast
    swung = acting.motions[-1]
    acting.motions[-1] = replace(swung, motion=replace(swung.motion, duration_s=duration_s))
    acting.now_s = since_s + duration_s
    return float(since_s + nearest / MOMENTS * duration_s)
