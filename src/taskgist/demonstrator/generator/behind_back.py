"""Behind the own back: a step that takes what the hand holds there, and the means of hiding so."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.generator.hiding_places import script_of
from taskgist.demonstrator.hand import SIGNS, UP, HandPose, sampled, upright
from taskgist.demonstrator.means import HELD_S, Means, Roles
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import Take
from taskgist.world import Scene
from taskgist.world.geometry.rotations import rotate

Array = NDArray[np.float64]

ASIDE_SHARE, WAIST_SHARE = 0.23, 0.02
"""How far beside the pelvis the hand passes, and how far above it, as shares of the stature."""
BACK_SHARE, PAST_SHARE = 0.115, 0.05
"""How far behind the pelvis the hand is then, and how far to its own side."""
DOWN_RAD = np.radians(-50.0)
"""How far the fingers rise while the hand passes the hip: they point down."""


@dataclass(frozen=True)
class HoldBehindBack:
    """Take what the hand holds behind the own back and keep it there.

    Attributes:
        seconds: For how long.
    """

    seconds: float

    def play(self, acting: Acting) -> None:
        """Take it round the hip, look at the target agent, hold still."""
        carry, body = acting.holding(), acting.body
        start = body.hand(acting.state, carry.side)
        lifted = start.moved(0.08 * UP)
        way = sampled([start, lifted, *_round_the_hip(acting, carry.side)])[1:]
        acting.look(acting.target)
        acting.move(carry.side, way, torso_rad=np.zeros(2), phase="over")
        acting.wait(self.seconds)


def _round_the_hip(acting: Acting, side: str) -> tuple[HandPose, ...]:
    agent = acting.body.agent
    pelvis = acting.state.qpos[agent.base]
    ahead, inwards = rotate(pelvis[3:], (1.0, 0.0, 0.0)), rotate(pelvis[3:], (0.0, SIGNS[side], 0.0))
    stature = agent.stature_m
    waist = pelvis[:3] + WAIST_SHARE * stature * UP
    beside = waist - ASIDE_SHARE * stature * inwards
    passing = upright(side, beside + 0.10 * stature * ahead, ahead + inwards, rise_rad=DOWN_RAD)
    past = upright(side, beside - BACK_SHARE * stature * ahead, inwards, rise_rad=DOWN_RAD / 2)
    behind = waist - BACK_SHARE * stature * ahead - PAST_SHARE * stature * inwards
    return passing, past, upright(side, behind, inwards, rise_rad=DOWN_RAD / 2)


def hold_behind_back(roles: Roles) -> Means:
    """Hide by holding behind the own back."""

    def script(_scene: Scene) -> Script:
        steps = (Take(roles.thing, roles.side), HoldBehindBack(HELD_S))
        return script_of(roles, "hide", "held behind the own back", steps)

    return script
