"""Signed gaps between two shapes.

MuJoCo measures them, except one that it misses: a capsule whose axis goes right through a thin box, as a thigh
through a table top, counts as free of it, for only its ends are held against the box. There the capsule is at least
as deep in the box as its radius, and deeper by as much as its axis is.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

BOX, CAPSULE = int(mujoco.mjtGeom.mjGEOM_BOX), int(mujoco.mjtGeom.mjGEOM_CAPSULE)
AXIS = 2


def gap_m(model: mujoco.MjModel, data: mujoco.MjData, geom: int, other: int, *, limit_m: float) -> float:
    """Signed gap in metres between two shapes (negative: how deep they overlap), at most ``limit_m``.

    Args:
        model: The model.
        data: Where its shapes are.
        geom: Index of one shape.
        other: Index of the other.
        limit_m: Gaps wider than this are not measured.
    """
    kinds = int(model.geom_type[geom]), int(model.geom_type[other])
    if kinds in ((CAPSULE, BOX), (BOX, CAPSULE)):
        capsule, box = (geom, other) if kinds[0] == CAPSULE else (other, geom)
        depth = _axis_depth_m(model, data, capsule, box)
        if depth is not None:
            return -depth - float(model.geom_size[capsule][0])
    return float(mujoco.mj_geomDistance(model, data, geom, other, limit_m, None))


def _axis_depth_m(model: mujoco.MjModel, data: mujoco.MjData, capsule: int, box: int) -> float | None:
    """How deep in a box the middle of that piece of a capsule's axis is which lies inside; None if none does."""
    half: NDArray[np.float64] = model.geom_size[box]
    frame = data.geom_xmat[box].reshape(3, 3)
    middle = (data.geom_xpos[capsule] - data.geom_xpos[box]) @ frame
    reach = float(model.geom_size[capsule][1]) * (data.geom_xmat[capsule].reshape(3, 3)[:, AXIS] @ frame)
    enter, leave = -1.0, 1.0
    for at, along, side in zip(middle.tolist(), reach.tolist(), half.tolist(), strict=True):
        if abs(along) < 1e-12:
            if abs(at) > side:
                return None
            continue
        near, far = sorted(((-side - at) / along, (side - at) / along))
        enter, leave = max(enter, near), min(leave, far)
    if enter > leave:
        return None
    return float(np.min(half - np.abs(middle + (enter + leave) / 2 * reach)))
