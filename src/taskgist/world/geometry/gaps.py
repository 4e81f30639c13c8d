"""Signed gaps between two shapes.

MuJoCo measures them, except one that it misses: a capsule whose axis goes right through a thin box, as a thigh
through a table top, counts as free of it, for only its ends are held against the box. There the capsule is at least
as deep in the box as its radius, and deeper by as much as its axis is.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.raycast import local

Array = NDArray[np.float64]

BOX, CAPSULE = int(mujoco.mjtGeom.mjGEOM_BOX), int(mujoco.mjtGeom.mjGEOM_CAPSULE)


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
        depth_m = axis_depth_m(
            data.geom_xpos[capsule],
            data.geom_xmat[capsule],
            float(model.geom_size[capsule, 1]),
            data.geom_xpos[box],
            data.geom_xmat[box],
            model.geom_size[box],
        )
        if depth_m >= 0.0:
            return -depth_m - float(model.geom_size[capsule, 0])
    return float(mujoco.mj_geomDistance(model, data, geom, other, limit_m, None))


@compiled
def axis_depth_m(
    middle: Array, matrix: Array, half_length_m: float, position: Array, frame: Array, half: Array
) -> float:
    """How deep in a box the middle of that piece of a capsule's axis is which lies inside; −1 if none does.

    Args:
        middle: Centre of the capsule, metres, (3,).
        matrix: How it is turned, its axis along z, (9,).
        half_length_m: Half length of its axis.
        position: Centre of the box, metres, (3,).
        frame: How it is turned, (9,).
        half: Its half sizes, metres, (3,).
    """
    at = local(frame, middle - position)
    reach = local(frame, half_length_m * matrix[2::3])
    enter, leave = -1.0, 1.0
    for axis in range(3):
        if abs(reach[axis]) < 1e-12:
            if abs(at[axis]) > half[axis]:
                return -1.0
            continue
        near, far = (-half[axis] - at[axis]) / reach[axis], (half[axis] - at[axis]) / reach[axis]
        enter, leave = max(enter, min(near, far)), min(leave, max(near, far))
    if enter > leave:
        return -1.0
    depth_m = math.inf
    for axis in range(3):
        depth_m = min(depth_m, half[axis] - abs(at[axis] + (enter + leave) / 2 * reach[axis]))
    return depth_m
