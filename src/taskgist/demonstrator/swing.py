"""The swing of a throwing arm: how fast and how steeply a hand must go for a thing to come down at a goal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.hand import SIGNS, UP, HandPose
from taskgist.world.dynamics import GRAVITY_M_S2
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

WRIST_RAD = math.radians(40.0)
"""How far the fingers point above the line of the arm."""
AIMING_ROUNDS = 4
"""How often the aim is corrected: where a hand lets go depends on how steeply it throws, and the reverse."""


@dataclass(frozen=True, eq=False)
class Swing:
    """An underarm swing about the shoulder.

    Attributes:
        shoulder: About which the arm swings, metres, (3,).
        radius_m: Distance of the palm from there.
        ahead: Horizontal unit direction in which it throws, (3,).
        side: Which hand.
        rise_rad: How steeply upwards it throws.
        speed_m_s: How fast the thing is when the hand lets go.
    """

    shoulder: Array
    radius_m: float
    ahead: Array
    side: str
    rise_rad: float = 0.0
    speed_m_s: float = 1.0

    @classmethod
    def to(cls, goal: Array, *, flight_s: float, shoulder: Array, radius_m: float, side: str) -> Swing:
        """The swing that sends a thing to a goal, metres, (3,), in some time."""
        ahead = normalized((goal - shoulder) * (1.0, 1.0, 0.0))
        swing = cls(shoulder, radius_m, ahead, side)
        for _ in range(AIMING_ROUNDS):
            velocity = velocity_to(swing.hand(0.0).palm, goal, flight_s)
            rise = math.atan2(velocity[2], float(velocity @ ahead))
            swing = cls(shoulder, radius_m, ahead, side, rise, float(np.linalg.norm(velocity)))
        return swing

    def hand(self, angle_rad: float) -> HandPose:
        """The hand at an angle beyond (positive) or before where it lets go."""
        angle = self.rise_rad + angle_rad
        palm = self.shoulder + self.radius_m * (math.sin(angle) * self.ahead - math.cos(angle) * UP)
        pitch = angle - math.pi / 2 + WRIST_RAD
        fingers = math.cos(pitch) * self.ahead + math.sin(pitch) * UP
        return HandPose(palm, fingers, SIGNS[self.side] * np.cross(UP, self.ahead))


def velocity_to(release: Array, goal: Array, flight_s: float) -> Array:
    """Velocity in m/s, (3,), with which a thing flies from where it is let go to a goal in some time."""
    return np.asarray((goal - release) / flight_s + GRAVITY_M_S2 * flight_s / 2 * UP)
