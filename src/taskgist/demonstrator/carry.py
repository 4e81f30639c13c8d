"""Carrying: a thing follows the hand that holds it, rigidly, until it settles onto a support."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.hand import HandPose
from taskgist.demonstrator.motion import minimum_jerk
from taskgist.world.geometry.rotations import matrix_from_wxyz, normalized, wxyz_from_matrix

Array = NDArray[np.float64]

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
