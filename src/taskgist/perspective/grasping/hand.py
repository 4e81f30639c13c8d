"""Where the boxes of a hand are when it grasps (5.1.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.grasping.grasps import Grasps
from taskgist.world import Hand, Pose, hand_boxes

Array = NDArray[np.float64]


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


def hand_poses(grasps: Grasps, index: int, hand: Hand) -> tuple[Pose, ...]:
    """Poses of the boxes of ``hand_boxes`` in one grasp."""
    one = grasps.only(np.array([index]))
    matrix = hand_frames(one)[0]
    return tuple(Pose(center, matrix) for center in hand_centers(one, hand)[0])
