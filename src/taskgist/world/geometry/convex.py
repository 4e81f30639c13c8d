"""Concave meshes as convex parts: found by CoACD [Wei 2022], kept in the user's cache, written as OBJ.

The pieces of a mesh are looked at one by one: what is convex is a part already, only what has hollows is cut. CoACD is
asked for closed pieces that are not too fine, since it takes minutes for others. These, and those with which it comes
to no end, are parted by the cells of a grid instead, at a cost that grows with their size alone.

Time is bounded for all meshes of a scene together, and so are the parts of each. What is left then collides as its
convex hull. A document of parts says so in its first line, and whoever loads the scene is told.
"""

from __future__ import annotations

import hashlib
import logging
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.files import writing
from taskgist.errors import InputError, SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.geometry import coacd_process
from taskgist.world.geometry.pieces import (
    SHEET_M,
    Piece,
    compiled_hull,
    is_flat,
    is_hollow,
    is_sheet,
    joined,
    mesh_of,
    pieces,
    thickened,
)
from taskgist.world.geometry.shapes import hull_triangles

log = logging.getLogger("taskgist.world")
HOLLOW_M = 0.005
"""Hollows up to this depth are filled (ours: half of what a contact may be deeper than usual)."""
HOLLOW_SHARE = 0.01
"""And up to this share of the mesh's extent (ours: a cupboard's mouldings need no parts of their own)."""
MOST_PIECES = 64
"""Meshes of more pieces are cut as a whole."""
CUBE = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
SEARCHED_FACES = 10_000
"""Pieces of more triangles are not searched, but parted by cells: CoACD takes 88 s for 200,000."""
CELLS = 6
"""Cells along the longest edge of the box around what is parted by them."""
PATCHES = 2_000_000
"""Most triangles that are sorted into cells, after the large ones are divided: some seconds."""


SHEET_FACES = 256
"""Sheets of no more triangles are parted by these."""
HEAD = "# convex parts of a mesh, metres"
COARSE = ": "
LONGEST_REASON = 300
NO_END = "and parted by the cells of a grid: CoACD comes to no end (to mend: simplify it)"
NO_COACD = "but the convex hull is taken: nothing fits into hollows (to mend: pip install coacd)"
TOO_LARGE = "but the convex hull is taken: too many large triangles (to mend: simplify it)"
NO_TIME = (
    "but the convex hull is taken, as the time for cutting ran out (to mend: simplify meshes, raise limits.cutting_s, "
    "or load the scene again: what was cut so far is kept)"
)
TOO_MANY = "but the convex hull is taken: more than {:,} parts (to mend: simplify it, or raise limits.mesh_parts)"
NAMED = 5
"""Meshes that are named in one warning."""


def tolerance_m(mesh: Piece) -> float:
    """Depth of the hollows of a mesh that its solid shape may fill, metres."""
    return max(HOLLOW_M, HOLLOW_SHARE * float(np.ptp(mesh.vertices, axis=0).max()))


def parts_name(mesh: Piece) -> str:
    """Name of the file with a mesh's parts, by a digest of what they depend on."""
    content = (np.round(mesh.vertices * 1e6).astype("<i8").tobytes(), mesh.faces.astype("<i8").tobytes())
    search = repr((HOLLOW_M, HOLLOW_SHARE, MOST_PIECES, SHEET_M, sorted(coacd_process.SEARCH.items())))
    if not _is_searched(mesh):
        limit_m = tolerance_m(mesh)
        if any(
            not _is_searched(each) and is_hollow(each, deeper_than_m=limit_m) for each in pieces(mesh, most=MOST_PIECES)
        ):
            search += repr((SEARCHED_FACES, CELLS, PATCHES))
    return f"parts-{hashlib.sha256(b''.join((*content, search.encode()))).hexdigest()[:16]}.obj"


def _kept(key: str) -> bytes | None:
    """The document with a mesh's parts that was made before on this machine, if it is there."""
    with suppress(OSError):  # else they are found anew
        kept = cache_folder() / key
        if kept.is_file():
            return kept.read_bytes()
    return None


def _parts_text(mesh: Piece, key: str, until_s: float, *, is_first: bool) -> bytes:
    """The convex parts of a mesh with hollows as an OBJ document, whose first line tells what is coarse in it.

    Args:
        mesh: The mesh.
        key: Name of the document in the cache.
        until_s: When no more is searched, on the clock of ``time.monotonic``.
        is_first: Whether no mesh was cut before it: then another time would not get farther.
    """
    cutting = _Cutting(mesh, until_s, is_first=is_first)
    text = _as_obj(cutting.parts, cutting.coarse)
    if cutting.is_final:
        try:
            kept = cache_folder() / key
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


class _Cutting:
    """How a mesh is cut.

    Attributes:
        parts: What was found.
        coarse: What is coarser than asked for in it, and the way out; empty if nothing is.
        is_final: Whether cutting it again would find the same.
    """

    def __init__(self, mesh: Piece, until_s: float, *, is_first: bool) -> None:
        self.parts: list[Piece] = []
        self.coarse, self.is_final = "", True
        self._limit_m, self._until_s, self._is_first = tolerance_m(mesh), until_s, is_first
        for piece in pieces(mesh, most=MOST_PIECES):
            if is_flat(piece):
                self.parts.append(thickened(piece))
            elif not is_hollow(piece, deeper_than_m=self._limit_m):
                self.parts.append(piece)
            else:
                self.parts += self._hollow(piece)

    def _hollow(self, piece: Piece) -> list[Piece]:
        if is_sheet(piece) and len(piece.faces) <= SHEET_FACES:
            return _prisms(piece)
        if not _is_searched(piece):
            return self._hull_of(piece, NO_TIME, is_final=False) if self._is_late() else self._in_cells(piece)
        if not coacd_process.is_there():
            return self._hull_of(piece, NO_COACD, is_final=False)
        left_s = self._until_s - time.monotonic()
        found = coacd_process.searched(piece.vertices, piece.faces, self._limit_m, clock_s=left_s)
        if found is not None:
            return [Piece(vertices, faces) for vertices, faces in found]
        if self._is_late():
            return self._hull_of(piece, NO_TIME, is_final=False)
        self.coarse = self.coarse or NO_END
        return self._in_cells(piece)

    def _is_late(self) -> bool:
        return not self._is_first and time.monotonic() >= self._until_s

    def _in_cells(self, piece: Piece) -> list[Piece]:
        found = _by_cells(piece)
        return self._hull_of(piece, TOO_LARGE, is_final=True) if found is None else found

    def _hull_of(self, piece: Piece, reason: str, *, is_final: bool) -> list[Piece]:
        self.coarse, self.is_final = reason, self.is_final and is_final
        return [piece]  # which MuJoCo takes for its hull


def _prisms(sheet: Piece) -> list[Piece]:
    """A sheet as what lies behind each triangle of its front."""
    corners = sheet.corners
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across = normals[np.linalg.norm(normals, axis=1).argmax()]
    across = across / np.linalg.norm(across)
    fronts = corners[normals @ across > 0.5 * np.linalg.norm(normals, axis=1)]
    return [thickened(Piece(each, np.array([(0, 1, 2)])), front_m=0.0) for each in fronts]


def _is_searched(piece: Piece) -> bool:
    """Whether CoACD is asked for what has hollows."""
    return piece.is_closed and len(piece.faces) <= SEARCHED_FACES


def _by_cells(piece: Piece) -> list[Piece] | None:
    """A surface by the cells of a grid, each with the hull of what lies in it; None if it has too many large triangles.

    What is flat becomes a sheet.
    """
    side_m = float(np.ptp(piece.vertices, axis=0).max()) / CELLS
    corners = _divided(piece.corners, side_m / 2)
    if corners is None:
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
    model, turn = compiled_hull(points)
    corners = hull_triangles(model, 0) @ turn.T + model.mesh_pos[0]
    vertices, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return Piece(vertices, faces.reshape(-1, 3))


def _as_obj(parts: Sequence[Piece], coarse: str) -> bytes:
    """Rounded to micrometres; any program that opens OBJ shows them."""
    lines, start = [HEAD + (f"{COARSE}{coarse}" if coarse else "")], 1
    for number, part in enumerate(parts):
        lines.append(f"o part{number}")
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in part.vertices]
        lines += [f"f {a + start} {b + start} {c + start}" for a, b, c in part.faces]
        start += len(part.vertices)
    return ("\n".join(lines) + "\n").encode()


def coarse_in(text: bytes) -> str:
    """What a document of parts says that is coarse in it; empty if nothing is."""
    return text.partition(b"\n")[0].decode("utf-8", "replace").partition(COARSE)[2][:LONGEST_REASON]


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
    spec: mujoco.MjSpec,
    compiled: Callable[[mujoco.MjSpec], mujoco.MjModel],
    files: dict[str, bytes],
    where: str,
    limits: Limits = DEFAULT.limits,
) -> None:
    """Let convex parts collide in the place of a model's concave meshes.

    Args:
        spec: The model of room and objects; changed.
        compiled: Compiles it; only asked if there is a mesh that collides.
        files: The bundle of the scene; files with the parts are added where they are missing.
        where: File name for error messages.
        limits: How long meshes are cut, and into how many parts each.

    Raises:
        SceneError: A file with parts is damaged.
    """
    solid = [geom for geom in spec.geoms if _collides(geom)]
    if not solid:
        return
    model = compiled(spec)
    meshes = {name: joined(mesh_of(model, name)) for name in dict.fromkeys(geom.meshname for geom in solid)}
    hollow = {name: mesh for name, mesh in meshes.items() if is_hollow(mesh, deeper_than_m=tolerance_m(mesh))}
    keys = {name: parts_name(mesh) for name, mesh in hollow.items()}
    _find_parts(hollow, keys, files, limits)
    added: dict[str, tuple[str, ...]] = {}
    coarse: dict[str, list[str]] = {}
    for name, key in keys.items():
        parts, reason = _read_whole(files[key], name, f"{where}: {key}", limits)
        added[name] = _add_parts(spec, name, parts)
        coarse.setdefault(reason, []).append(name)
    _warn_of_coarse(coarse)
    for geom in solid:
        if geom.meshname in added:
            _replace(geom, added[geom.meshname])


def whole(name: str) -> str:
    """Name of the shape that a part belongs to; other names stay as they are."""
    return name.partition(PART)[0]


def _collides(geom: mujoco.MjsGeom) -> bool:
    return geom.type == mujoco.mjtGeom.mjGEOM_MESH and bool(geom.contype or geom.conaffinity)


def _find_parts(hollow: Mapping[str, Piece], keys: Mapping[str, str], files: dict[str, bytes], limits: Limits) -> None:
    """Put the parts of concave meshes into a bundle: those that it lacks are looked for in the cache, then cut.

    Args:
        hollow: The meshes by name.
        keys: Names of the documents with their parts, by theirs.
        files: The bundle.
        limits: How long they are cut.
    """
    missing: dict[str, str] = {}
    for name, key in keys.items():
        kept = files[key] if key in files else _kept(key)
        if kept is not None:
            files[key] = kept
        elif key not in missing.values():  # the same mesh under another name
            missing[name] = key
    until_s = time.monotonic() + limits.cutting_s
    for number, (name, key) in enumerate(missing.items(), 1):
        log.info("cutting concave meshes, once: %r, %d of %d", name, number, len(missing))
        files[key] = _parts_text(hollow[name], key, until_s, is_first=number == 1)


def _read_whole(text: bytes, name: str, where: str, limits: Limits) -> tuple[list[Array], str]:
    """The parts of a mesh, or its hull where they are too many; and what is coarse in that."""
    try:
        found = read_parts(text)
    except (ValueError, IndexError) as error:
        hint = "delete it, and it is made anew"
        raise SceneError(f"damaged convex parts of mesh {name!r}: {error}", where=where, hint=hint) from error
    if len(found) > limits.mesh_parts:
        return [np.concatenate(found)], TOO_MANY.format(limits.mesh_parts)
    return found, coarse_in(text)


def _add_parts(spec: mujoco.MjSpec, name: str, parts: Sequence[Array]) -> tuple[str, ...]:
    """Add the parts of a mesh to a model; their names."""
    names = tuple(f"{name}{PART}{number}" for number in range(len(parts)))
    for part, vertices in zip(names, parts, strict=True):
        spec.add_mesh(name=part, uservert=vertices.ravel())
    return names


def _warn_of_coarse(coarse: Mapping[str, Sequence[str]]) -> None:
    """Warn of meshes whose parts are coarser than asked for, once for each reason; nothing if that is empty."""
    for reason, names in coarse.items():
        if reason:
            few = ", ".join(map(repr, names[:NAMED])) + (f" and {len(names) - NAMED} more" if names[NAMED:] else "")
            whose = f"mesh {few} is" if len(names) == 1 else f"meshes {few} are"
            log.warning("%s concave, %s", whose, reason)


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
