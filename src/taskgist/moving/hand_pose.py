"""Where a hand is, and how it takes hold of a thing.

A hand takes a thing from the side: the thumb up, the palm against the thing, the fingers along it. That leaves the side
that faces away from the hand free to be seen, and the underside free to be put down.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.moving.motion import minimum_jerk
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, normalized, rotate, wxyz_from_matrix
from taskgist.world.stage import Stage

UP = np.array([0.0, 0.0, 1.0])
SIGNS = {"left": -1.0, "right": 1.0}
"""Which way the palm faces with the thumb up: +1 to the left of the fingers."""
POINT_SPACING_M = 0.01
STEP_M = 0.06
"""Spacing of the hands along a way."""
HALF_BREADTH_M, CLEAR_M = 0.042, 0.008
"""Half the breadth of a hand, and the gap that it keeps from what a thing stands on."""


@dataclass(frozen=True, eq=False)
class HandPose:
    """A hand in the world.

    Attributes:
        palm: The middle of what the palm closes around, metres, (3,).
        fingers: Unit direction of the fingers, (3,).
        facing: Unit direction out of the palm, (3,).
    """

    palm: Array
    fingers: Array
    facing: Array

    def moved(self, offset_m: ArrayLike) -> HandPose:
        """The same hand elsewhere; ``offset_m`` is (3,), in the world."""
        return HandPose(self.palm + np.asarray(offset_m), self.fingers, self.facing)

    def turned(self, angle_rad: float) -> HandPose:
        """The same hand turned about the vertical through the world's origin."""
        turn = about_z(angle_rad)
        return HandPose(rotate(turn, self.palm), rotate(turn, self.fingers), rotate(turn, self.facing))

    @property
    def heading_rad(self) -> float:
        """Where the fingers point, about the vertical."""
        return math.atan2(self.fingers[1], self.fingers[0])

    def off(self, *, aside_m: float, back_m: float, up_m: float) -> HandPose:
        """The same hand moved away from what it faces, back from where it points, and up."""
        return self.moved(-aside_m * self.facing - back_m * self.fingers + up_m * UP)

    def toward(self, other: HandPose, share: float) -> HandPose:
        """A hand on the way to another one; place and directions change evenly."""
        fingers = normalized((1 - share) * self.fingers + share * other.fingers)
        facing = (1 - share) * self.facing + share * other.facing
        return HandPose(
            (1 - share) * self.palm + share * other.palm, fingers, normalized(facing - facing @ fingers * fingers)
        )


def upright(side: str, palm: Array, heading: ArrayLike, *, rise_rad: float = 0.0) -> HandPose:
    """A hand with its thumb up.

    Args:
        side: "left" or "right".
        palm: Its place, metres, (3,).
        heading: Where the fingers point, only its horizontal part counts, (2,) or (3,).
        rise_rad: How far the fingers point above the horizontal.
    """
    ahead = normalized((*np.asarray(heading)[:2], 0.0))
    facing = SIGNS[side] * np.cross(UP, ahead)
    return HandPose(np.asarray(palm), math.cos(rise_rad) * ahead + math.sin(rise_rad) * UP, facing)


def around(stage: Stage, name: str, side: str, heading: ArrayLike, *, dip_rad: float, tip_m: float) -> HandPose:
    """The hand that closes around a thing where the stage shows it.

    The palm is against the thing if there is room; else the hand is drawn back until its fingertips clear what the
    thing stands on, and the fingers hold it.

    Args:
        stage: The scene in a state.
        name: The thing.
        side: The hand to take it with.
        heading: Where the fingers point, (2,) or (3,).
        dip_rad: How far the fingers point below the horizontal.
        tip_m: How far the fingertips are beyond the palm's middle.
    """
    points = object_points(stage, name, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high) / 2
    hand = upright(side, middle, heading, rise_rad=-dip_rad)
    edge = HALF_BREADTH_M * math.cos(dip_rad) + CLEAR_M
    tip = tip_m * math.sin(dip_rad)
    height = float(np.clip(low[2] + tip + edge, middle[2], high[2] - POINT_SPACING_M))
    missing = low[2] + tip + edge - height
    drawn_back = missing / math.sin(dip_rad) if missing > 0.0 and dip_rad > 0.0 else 0.0
    beside = float(np.max((points - middle) @ -hand.facing))
    return hand.off(aside_m=beside, back_m=min(drawn_back, tip_m), up_m=height - middle[2])


def sampled(way: Sequence[HandPose]) -> list[HandPose]:
    """Hands at even distances along a way with rounded corners, its first and last one included."""
    rounded = _rounded(_rounded(way))
    lengths = [float(np.linalg.norm(b.palm - a.palm)) + 1e-6 for a, b in pairwise(rounded)]
    places = np.concatenate(([0.0], np.cumsum(lengths)))
    count = max(2, math.ceil(places[-1] / STEP_M) + 1)
    return [_along(rounded, places, place) for place in np.linspace(0.0, places[-1], count)]


def _rounded(way: Sequence[HandPose]) -> list[HandPose]:
    """The way with each corner cut off [Chaikin 1974]: it never leaves the hull of its corners."""
    cut = [leg[0].toward(leg[1], share) for leg in pairwise(way) for share in (0.25, 0.75)]
    return [way[0], *cut[1:-1], way[-1]] if len(way) > 2 else list(way)


def _along(way: Sequence[HandPose], places: Array, place: float) -> HandPose:
    leg = int(np.clip(np.searchsorted(places, place, side="right") - 1, 0, len(way) - 2))
    return way[leg].toward(way[leg + 1], (place - places[leg]) / (places[leg + 1] - places[leg]))


# --- Carrying: a thing follows the hand that holds it, rigidly, until it settles onto a support.

SETTLING_S = 0.25
"""Time before it is put down in which a thing comes flat onto its support: hands sway, supports do not."""


@dataclass(frozen=True, eq=False)
class Carry:
    """A thing in a hand.

    Attributes:
        thing: Its name.
        side: The hand.
        from_s: When the hand has closed.
        grip: The hand then.
        taken: Position in metres and wxyz (7) of the thing then.
        until_s: When it has been put down or handed over; infinity while it is held.
        rest: Position in metres and wxyz (7) where it then rests; None while it is held, and once it was handed over.
        agent: Who carries it; None: the performer.
    """

    thing: str
    side: str
    from_s: float
    grip: HandPose
    taken: Array
    until_s: float = np.inf
    rest: Array | None = None
    agent: str | None = None

    def pose(self, hand: HandPose) -> Array:
        """Where the thing is, position in metres and wxyz (7), while the hand is somewhere."""
        turn = _matrix(hand) @ _matrix(self.grip).T
        place = hand.palm + turn @ (self.taken[:3] - self.grip.palm)
        return np.concatenate((place, wxyz_from_matrix(turn @ matrix_from_wxyz(self.taken[3:]))))

    def poses(self, times_s: Array, palms: Array, turns: Array) -> Array:
        """Where the thing is while it is carried.

        Args:
            times_s: Times while it is carried, (n,); the first is that of taking it.
            palms: Places of the hand, metres, (n, 3).
            turns: Rotations of the hand, (n, 3, 3).

        Returns:
            Positions in metres and wxyz, (n, 7).
        """
        place_in_hand = turns[0].T @ (self.taken[:3] - palms[0])
        turn_in_hand = turns[0].T @ matrix_from_wxyz(self.taken[3:])
        poses = np.hstack((palms + turns @ place_in_hand, wxyz_from_matrix(turns @ turn_in_hand)))
        return poses if self.rest is None else self._settling(times_s, poses, self.rest)

    def _settling(self, times_s: Array, poses: Array, rest: Array) -> Array:
        settled = minimum_jerk((times_s - self.until_s) / SETTLING_S + 1.0)[:, None]
        same_side = np.where(poses[:, 3:] @ rest[3:] < 0.0, -1.0, 1.0)  # q and -q are one rotation
        poses[:, 3:] *= same_side[:, None]
        mixed = (1.0 - settled) * poses + settled * rest
        mixed[:, 3:] = normalized(mixed[:, 3:])
        return np.asarray(mixed)


def _matrix(hand: HandPose) -> Array:
    """Rotation (3, 3) of a hand: its columns are where the fingers point, where the palm faces, and across."""
    return np.stack((hand.fingers, hand.facing, np.cross(hand.fingers, hand.facing)), axis=1)
