"""Concave meshes as convex parts: found by CoACD [Wei 2022], kept in the user's cache, written as OBJ.

The pieces of a mesh are looked at one by one: what is convex is a part already, only what has hollows is cut. CoACD is
asked for closed pieces that are not too fine, since it takes minutes for others. These, and those with which it comes
to no end, are parted by the cells of a grid instead, at a cost that grows with their size alone.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.common.files import writing
from taskgist.errors import InputError, SceneError
from taskgist.world.geometry import coacd_process
from taskgist.world.geometry.shapes import hull_planes, hull_triangles

# --- Pieces of a mesh, and whether one has hollows that its convex hull would fill.

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


def is_hollow(piece: Piece, *, deeper_than_m: float) -> bool:
    """Whether a piece has a deep hollow: a face that lies so far beneath the convex hull, along its normal.

    What is not closed, such as a bowl without thickness, has one; what is flat has none.
    """
    planes = _planes(piece.vertices)
    if planes is None:
        return False
    if not piece.is_closed:
        return True
    corners = piece.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    return bool(_some_beneath(corners.mean(axis=1), normals, *planes, deeper_than_m))


def is_flat(piece: Piece) -> bool:
    """Whether a piece has no inside."""
    return _planes(piece.vertices) is None


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
    """Normals and offsets of the faces of a convex hull, in the frame of the points; None if they are flat."""
    try:
        model, turn = _compiled_hull(vertices)
    except ValueError:
        return None
    normals, offsets = hull_planes(model, 0)
    normals = normals @ turn.T
    return normals, offsets + normals @ model.mesh_pos[0]


def _compiled_hull(vertices: Array) -> tuple[mujoco.MjModel, Array]:
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


log = logging.getLogger("taskgist.world")
HOLLOW_M = 0.005
"""Hollows up to this depth are filled (ours: half of what a contact may be deeper than usual)."""
HOLLOW_SHARE = 0.01
"""And up to this share of the mesh's extent (ours: a cupboard's mouldings need no parts of their own)."""
MOST_PIECES = 64
"""Meshes of more pieces are cut as a whole."""
SHEET_M = 0.001
"""Thickness given to what has none."""
CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SEARCHED_FACES = 10_000
"""Pieces of more triangles are not searched, but parted by cells: CoACD takes 88 s for 200,000."""
CELLS = 6
"""Cells along the longest edge of the box around what is parted by them."""
PATCHES = 2_000_000
"""Most triangles that are sorted into cells, after the large ones are divided: some seconds."""


def tolerance_m(mesh: Piece) -> float:
    """Depth of the hollows of a mesh that its solid shape may fill, metres."""
    return max(HOLLOW_M, HOLLOW_SHARE * float(np.ptp(mesh.vertices, axis=0).max()))


def parts_name(mesh: Piece) -> str:
    """Name of the file with a mesh's parts, by a digest of what they depend on."""
    content = (np.round(mesh.vertices * 1e6).astype("<i8").tobytes(), mesh.faces.astype("<i8").tobytes())
    search = repr((HOLLOW_M, HOLLOW_SHARE, MOST_PIECES, SHEET_M, sorted(coacd_process.SEARCH.items())))
    if not _is_searched(mesh):
        limit_m = tolerance_m(mesh)
        if any(not _is_searched(each) and is_hollow(each, deeper_than_m=limit_m) for each in _few_pieces(mesh)):
            search += repr((SEARCHED_FACES, CELLS, PATCHES))
    return f"parts-{hashlib.sha256(b''.join((*content, search.encode()))).hexdigest()[:16]}.obj"


def parts_text(mesh: Piece, name: str) -> bytes | None:
    """The convex parts of a mesh as an OBJ document; None if they cannot be found, which is logged.

    Args:
        mesh: A mesh with hollows.
        name: Its name, for messages.
    """
    kept = cache_folder() / parts_name(mesh)
    with suppress(OSError):  # else they are found anew
        if kept.is_file():
            return kept.read_bytes()
    log.info("mesh %r is concave: cutting it into convex parts, once", name)
    found = _cut(mesh, name)
    if found is None:
        return None
    text = _as_obj(found)
    try:
        kept.parent.mkdir(parents=True, exist_ok=True)
        with writing(kept, replace=True) as stream:
            stream.write(text)
    except (OSError, InputError) as error:
        log.info("convex parts are not kept for the next time: %s", error)
    return text


def read_parts(text: bytes) -> list[Array]:
    """Vertices of the parts in an OBJ document, metres, (n, 3) each.

    Raises:
        ValueError: It is no such document.
    """
    parts: list[list[list[float]]] = []
    for line in text.decode("utf-8").splitlines():
        kind, _, rest = line.partition(" ")
        if kind == "o":
            parts.append([])
        elif kind == "v":
            parts[-1].append([float(number) for number in rest.split()])
    arrays = [np.array(part) for part in parts]
    if not arrays or any(array.shape != (len(array), 3) or not np.isfinite(array).all() for array in arrays):
        raise ValueError("an OBJ document with three finite numbers per vertex was expected")
    return arrays


def cache_folder() -> Path:
    """Where parts are kept for the next time, by the platform's convention."""
    if sys.platform == "darwin":
        root = Path.home() / "Library" / "Caches"
    else:
        variable, otherwise = ("LOCALAPPDATA", "AppData/Local") if os.name == "nt" else ("XDG_CACHE_HOME", ".cache")
        root = Path(os.environ.get(variable) or Path.home() / otherwise)
    return root / "taskgist" / "parts"


def _cut(mesh: Piece, name: str) -> list[Piece] | None:
    limit_m = tolerance_m(mesh)
    parts: list[Piece] = []
    for piece in _few_pieces(mesh):
        if is_flat(piece):
            parts.append(_thickened(piece))
        elif not is_hollow(piece, deeper_than_m=limit_m):
            parts.append(piece)
        else:
            cut = _coacd(piece, limit_m, name) if _is_searched(piece) else _by_cells(piece, name)
            if cut is None:
                return None
            parts += cut
    return parts


def _few_pieces(mesh: Piece) -> list[Piece]:
    apart = pieces(mesh)
    return apart if len(apart) <= MOST_PIECES else [mesh]


def _is_searched(piece: Piece) -> bool:
    """Whether CoACD is asked for what has hollows."""
    return piece.is_closed and len(piece.faces) <= SEARCHED_FACES


def _thickened(piece: Piece) -> Piece:
    normal = np.linalg.svd(piece.vertices - piece.vertices.mean(axis=0))[2][-1]
    both = [piece.vertices + sign * SHEET_M / 2 * normal for sign in (-1, 1)]
    return Piece(np.concatenate(both), np.concatenate((piece.faces, piece.faces[:, ::-1] + len(piece.vertices))))


def _coacd(piece: Piece, limit_m: float, name: str) -> list[Piece] | None:
    if not coacd_process.is_there():
        log.warning(
            "mesh %r is concave, but taken for its convex hull: nothing fits into it (to mend: pip install coacd)", name
        )
        return None
    found = coacd_process.searched(piece.vertices, piece.faces, limit_m)
    if found is None:
        problem = "mesh %r is parted by the cells of a grid: CoACD comes to no end with it (to mend: simplify it)"
        log.warning(problem, name)
        return _by_cells(piece, name)
    return [Piece(vertices, faces) for vertices, faces in found]


def _by_cells(piece: Piece, name: str) -> list[Piece] | None:
    """A surface by the cells of a grid, each with the hull of what lies in it; what is flat becomes a sheet."""
    side_m = float(np.ptp(piece.vertices, axis=0).max()) / CELLS
    corners = _divided(piece.corners, side_m / 2)
    if corners is None:
        log.warning(
            "mesh %r is concave, but taken for its convex hull: it has too many large triangles (to mend: simplify it)",
            name,
        )
        return None
    cells = np.floor((corners.mean(axis=1) - piece.vertices.min(axis=0)) / side_m).astype(np.intp)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    order = np.argsort(cell.reshape(-1), kind="stable")
    ends = np.cumsum(np.bincount(cell.reshape(-1)))[:-1]
    return [_hull(np.unique(each.reshape(-1, 3), axis=0)) for each in np.split(corners[order], ends)]


def _divided(corners: Array, longest_m: float) -> Array | None:
    """Triangles, (n, 3, 3), halved until no edge is longer, (m, 3, 3); None if they become too many."""
    done: list[Array] = []
    rest = corners
    while len(rest) + sum(len(each) for each in done) <= PATCHES:
        edges_m = np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2)
        long = edges_m.max(axis=1) > longest_m
        done.append(rest[~long])
        if not long.any():
            return np.concatenate(done)
        first = edges_m[long].argmax(axis=1)[:, None] + np.arange(3)
        a, b, c = np.take_along_axis(rest[long], (first % 3)[:, :, None], axis=1).swapaxes(0, 1)
        middle = (a + b) / 2
        rest = np.concatenate((np.stack((a, middle, c), axis=1), np.stack((middle, b, c), axis=1)))
    return None


def _hull(points: Array) -> Piece:
    """The convex hull of points; what is thinner than a sheet, or a line, is thickened to all sides."""
    thinnest = np.linalg.eigh(np.cov(points.T, bias=True))[1][:, 0]
    if np.ptp(points @ thinnest) < SHEET_M:
        points = (points[:, None] + SHEET_M / 2 * CUBE).reshape(-1, 3)
    model, turn = _compiled_hull(points)
    corners = hull_triangles(model, 0) @ turn.T + model.mesh_pos[0]
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return Piece(vertices, faces.reshape(-1, 3))


def _as_obj(parts: Sequence[Piece]) -> bytes:
    """Rounded to micrometres; any program that opens OBJ shows them."""
    lines, start = ["# convex parts of a mesh, metres"], 1
    for number, part in enumerate(parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices]
        lines += [f"f {a + start} {b + start} {c + start}" for a, b, c in part.faces]
        start += len(part.vertices)
    return ("\n".join(lines) + "\n").encode()


# --- Concave meshes become what they are: a bin can be reached into, a handle grasped.
#
# MuJoCo collides a mesh as its convex hull, while its rays meet the true triangles. Therefore a mesh with hollows
# keeps its looks and stops to collide; convex parts collide in its place, in a group that nobody sees. The parts are
# files of the scene's bundle, so that a recording's scene is the same everywhere. Agents' links stay hulls: only
# whether head, torso and base push into things is asked of them.

SOLID_GROUP = 3
"""Geom group of shapes that block but are not seen."""
PART = "/part"
"""What the name of a part begins with, behind the name of its whole."""


def decompose(
    spec: mujoco.MjSpec, compiled: Callable[[mujoco.MjSpec], mujoco.MjModel], files: dict[str, bytes], where: str
) -> None:
    """Let convex parts collide in the place of a model's concave meshes.

    Args:
        spec: The model of room and objects; changed.
        compiled: Compiles it; only asked if there is a mesh that collides.
        files: The bundle of the scene; files with the parts are added where they are missing.
        where: File name for error messages.

    Raises:
        SceneError: A file with parts is damaged.
    """
    solid = [geom for geom in spec.geoms if _collides(geom)]
    if not solid:
        return
    model = compiled(spec)
    parts = {name: _parts(spec, model, name, files, where) for name in dict.fromkeys(g.meshname for g in solid)}
    for geom in solid:
        if parts[geom.meshname]:
            _replace(geom, parts[geom.meshname])


def whole(name: str) -> str:
    """Name of the shape that a part belongs to; other names stay as they are."""
    return name.partition(PART)[0]


def _collides(geom: mujoco.MjsGeom) -> bool:
    return geom.type == mujoco.mjtGeom.mjGEOM_MESH and bool(geom.contype or geom.conaffinity)


def _parts(
    spec: mujoco.MjSpec, model: mujoco.MjModel, name: str, files: dict[str, bytes], where: str
) -> tuple[str, ...]:
    """Names of the meshes of a concave mesh's parts; none for a convex one."""
    mesh = _mesh(model, name)
    if not is_hollow(mesh, deeper_than_m=tolerance_m(mesh)):
        return ()
    key = parts_name(mesh)
    text = files[key] if key in files else parts_text(mesh, name)
    if text is None:
        return ()
    files[key] = text
    try:
        found = read_parts(text)
    except (ValueError, IndexError) as error:
        hint = "delete it, and it is made anew"
        raise SceneError(
            f"damaged convex parts of mesh {name!r}: {error}", where=f"{where}: {key}", hint=hint
        ) from error
    for number, vertices in enumerate(found):
        spec.add_mesh(name=f"{name}{PART}{number}", uservert=vertices.ravel())
    return tuple(f"{name}{PART}{number}" for number in range(len(found)))


def _mesh(model: mujoco.MjModel, name: str) -> Piece:
    """A compiled mesh in the frame of its file."""
    mesh = model.mesh(name).id
    vertices: Array = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]].astype(np.intp)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh].astype(float))
    return joined(vertices @ turn.reshape(3, 3).T + model.mesh_pos[mesh], faces)


def _replace(geom: mujoco.MjsGeom, parts: tuple[str, ...]) -> None:
    """The shape is only seen from now on; its parts, which weigh nothing, collide."""
    for number, part in enumerate(parts):
        added = geom.parent.add_geom(
            name=f"{geom.name}{PART}{number}" if geom.name else "",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=part,
            pos=geom.pos,
            quat=geom.quat,
            contype=geom.contype,
            conaffinity=geom.conaffinity,
            friction=geom.friction,
            condim=geom.condim,
            group=SOLID_GROUP,
            mass=0,
        )
        for field in ("type", "axisangle", "euler", "xyaxes", "zaxis"):  # other ways to say how it is turned
            setattr(added.alt, field, getattr(geom.alt, field))
    geom.contype = geom.conaffinity = 0
