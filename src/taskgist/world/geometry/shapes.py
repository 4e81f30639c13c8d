"""Points on the surfaces of shapes, in the shape's own frame: what "some cell of the object" means in numbers.

Sampling in the object's own frame makes every answer independent of where the room stands and which way it faces.
"""

from __future__ import annotations

import math
from functools import lru_cache

import mujoco
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Geom = mujoco.mjtGeom
SHRINK = 1e-3
"""How far inner points lie from the edges, of the way to the middle of the shape or triangle."""


def surface_points(model: mujoco.MjModel, geom: int, spacing_m: float) -> tuple[Array, Array]:
    """Sample the surface of a shape.

    Args:
        model: The model.
        geom: Index of the shape.
        spacing_m: Largest distance between neighbours, metres.

    Returns:
        Points (n, 3) in metres and outward unit normals (n, 3), both in the shape's frame. A plane has none.
    """
    kind = int(model.geom_type[geom])
    if kind == Geom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]), spacing_m)
    return _primitive(kind, _size(model, geom), spacing_m, least=2)


def _size(model: mujoco.MjModel, geom: int) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in model.geom_size[geom])
    return x, y, z


def inner_points(model: mujoco.MjModel, geom: int, spacing_m: float) -> tuple[Array, Array]:
    """As ``surface_points``, but none on an edge, where rays graze the next face, and some amid every face."""
    if int(model.geom_type[geom]) == Geom.mjGEOM_MESH:
        return _mesh(model, int(model.geom_dataid[geom]), spacing_m, from_edges=SHRINK)
    points, normals = _primitive(int(model.geom_type[geom]), _size(model, geom), spacing_m, least=3)
    return points * (1 - SHRINK), normals


@lru_cache(maxsize=512)
def _primitive(kind: int, size: tuple[float, float, float], spacing_m: float, *, least: int) -> tuple[Array, Array]:
    if kind == Geom.mjGEOM_BOX:
        return _box(size, spacing_m, least)
    if kind == Geom.mjGEOM_SPHERE:
        return _ellipsoid((size[0],) * 3, spacing_m)
    if kind == Geom.mjGEOM_ELLIPSOID:
        return _ellipsoid(size, spacing_m)
    if kind in (Geom.mjGEOM_CYLINDER, Geom.mjGEOM_CAPSULE):
        return _round(size[0], size[1], spacing_m, least, caps=kind == Geom.mjGEOM_CAPSULE)
    return np.empty((0, 3)), np.empty((0, 3))


def _steps(length_m: float, spacing_m: float, least: int) -> int:
    return max(least, math.ceil(length_m / spacing_m) + 1)


def _box(half: tuple[float, float, float], spacing_m: float, least: int) -> tuple[Array, Array]:
    points, normals = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        grid_u = np.linspace(-half[u], half[u], _steps(2 * half[u], spacing_m, least))
        grid_v = np.linspace(-half[v], half[v], _steps(2 * half[v], spacing_m, least))
        a, b = (g.ravel() for g in np.meshgrid(grid_u, grid_v, indexing="ij"))
        for sign in (-1.0, 1.0):
            face = np.zeros((a.size, 3))
            face[:, axis], face[:, u], face[:, v] = sign * half[axis], a, b
            normal = np.zeros((a.size, 3))
            normal[:, axis] = sign
            points.append(face)
            normals.append(normal)
    return np.concatenate(points), np.concatenate(normals)


def _sphere_directions(count_around: int) -> Array:
    """Unit vectors on rings of latitude, poles included, with whole-ring symmetry."""
    rings = max(3, count_around // 2 + 1)
    directions = []
    for latitude in np.linspace(-math.pi / 2, math.pi / 2, rings):
        around = max(1, round(count_around * math.cos(latitude)))
        longitude = 2 * math.pi * np.arange(around) / around
        ring = np.stack((np.cos(longitude), np.sin(longitude), np.zeros(around)), axis=1) * math.cos(latitude)
        ring[:, 2] = math.sin(latitude)
        directions.append(ring)
    return np.concatenate(directions)


def _around(radius_m: float, spacing_m: float) -> int:
    return 4 * max(2, math.ceil(2 * math.pi * radius_m / spacing_m / 4))


def _ellipsoid(radii: tuple[float, ...], spacing_m: float) -> tuple[Array, Array]:
    directions = _sphere_directions(_around(max(radii), spacing_m))
    normals = directions / np.asarray(radii)
    return directions * radii, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _round(radius: float, half: float, spacing_m: float, least: int, *, caps: bool) -> tuple[Array, Array]:
    """Cylinder, or with ``caps`` a capsule, along z."""
    around = _around(radius, spacing_m)
    angles = 2 * math.pi * np.arange(around) / around
    ring = np.stack((np.cos(angles), np.sin(angles), np.zeros(around)), axis=1)
    heights = np.linspace(-half, half, _steps(2 * half, spacing_m, least))
    wall = np.concatenate([ring * radius + (0, 0, z) for z in heights])
    points, normals = [wall], [np.tile(ring, (len(heights), 1))]
    for sign in (-1.0, 1.0):
        if caps:
            dome = _sphere_directions(around)
            dome = dome[dome[:, 2] * sign > 1e-9]
            points.append(dome * radius + (0, 0, sign * half))
            normals.append(dome)
        else:
            radii = np.linspace(0, radius, _steps(radius, spacing_m, least))
            disc = np.concatenate([ring * r for r in radii[1:]] + [np.zeros((1, 3))]) + (0, 0, sign * half)
            points.append(disc)
            normals.append(np.tile((0.0, 0.0, sign), (len(disc), 1)))
    return np.concatenate(points), np.concatenate(normals)


THINNING = 8
"""Points of a mesh that share a cell of an eighth of the spacing count once: fine meshes have more than needed."""


def _mesh(model: mujoco.MjModel, mesh: int, spacing_m: float, from_edges: float = 0.0) -> tuple[Array, Array]:
    """Triangle samples of a mesh, at barycentric grids fine enough for the spacing."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    corner, ab, ac = vertices[faces[:, 0]], *(vertices[faces[:, k]] - vertices[faces[:, 0]] for k in (1, 2))
    normals = np.cross(ab, ac)
    areas = np.linalg.norm(normals, axis=1)
    longest = np.max([np.linalg.norm(edge, axis=1) for edge in (ab, ac, ac - ab)], axis=0)
    steps = np.maximum(1, np.ceil(longest / spacing_m).astype(int))
    points, outward = [], []
    for count in np.unique(steps[areas > 0]):
        chosen = (steps == count) & (areas > 0)
        weights = np.array([(i, j) for i in range(count + 1) for j in range(count + 1 - i)]) / count
        weights += from_edges * (1 / 3 - weights)
        edges = np.stack((ab[chosen], ac[chosen]), axis=1)
        points.append((corner[chosen][:, None] + weights @ edges).reshape(-1, 3))
        outward.append(np.repeat(normals[chosen] / areas[chosen][:, None], len(weights), axis=0))
    return _thinned(np.concatenate(points), np.concatenate(outward), spacing_m / THINNING)


def _thinned(points: Array, normals: Array, cell_m: float) -> tuple[Array, Array]:
    """One point per cell and side of the surface."""
    keys = np.concatenate((np.floor(points / cell_m), np.round(normals)), axis=1)
    first = np.sort(np.unique(keys, axis=0, return_index=True)[1])
    return points[first], normals[first]


def lowest_point(model: mujoco.MjModel, geom: int, matrix: Array) -> Array | None:
    """Lowest point (3,) of a shape in its own frame, exact for primitives; None for planes.

    Args:
        model: The model.
        geom: Index of the shape.
        matrix: Rotation (3, 3) of the shape in the world.
    """
    down = -matrix[2]
    size = model.geom_size[geom]
    kind = int(model.geom_type[geom])
    if kind == Geom.mjGEOM_SPHERE:
        return np.asarray(down * size[0])
    if kind == Geom.mjGEOM_ELLIPSOID:
        return np.asarray(size * size * down / np.linalg.norm(size * down))
    if kind in (Geom.mjGEOM_CAPSULE, Geom.mjGEOM_CYLINDER):
        end = np.array([0.0, 0.0, math.copysign(size[1], down[2])])
        flat = down if kind == Geom.mjGEOM_CAPSULE else np.array([down[0], down[1], 0.0])
        length = float(np.linalg.norm(flat))
        return np.asarray(end + (flat * size[0] / length if length > 1e-9 else 0.0))
    if kind == Geom.mjGEOM_BOX:
        return np.asarray(np.copysign(size, down))
    if kind == Geom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
        return np.asarray(vertices[np.argmax(vertices @ down)], dtype=float)
    return None
