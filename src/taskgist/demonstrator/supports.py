"""Where a thing can be put: on a support, and clear of others."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Stage, object_points

Array = NDArray[np.float64]

POINT_SPACING_M = 0.02
LIFT_M, SUPPORT_M = 0.05, 0.005
"""From how high a support is searched, and how far it may be from where it is expected."""


def supported(stage: Stage, points: Array) -> bool:
    """Whether there is a support just beneath each of some points, metres, (n, 3)."""
    down = [(0.0, 0.0, -1.0)]
    return all(abs(stage.cast(point + (0.0, 0.0, LIFT_M), down)[1][0] - LIFT_M) < SUPPORT_M for point in points)


def nearest_other_m(stage: Stage, thing: str, place: Array) -> float:
    """How far the nearest other object is from a place, over the floor, metres; infinite if there is none."""
    others = [object_points(stage, other, POINT_SPACING_M) for other in stage.scene.objects if other != thing]
    return min((float(np.linalg.norm(points[:, :2] - place[:2], axis=1).min()) for points in others), default=math.inf)
