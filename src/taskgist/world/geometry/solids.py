"""How far points lie outside of solid shapes, as MuJoCo collides them: meshes by their convex hulls."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Geom = mujoco.mjtGeom


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
