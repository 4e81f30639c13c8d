"""Meshes in files: named in a bundle, turned into what MuJoCo reads, and refused unread if too large or nowhere.

Read are OBJ, STL (binary and text), COLLADA, PLY and MuJoCo's own MSH. A bundle holds OBJ, binary STL and MSH: of
triangles and nothing else, for nothing here has a texture or shades a surface.
"""

from __future__ import annotations

import itertools
import re
import struct
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError, most_read
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.collada import triangles_from_dae
from taskgist.world.bodies.foreign import MESHES, foreign_in
from taskgist.world.bodies.ply import triangles_from_ply

# --- Files of a bundle lie side by side, wherever they come from.


def flat_name(uri: str) -> str:
    """A file name, without folders, for what a document names by URI or path."""
    return uri.partition("://")[2].strip("/").replace("/", "_") if "://" in uri else uri.replace("/", "_")


def keep_file(files: dict[str, bytes], name: str, content: bytes) -> str:
    """Add a file to a bundle under a name that no other content has.

    Args:
        files: The bundle, which is added to.
        name: The name that it gets unless another file has it.
        content: What it holds.

    Returns:
        Its name in the bundle.
    """
    names = itertools.chain([name], (f"{i}_{name}" for i in itertools.count(1)))
    return next(each for each in names if files.setdefault(each, content) == content)


# --- Meshes as MuJoCo reads them.

STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
STL_HEADER = 84
"""Bytes before the first triangle; the last four of them say how many there are."""
STL_FACES = 200_000
"""Triangles that MuJoCo reads from STL; of MSH it reads any number."""
MSH_HEADER = 16
OBJ_UNUSED = re.compile(rb"^[ \t]*(?:vt|vn|usemtl|mtllib)[ \t][^\n]*\n?", re.MULTILINE)
OBJ_CORNER = re.compile(rb"(?<=[0-9])/[0-9/\-]*")
"""What follows the vertex in a corner of a face: texture and normal."""
TEXT_CORNER = re.compile(rb"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)")
KINDS = ("obj", "stl", "dae", "ply", "msh")


def readable_mesh(
    data: bytes, name: str, *, where: str | Path, kind: str = "", limits: Limits = DEFAULT.limits
) -> tuple[bytes, str]:
    """A mesh as MuJoCo reads it, and what its name ends in, where that is new.

    Args:
        data: The file's content.
        name: Its name, whose ending tells the kind where the content does not.
        where: File that names it, for messages.
        kind: The kind, where it is said: ``model/stl``.
        limits: The largest mesh.

    Returns:
        OBJ, binary STL or MSH; and ``""``, ``".stl"`` or ``".msh"``.

    Raises:
        SceneError: It is of a kind that is not read, has too many triangles, or corners that are nowhere.
    """
    ending = _kind(data, (kind or name).lower().replace("/", ".").rpartition(".")[2])
    at = f"{where}: {name}"
    if ending not in KINDS:
        found = foreign_in(data, name)
        what, hint = (found.what, found.as_mesh) if found else ("no mesh that is read", MESHES)
        raise SceneError(f"is {what}", where=at, hint=hint)
    if ending == "dae":
        return _from_triangles(triangles_from_dae(data, name, limits=limits))
    if ending == "ply":
        triangles = triangles_from_ply(data, at, limits=limits)
        check_faces(len(triangles), at, limits)
        return _from_triangles(_checked(triangles, at))
    if ending == "stl" and _is_text(data):
        return _from_triangles(_checked(_from_text(data, at, limits), at))
    check_mesh(data, name, where=where, kind=ending, limits=limits)
    if ending == "obj":
        return OBJ_CORNER.sub(b"", OBJ_UNUSED.sub(b"", data)), ""
    if ending == "stl" and _claimed(data) > STL_FACES:
        there = min(_claimed(data), (len(data) - STL_HEADER) // STL_TRIANGLE.itemsize)
        return _from_triangles(np.frombuffer(data, STL_TRIANGLE, there, STL_HEADER)["corners"])
    return data, ""


def _kind(data: bytes, ending: str) -> str:
    """The kind of a mesh, by its content where that tells."""
    if data.startswith((b"ply\n", b"ply\r")):
        return "ply"
    if b"<COLLADA" in data[:4096]:
        return "dae"
    return ending


def _is_text(data: bytes) -> bool:
    """Whether an STL is text: binary ones may begin with its word, and have the length that they claim."""
    binary = len(data) == STL_HEADER + STL_TRIANGLE.itemsize * _claimed(data)
    return data.lstrip()[:5].lower() == b"solid" and not binary and b"facet" in data[:4096]


def _claimed(data: bytes) -> int:
    return int.from_bytes(data[STL_HEADER - 4 : STL_HEADER], "little")


def _from_text(data: bytes, where: str, limits: Limits) -> Array:
    """Triangles of an STL that is text, (n, 3, 3)."""
    check_faces(data.count(b"endfacet"), where, limits)
    corners = TEXT_CORNER.findall(data)
    try:
        return np.array(corners, dtype=float).reshape(-1, 3, 3)
    except ValueError as error:
        raise SceneError(f"not an STL that can be read: {error}", where=where, hint="export it anew") from error


def _checked(triangles: Array, where: str) -> Array:
    if not len(triangles):
        raise SceneError("no triangles in this mesh", where=where, hint="export it anew, with its faces")
    if not np.isfinite(triangles).all():
        raise SceneError("a mesh whose corners are not finite numbers", where=where, hint="export it anew")
    return triangles


def _from_triangles(triangles: Array) -> tuple[bytes, str]:
    if len(triangles) > STL_FACES:
        corners, faces = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
        return _msh(corners, faces.reshape(-1, 3)), ".msh"
    records = np.zeros(len(triangles), dtype=STL_TRIANGLE)
    records["corners"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + records.tobytes(), ".stl"


def _msh(vertices: Array, faces: Indices) -> bytes:
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    head = struct.pack("<4i", len(vertices), 0, 0, int(whole.sum()))
    return b"".join((head, vertices.astype("<f4").tobytes(), faces[whole].astype("<i4").tobytes()))


# --- What is known of a mesh or an image before it is unpacked.

PNG = b"\x89PNG\r\n\x1a\n"
OBJ_FACE = re.compile(rb"^[ \t]*f[ \t]", re.MULTILINE)
OBJ_NOWHERE = re.compile(rb"^[ \t]*v[ \t][^\n]*(?:nan|inf)", re.IGNORECASE | re.MULTILINE)


def check_mesh(data: bytes, name: str, *, where: str | Path, kind: str = "", limits: Limits = DEFAULT.limits) -> None:
    """Refuse a mesh of too many triangles, or with corners that are nowhere.

    Args:
        data: Binary STL, OBJ or MuJoCo's own format; what is something else is left to MuJoCo.
        name: Its name, which tells the kind by its ending.
        where: File that names it, for messages.
        kind: The kind, where it is said: ``model/stl``.
        limits: The largest mesh.

    Raises:
        SceneError: It is one.
    """
    faces, finite = _known(data, (kind or name).lower().replace("/", ".").rpartition(".")[2])
    check_faces(faces, f"{where}: {name}", limits)
    if not finite:
        raise SceneError("a mesh whose corners are not finite numbers", where=f"{where}: {name}", hint="export it anew")


def check_faces(count: int, where: str, limits: Limits) -> None:
    """Refuse a mesh of too many triangles.

    Raises:
        SceneError: It is one.
    """
    if count > limits.mesh_faces:
        hint = f"simplify it: {most_read(limits.mesh_faces, 'mesh_faces')}"
        raise SceneError("too many triangles", where=where, value=f"{count:,}", hint=hint)


def _known(data: bytes, kind: str) -> tuple[int, bool]:
    """How many triangles a mesh claims to have, and whether its corners are finite."""
    if kind == "stl" and len(data) >= STL_HEADER:
        faces = _claimed(data)
        there = min(faces, (len(data) - STL_HEADER) // STL_TRIANGLE.itemsize)
        corners = np.frombuffer(data, STL_TRIANGLE, there, STL_HEADER)["corners"]
        return faces, bool(np.isfinite(corners).all())
    if kind == "obj":
        return sum(1 for _ in OBJ_FACE.finditer(data)), OBJ_NOWHERE.search(data) is None
    if kind == "msh" and len(data) >= MSH_HEADER:
        vertices, _, _, faces = struct.unpack("<4i", data[:MSH_HEADER])
        there = min(max(0, 3 * vertices), (len(data) - MSH_HEADER) // 4)
        return faces, bool(np.isfinite(np.frombuffer(data, "<f4", there, MSH_HEADER)).all())
    return 0, True


def image_pixels(data: bytes) -> int:
    """Pixels that a PNG unpacks to; what is something else takes about as many bytes as its file has."""
    if not data.startswith(PNG) or len(data) < len(PNG) + 16:
        return 0
    width, height = struct.unpack(">2I", data[len(PNG) + 8 : len(PNG) + 16])
    return int(width * height)
