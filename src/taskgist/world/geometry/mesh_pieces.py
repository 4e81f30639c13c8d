"""Pieces of a mesh, and whether one has hollows that its convex hull would fill."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.solids import hull_planes

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
SAME_M = 1e-6
"""Vertices nearer than this are one: STL files repeat them in every triangle."""
ROWS = 4096
"""Faces looked at at once."""


@dataclass(frozen=True, eq=False)
class Piece:
    """A mesh: vertices in metres, (n, 3), and the vertices of each triangle, (m, 3)."""

    vertices: Array
    faces: Indices

    @property
    def corners(self) -> Array:
        """Corners of the triangles, metres, (m, 3, 3)."""
        return np.asarray(self.vertices[self.faces])

    @property
    def is_closed(self) -> bool:
        """Whether every edge joins two triangles that agree on what is outside."""
        edges = _edges(self.faces)
        return len(np.unique(edges, axis=0)) == len(edges) and set(map(tuple, edges)) == set(map(tuple, edges[:, ::-1]))


def joined(vertices: Array, faces: Indices) -> Piece:
    """A mesh as it is if it is closed, so that boards that touch stay apart; else with coincident vertices made one."""
    mesh = Piece(vertices, faces)
    return mesh if mesh.is_closed else _merged(vertices, faces)


def _merged(vertices: Array, faces: Indices) -> Piece:
    """A mesh whose coincident vertices are one, without the triangles that thereby vanish."""
    _, first, new = np.unique(np.round(vertices / SAME_M), axis=0, return_index=True, return_inverse=True)
    faces = new.reshape(-1)[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Piece(vertices[first], faces[whole])


def pieces(mesh: Piece) -> list[Piece]:
    """The parts of a mesh that hang together by edges of two triangles, largest first; closed ones face outwards."""
    labels = _labels(mesh.faces)
    names, sizes = np.unique(labels, return_counts=True)
    return [_outward(_used(mesh, labels == name)) for name in names[np.argsort(-sizes, kind="stable")]]


def hollow_m(piece: Piece) -> float:
    """Depth of a piece's deepest hollow, metres: how far a face lies beneath the convex hull, along its normal.

    Infinite for what is not closed, such as a bowl without thickness, and 0 for what is flat.
    """
    planes = _planes(piece.vertices)
    if planes is None:
        return 0.0
    if not piece.is_closed:
        return float("inf")
    corners = piece.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    middles = corners.mean(axis=1)
    rows = range(0, len(middles), ROWS)
    return max(float(_exits_m(middles[i : i + ROWS], normals[i : i + ROWS], *planes).max()) for i in rows)


def is_flat(piece: Piece) -> bool:
    """Whether a piece has no inside."""
    return _planes(piece.vertices) is None


def _exits_m(points: Array, directions: Array, normals: Array, offsets: Array) -> Array:
    """How far from each point its direction leaves a convex hull, (n,)."""
    rates, rooms = directions @ normals.T, offsets - points @ normals.T
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(rates > 1e-9, rooms / rates, np.inf)
    return np.asarray(ways.min(axis=1))


def _planes(vertices: Array) -> tuple[Array, Array] | None:
    """Normals and offsets of the faces of a convex hull, in the frame of the points; None if they are flat."""
    spec = mujoco.MjSpec()
    spec.add_mesh(name="hull", uservert=vertices.ravel())
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull")
    try:
        model = spec.compile()
    except ValueError:
        return None
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[0].astype(float))
    normals, offsets = hull_planes(model, 0)
    normals = normals @ turn.reshape(3, 3).T
    return normals, offsets + normals @ model.mesh_pos[0]


def _edges(faces: Indices) -> Indices:
    return np.concatenate((faces[:, (0, 1)], faces[:, (1, 2)], faces[:, (2, 0)]))


def _labels(faces: Indices) -> Indices:
    """A number for each triangle, the same for those that hang together."""
    edges = np.sort(_edges(faces), axis=1)
    _, edge, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    edge = edge.reshape(-1)
    shared = np.flatnonzero(count[edge] == 2)
    a, b = (shared[np.argsort(edge[shared], kind="stable")].reshape(-1, 2) % len(faces)).T
    labels = np.arange(len(faces))
    while True:
        before = labels.copy()
        least = np.minimum(labels[a], labels[b])
        np.minimum.at(labels, a, least)
        np.minimum.at(labels, b, least)
        labels = labels[labels]
        if np.array_equal(labels, before):
            return labels


def _used(mesh: Piece, chosen: NDArray[np.bool_]) -> Piece:
    used, faces = np.unique(mesh.faces[chosen], return_inverse=True)
    return Piece(mesh.vertices[used], faces.reshape(-1, 3))


def _outward(piece: Piece) -> Piece:
    inside_out = piece.is_closed and float(np.linalg.det(piece.corners).sum()) < 0
    return Piece(piece.vertices, piece.faces[:, ::-1]) if inside_out else piece
