"""Tilting and turning what the hand holds, in the air: steps of whoever pours or inspects something."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.moving.acting import Acting
from taskgist.moving.hand_pose import SIGNS, UP, HandPose
from taskgist.world.geometry.transforms import normalized, rotate

Axis = Literal["upright", "fingers"]
"""About which a hand rolls: the vertical, or where its fingers point."""

ROLLING_STEPS = 4
"""Hands on the way of a roll."""


@dataclass(frozen=True)
class Roll:
    """Roll what the hand holds about its middle, keep it so, and roll it back.

    Attributes:
        axis: About what.
        angle_rad: How far towards where the palm faces: about its fingers the hand comes to lie on top, the palm down.
        seconds: How long it is kept so.
    """

    axis: Axis
    angle_rad: float
    seconds: float

    def play(self, acting: Acting) -> None:
        """Roll it there, hold still, roll it back."""
        carry, body = acting.holding(), acting.body
        hand, middle = body.hand(acting.state, carry.side), acting.held_pose()[:3]
        torso = body.posture(acting.state)[:2]
        about = UP * SIGNS[carry.side] if self.axis == "upright" else -SIGNS[carry.side] * hand.fingers
        shares = np.linspace(0.0, 1.0, ROLLING_STEPS + 1)
        way = [rolled(hand, about, share * self.angle_rad, middle) for share in shares]
        acting.move(carry.side, way[1:], torso_rad=torso, phase="over")
        acting.wait(self.seconds)
        acting.move(carry.side, way[-2::-1], torso_rad=torso, phase="over")


def rolled(hand: HandPose, axis: Array, angle_rad: float, middle: Array) -> HandPose:
    """A hand rolled about an axis (3,) through a place (3,), right-handed."""
    x, y, z = math.sin(angle_rad / 2) * normalized(axis)
    turn = np.array([math.cos(angle_rad / 2), x, y, z])
    return HandPose(middle + rotate(turn, hand.palm - middle), rotate(turn, hand.fingers), rotate(turn, hand.facing))
