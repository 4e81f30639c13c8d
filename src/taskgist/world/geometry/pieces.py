"""Pieces of a mesh: what hangs together in it, whether it is closed or flat, and whether its hull fills hollows."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.world.geometry.shapes import hull_planes

SAME_M = 1e-6
"""Vertices nearer than this are one: STL files repeat them in every triangle."""


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


def joined(mesh: Piece) -> Piece:
    """A mesh as it is if it is closed, so that boards that touch stay apart; else with coincident vertices made one."""
    return mesh if mesh.is_closed else merged(mesh)


def merged(mesh: Piece) -> Piece:
    """A mesh whose coincident vertices are one, without the triangles that thereby vanish."""
    _, first, new = np.unique(np.round(mesh.vertices / SAME_M), axis=0, return_index=True, return_inverse=True)
    faces = new.reshape(-1)[mesh.faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Piece(mesh.vertices[first], faces[whole])


def pieces(mesh: Piece, *, most: int | None = None) -> list[Piece]:
    """The parts of a mesh that hang together by edges of two triangles, largest first; closed ones face outwards.

    Args:
        mesh: The mesh.
        most: A mesh that has more of them is left in one piece.
    """
    labels = _labels(mesh.faces)
    names, sizes = np.unique(labels, return_counts=True)
    if most is not None and len(names) > most:
        return [mesh]
    return [_outward(_used(mesh, labels == name)) for name in names[np.argsort(-sizes, kind="stable")]]


def is_hollow(piece: Piece, *, deeper_than_m: float) -> bool:
    """Whether a piece has a deep hollow: a face that lies so far beneath the convex hull, along its normal.

    What is not closed, such as a bowl without thickness, has one; what is flat has none.
    """
    planes = None if is_flat(piece) else _planes(piece.vertices)
    if planes is None:
        return False
    if not piece.is_closed:
        return True
    corners = piece.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    return bool(_some_beneath(corners.mean(axis=1), normals, *planes, deeper_than_m))


FLAT_M = 1e-5
"""What is thinner is flat: exporters round a plane's corners by less, and nothing real is as thin."""
FLAT_SHARE = 1e-5
"""And what is thinner than this share of its extent, for coordinates are kept with seven digits."""
SHEET_M = 0.001
"""Thickness given to what has none."""


def is_flat(piece: Piece) -> bool:
    """Whether a piece has no inside."""
    return bool(_extents_m(piece.vertices)[0] < _negligible_m(piece))


def is_line(piece: Piece) -> bool:
    """Whether a piece has no area."""
    return bool(_extents_m(piece.vertices)[1] < _negligible_m(piece))


def _negligible_m(piece: Piece) -> float:
    return max(FLAT_M, FLAT_SHARE * float(np.ptp(piece.vertices, axis=0).max()))


def is_sheet(piece: Piece) -> bool:
    """Whether a piece is no thicker than what was flat and has been thickened."""
    return bool(_extents_m(piece.vertices)[0] < 1.1 * SHEET_M)


def _extents_m(points: Array) -> Array:
    """How far points, (n, 3), extend along their principal axes, the thinnest first, metres, (3,)."""
    return np.asarray(np.ptp(points @ _axes(points), axis=0))


def _axes(points: Array) -> Array:
    """Principal axes of points as columns, (3, 3): the first is the normal of the plane that fits them best."""
    return np.asarray(np.linalg.eigh(np.cov(points.T, bias=True))[1])


def thickened(piece: Piece, *, front_m: float = SHEET_M / 2) -> Piece:
    """A flat piece as a closed sheet of ``SHEET_M``.

    Args:
        piece: Without thickness. Where its triangles disagree on what its front is, the larger part of them has it.
        front_m: How far the front comes forward; the rest of the thickness lies behind.
    """
    normals = np.cross(piece.corners[:, 1] - piece.corners[:, 0], piece.corners[:, 2] - piece.corners[:, 0])
    across = _axes(piece.vertices)[:, 0]
    ahead = normals @ across
    front = across if ahead.sum() >= 0 else -across
    faces = np.where((normals @ front < 0)[:, None], piece.faces[:, ::-1], piece.faces)[ahead != 0]
    faces = faces[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]]  # some show both sides
    count = len(piece.vertices)
    edges = _edges(faces)
    there = set(map(tuple, edges.tolist()))
    rim = np.array([(a, b) for a, b in edges.tolist() if (b, a) not in there], dtype=np.intp).reshape(-1, 2)
    a, b = rim.T
    walls = np.concatenate((np.stack((a, a + count, b + count), axis=1), np.stack((a, b + count, b), axis=1)))
    vertices = np.concatenate((piece.vertices + front_m * front, piece.vertices + (front_m - SHEET_M) * front))
    return Piece(vertices, np.concatenate((faces, faces[:, ::-1] + count, walls)))


@compiled
def _some_beneath(points: Array, directions: Array, normals: Array, offsets: Array, limit_m: float) -> bool:
    """Whether the direction of some point leaves a convex hull farther away than the limit.

    The first plane that a direction crosses sooner settles its point: fine meshes are looked through in no time.
    """
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        dx, dy, dz = directions[i, 0], directions[i, 1], directions[i, 2]
        beneath = True
        for k in range(len(offsets)):
            nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
            rate = dx * nx + dy * ny + dz * nz
            if rate > 1e-9 and offsets[k] - (x * nx + y * ny + z * nz) <= limit_m * rate:
                beneath = False
                break
        if beneath:
            return True
    return False


def _planes(vertices: Array) -> tuple[Array, Array] | None:
    """Normals and offsets of the faces of a convex hull, of points; None if next to nothing is in it."""
    try:
        model, turn = compiled_hull(vertices)
    except ValueError:
        return None
    normals, offsets = hull_planes(model, 0)
    normals = normals @ turn.T
    return normals, offsets + normals @ model.mesh_pos[0]


def compiled_hull(vertices: Array) -> tuple[mujoco.MjModel, Array]:
    """A model of a mesh that is the hull of some points, and how it is turned, (3, 3); ValueError if they are flat."""
    spec = mujoco.MjSpec()
    spec.add_mesh(name="hull", uservert=vertices.ravel())
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="hull")
    model = spec.compile()
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[0].astype(float))
    return model, turn.reshape(3, 3)


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


def _used(mesh: Piece, chosen: Mask) -> Piece:
    used, faces = np.unique(mesh.faces[chosen], return_inverse=True)
    return Piece(mesh.vertices[used], faces.reshape(-1, 3))


def _outward(piece: Piece) -> Piece:
    inside_out = piece.is_closed and float(np.linalg.det(piece.corners).sum()) < 0
    return Piece(piece.vertices, piece.faces[:, ::-1]) if inside_out else piece


def mesh_of(model: mujoco.MjModel, name: str) -> Piece:
    """A compiled mesh in the frame of its file, its vertices and triangles as they are there."""
    mesh = model.mesh(name).id
    vertices: Array = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]].astype(np.intp)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh].astype(float))
    return Piece(vertices @ turn.reshape(3, 3).T + model.mesh_pos[mesh], faces)
