"""Shapes as points: on their surfaces, inside of them, and how far points lie outside.

Sampling in the object's own frame makes every answer independent of where the room stands and which way it faces.
"""

from __future__ import annotations

import math
from functools import lru_cache

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.compiled import compiled

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


THINNEST_M = 1e-4
"""Meshes count as no thinner than this where their points are thinned."""
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
    """One point per cell and side of the surface; of a shape thinner than a cell, at both edges of its sides."""
    thin_m = np.maximum(np.ptp(points, axis=0) / 2, THINNEST_M)
    cells = np.floor(points / np.minimum(cell_m, thin_m))
    keys = np.concatenate((cells, np.round(normals)), axis=1)
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


# --- How far points lie outside of solid shapes, as MuJoCo collides them: meshes by their convex hulls.


def distances_outside_m(model: mujoco.MjModel, geom: int, points: Array, *, within_m: float = math.inf) -> Array:
    """A lower bound on how far points are from a shape, in metres; negative inside.

    Exact beside a face; beside an edge or a corner the points may be farther away.

    Args:
        model: The model.
        geom: Index of the shape.
        points: Metres, in the shape's own frame, (n, 3).
        within_m: Points farther out need only be known to be so: the sooner this is clear, the quicker.

    Returns:
        Metres, (n,); infinite for shapes that have no inside.
    """
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == Geom.mjGEOM_MESH:
        return _outside_planes(points, *hull_planes(model, int(model.geom_dataid[geom])), within_m)
    if kind == Geom.mjGEOM_BOX:
        return np.asarray((np.abs(points) - size).max(axis=1))
    if kind in (Geom.mjGEOM_SPHERE, Geom.mjGEOM_ELLIPSOID):
        radii = np.broadcast_to(size[0], 3) if kind == Geom.mjGEOM_SPHERE else size
        return np.asarray((np.linalg.norm(points / radii, axis=1) - 1) * radii.min())
    beyond = np.abs(points[:, 2]) - size[1]
    if kind == Geom.mjGEOM_CAPSULE:
        axis = np.maximum(beyond, 0.0)
        return np.asarray(np.hypot(np.linalg.norm(points[:, :2], axis=1), axis) - size[0])
    if kind == Geom.mjGEOM_CYLINDER:
        return np.asarray(np.maximum(np.linalg.norm(points[:, :2], axis=1) - size[0], beyond))
    return np.full(len(points), np.inf)


def hull_planes(model: mujoco.MjModel, mesh: int) -> tuple[Array, Array]:
    """Outward normals (m, 3) and offsets (m,) of the faces of a mesh's convex hull; of the mesh if it has no hull."""
    corners = hull_triangles(model, mesh)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    whole = areas > 0
    normals = normals[whole] / areas[whole][:, None]
    return normals, np.einsum("ij,ij->i", normals, corners[whole, 0])


def hull_triangles(model: mujoco.MjModel, mesh: int) -> Array:
    """Corners of the triangles of a mesh's convex hull, metres, (m, 3, 3), counter-clockwise from outside."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    start = int(model.mesh_graphadr[mesh])
    if start < 0:
        faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        return np.asarray(vertices[faces])
    vertex_count, face_count = (int(count) for count in model.mesh_graph[start : start + 2])
    first = start + 2 + 3 * vertex_count + 3 * face_count  # after counts, edge addresses, global ids and edges
    faces = model.mesh_graph[first : first + 3 * face_count].reshape(-1, 3)
    return np.asarray(vertices[faces])


@compiled
def _outside_planes(points: Array, normals: Array, offsets: Array, within_m: float) -> Array:
    outside_m = np.full(len(points), -np.inf)
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        for k in range(len(offsets)):
            beyond_m = x * normals[k, 0] + y * normals[k, 1] + z * normals[k, 2] - offsets[k]
            outside_m[i] = max(outside_m[i], beyond_m)
            if beyond_m > within_m:
                break
    return outside_m


def spans_m(model: mujoco.MjModel, geom: int, directions: Array) -> tuple[Array, Array]:
    """How far a shape extends from its frame's origin, as MuJoCo collides it.

    Args:
        model: The model.
        geom: Index of the shape.
        directions: Unit vectors in the shape's frame, (..., 3).

    Returns:
        The least and the greatest coordinate along each, metres, (...) each; infinite for endless shapes.
    """
    kind, size = int(model.geom_type[geom]), model.geom_size[geom]
    if kind == Geom.mjGEOM_MESH:
        corners = np.unique(hull_triangles(model, int(model.geom_dataid[geom])).reshape(-1, 3), axis=0)
        along = directions @ corners.T
        return np.asarray(along.min(axis=-1)), np.asarray(along.max(axis=-1))
    flat, rise = np.hypot(directions[..., 0], directions[..., 1]), np.abs(directions[..., 2])
    if kind == Geom.mjGEOM_BOX:
        half = np.abs(directions) @ size
    elif kind == Geom.mjGEOM_ELLIPSOID:
        half = np.linalg.norm(directions * size, axis=-1)
    elif kind == Geom.mjGEOM_CYLINDER:
        half = rise * size[1] + flat * size[0]
    elif kind == Geom.mjGEOM_CAPSULE:
        half = rise * size[1] + size[0]
    else:
        half = np.full(flat.shape, size[0] if kind == Geom.mjGEOM_SPHERE else np.inf)
    return -half, np.asarray(half)
