"""Where the boxes of a hand are when it grasps (5.1.3)."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.grasping.grasps import Grasps
from taskgist.world import Hand, hand_boxes
from taskgist.world.geometry.boxes import COLUMNS, EXACT, HALF, RADIUS

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hands:
    """The boxes of a hand in each of n grasps, before it closes.

    Attributes:
        frames: How the hand is turned, (n, 9).
        centers: Middles of its boxes, metres, (n, k, 3).
        boxes: The boxes as rows of a table, to be put there, (k, 18); see ``geometry.boxes``.
        middle: Middle of a ball that holds the hand in all of the grasps, metres, (3,).
        radius_m: Its radius.
    """

    frames: Array
    centers: Array
    boxes: Array
    middle: Array
    radius_m: float

    @classmethod
    def of(cls, grasps: Grasps, hand: Hand) -> Hands:
        """The hand in some grasps; found once for each set of grasps."""
        known = _KNOWN.setdefault(grasps, {})
        if hand not in known:
            half = np.array([box.half_m for box in hand_boxes(hand)])
            boxes = np.zeros((len(half), COLUMNS))
            boxes[:, HALF : HALF + 3], boxes[:, RADIUS], boxes[:, EXACT] = half, np.linalg.norm(half, axis=1), 1.0
            centers = hand_centers(grasps, hand)
            middle = centers.mean(axis=(0, 1))
            radius_m = float((np.linalg.norm(centers - middle, axis=2) + boxes[:, RADIUS]).max())
            known[hand] = cls(hand_frames(grasps).reshape(-1, 9), centers, boxes, middle, radius_m)
        return known[hand]


_KNOWN: WeakKeyDictionary[Grasps, dict[Hand, Hands]] = WeakKeyDictionary()


def hand_frames(grasps: Grasps) -> Array:
    """Axes of the hand in each grasp, (n, 3, 3): columns along the approach, the closing direction, and across."""
    a, c = grasps.approaches.T, grasps.closings.T
    across = (a[1] * c[2] - a[2] * c[1], a[2] * c[0] - a[0] * c[2], a[0] * c[1] - a[1] * c[0])
    return np.stack((grasps.approaches, grasps.closings, np.stack(across, axis=1)), axis=2)


def hand_centers(grasps: Grasps, hand: Hand) -> Array:
    """Middles of the boxes of ``hand_boxes`` in each grasp before the hand closes, metres, (n, k, 3).

    Fingers and thumb stand off the two points by the grasp's gap; their pads are beside them.
    """
    boxes = hand_boxes(hand)
    behind, side, across = (
        np.array(values) for values in zip(*((b.behind_m, b.side, b.across_m) for b in boxes), strict=True)
    )
    beside = side * (grasps.widths_m / 2 + grasps.gaps_m + hand.finger_thickness_m / 2)[:, None]
    local = np.stack((np.broadcast_to(-behind, beside.shape), beside, np.broadcast_to(across, beside.shape)), axis=2)
    return np.asarray(grasps.centers[:, None] + local @ hand_frames(grasps).transpose(0, 2, 1))
