"""Where there is a support."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Stage

Array = NDArray[np.float64]

POINT_SPACING_M = 0.02
LIFT_M, SUPPORT_M = 0.05, 0.005
"""From how high a support is searched, and how far it may be from where it is expected."""


def supported(stage: Stage, points: Array) -> bool:
    """Whether there is a support just beneath each of some points, metres, (n, 3); people's laps are none."""
    return all(_is_support(stage, point) for point in points)


def _is_support(stage: Stage, point: Array) -> bool:
    (geom,), (distance,) = stage.cast(point + (0.0, 0.0, LIFT_M), [(0.0, 0.0, -1.0)])
    owner = stage.scene.owners[geom] if geom >= 0 else None
    return bool(abs(distance - LIFT_M) < SUPPORT_M) and owner not in stage.scene.agents
