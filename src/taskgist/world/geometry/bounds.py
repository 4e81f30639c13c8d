"""Bounds that hold all that is seen.

MuJoCo casts many rays at once past bodies whose box they miss, and makes that box of the shapes that collide. What a
body only shows may stick out of it, as the visual meshes of most robots do, and rays would pass through.
"""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.rotations import conjugate, rotate

Array = NDArray[np.float64]
SIGNS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def bound_all_shapes(model: mujoco.MjModel) -> None:
    """Widen each body's box in a compiled model to all of its shapes."""
    for body in range(model.nbody):
        geoms = np.flatnonzero(model.geom_bodyid == body)
        if model.body_bvhnum[body] and not _collide(model, geoms).all() and _bounded(model, geoms).all():
            box = model.bvh_aabb[model.body_bvhadr[body]]
            corners = [_corners(model, body, int(geom)) for geom in geoms]
            points = np.concatenate([box[:3] + SIGNS * box[3:], *corners])
            low, high = points.min(axis=0), points.max(axis=0)
            model.bvh_aabb[model.body_bvhadr[body]] = (*(low + high) / 2, *(high - low) / 2)


def _collide(model: mujoco.MjModel, geoms: NDArray[np.intp]) -> NDArray[np.bool_]:
    return np.asarray((model.geom_contype[geoms] != 0) | (model.geom_conaffinity[geoms] != 0))


def _bounded(model: mujoco.MjModel, geoms: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Planes have no end."""
    return np.asarray(model.geom_rbound[geoms] > 0)


def _corners(model: mujoco.MjModel, body: int, geom: int) -> Array:
    """Corners (8, 3) of a shape's box in the frame of the body's inertia, in which MuJoCo keeps its boxes."""
    box = model.geom_aabb[geom]
    in_body = model.geom_pos[geom] + rotate(model.geom_quat[geom], box[:3] + SIGNS * box[3:])
    return rotate(conjugate(model.body_iquat[body]), in_body - model.body_ipos[body])
