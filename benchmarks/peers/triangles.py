"""Shapes as triangles, for peers that know nothing else."""

from __future__ import annotations

import itertools
import math

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Faces = NDArray[np.int32]
Geom = mujoco.mjtGeom
AROUND = 48
"""Corners of a circle: its polygon lacks 0.3 % of its area."""
FLOOR_HALF_M = 20.0


def triangles(model: mujoco.MjModel, geom: int) -> tuple[Array, Faces]:
    """Corners (n, 3) in metres in the shape's frame, and triangles (m, 3), seen from outside counter-clockwise."""
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == Geom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]))
    if kind == Geom.mjGEOM_PLANE:
        half = [value if value > 0 else FLOOR_HALF_M for value in size[:2]]
        return _box(np.array([*half, 0.05])) - np.array([0, 0, 0.05]), _BOX_FACES
    if kind == Geom.mjGEOM_BOX:
        return _box(size), _BOX_FACES
    return _turned(*_profile(kind, size), squash=size[1] / size[0] if kind == Geom.mjGEOM_ELLIPSOID else 1.0)


def _mesh(model: mujoco.MjModel, mesh: int) -> tuple[Array, Faces]:
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    start, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    return model.mesh_vert[first : first + count].astype(float), model.mesh_face[start : start + faces].astype(np.int32)


def _box(half: Array) -> Array:
    return np.array(list(itertools.product((-1.0, 1.0), repeat=3))) * half


_BOX_FACES: Faces = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
     (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)], dtype=np.int32,
)  # fmt: skip


def _profile(kind: int, size: Array) -> tuple[Array, Array]:
    """Radii and heights, from the lower to the upper pole, whose turn about z is the shape."""
    angles = np.linspace(-math.pi / 2, math.pi / 2, AROUND // 2 + 1)
    if kind == Geom.mjGEOM_CYLINDER:
        return np.array([0.0, size[0], size[0], 0.0]), np.array([-size[1], -size[1], size[1], size[1]])
    if kind == Geom.mjGEOM_CAPSULE:
        lower, upper = angles[: AROUND // 4 + 1], angles[AROUND // 4 :]
        radii = size[0] * np.cos(np.concatenate((lower, upper)))
        heights = np.concatenate((size[0] * np.sin(lower) - size[1], size[0] * np.sin(upper) + size[1]))
        return radii, heights
    height = size[2] if kind == Geom.mjGEOM_ELLIPSOID else size[0]
    return size[0] * np.cos(angles), height * np.sin(angles)


def _turned(radii: Array, heights: Array, *, squash: float) -> tuple[Array, Faces]:
    """A profile turned about z; y is squashed."""
    around = 2 * math.pi * np.arange(AROUND) / AROUND
    ring = np.stack((np.cos(around), squash * np.sin(around)), axis=1)
    flat = (radii[:, None, None] * ring).reshape(-1, 2)
    corners = np.concatenate((flat, np.repeat(heights, AROUND)[:, None]), axis=1)
    low, column = (each.ravel() for each in np.meshgrid(np.arange(len(radii) - 1), np.arange(AROUND), indexing="ij"))
    following = (column + 1) % AROUND
    a, b = low * AROUND + column, low * AROUND + following
    faces = np.concatenate((np.stack((a, b, b + AROUND), axis=1), np.stack((a, b + AROUND, a + AROUND), axis=1)))
    return corners, faces.astype(np.int32)
