"""PLY meshes, text and binary, as triangles: vertices and faces are taken, colours and all else are skipped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError, most_read
from taskgist.settings import DEFAULT, Limits

TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
LONGEST_HEAD = 16_384
MOST_CORNERS = 255
WAY_OUT = "save it as STL or OBJ and name that file instead"


class _Property(NamedTuple):
    """A property of an element; of a list, the type of its length, too."""

    name: str
    kind: str
    length: str


class _Element(NamedTuple):
    name: str
    size: int
    properties: list[_Property]


def triangles_from_ply(data: bytes, where: str, *, limits: Limits = DEFAULT.limits) -> Array:
    """Triangles of a PLY document, (n, 3, 3), as it has them; polygons are cut into fans.

    Args:
        data: The document.
        where: File for error messages.
        limits: The largest mesh.

    Raises:
        SceneError: It is no PLY, or too large.
    """
    try:
        order, elements, rest = _head(data)
        if max(element.size for element in elements) > 3 * limits.mesh_faces:
            hint = f"simplify it: {most_read(limits.mesh_faces, 'mesh_faces')}"
            raise SceneError("too many triangles", where=where, hint=hint)
        points, faces = _read(_Text(rest) if not order else _Binary(rest, order), elements)
        triangles = points[faces]
    except (ValueError, LookupError, TypeError) as error:
        raise SceneError(f"not a PLY mesh that can be read: {error}", where=where, hint=WAY_OUT) from error
    return np.asarray(triangles)


def _head(data: bytes) -> tuple[str, list[_Element], bytes]:
    """How numbers are written, the elements that follow, and what follows the head."""
    head, end, _ = data[:LONGEST_HEAD].partition(b"end_header")
    if not end:
        raise ValueError("its head has no end")
    after = data[len(head) + len(end) :]
    order, elements = "", list[_Element]()
    for line in head.decode("ascii", "replace").splitlines()[1:]:
        word, *words = line.split() or [""]
        if word == "format":
            order = ORDERS[words[0]]
        elif word == "element":
            elements.append(_Element(words[0], int(words[1]), []))
        elif word == "property":
            length = TYPES[words[1]] if words[0] == "list" else ""
            elements[-1].properties.append(_Property(words[-1], TYPES[words[-2]], length))
    if any(element.size < 0 for element in elements) or not elements:
        raise ValueError("its head tells of no elements")
    return order, elements, after[2:] if after.startswith(b"\r\n") else after[1:]


class _Text:
    """Numbers of a PLY that is text."""

    def __init__(self, data: bytes) -> None:
        self._words, self._at = data.split(), 0

    def table(self, count: int, properties: list[_Property]) -> dict[str, Array]:
        """Columns of an element without lists."""
        width = len(properties)
        words = self._words[self._at : self._at + count * width]
        self._at += count * width
        rows = np.array(words, dtype=float).reshape(count, width)
        return {each.name: rows[:, column] for column, each in enumerate(properties)}

    def number(self, _kind: str) -> float:
        """The next number."""
        self._at += 1
        return float(self._words[self._at - 1])

    def numbers(self, count: int, _kind: str) -> Array:
        """The next numbers."""
        self._at += count
        return np.array(self._words[self._at - count : self._at], dtype=float)


class _Binary:
    """Numbers of a binary PLY."""

    def __init__(self, data: bytes, order: str) -> None:
        self._data, self._order, self._at = data, order, 0

    def table(self, count: int, properties: list[_Property]) -> dict[str, Array]:
        """Columns of an element without lists."""
        row = np.dtype([(f"{i}", self._order + each.kind) for i, each in enumerate(properties)])
        rows = np.frombuffer(self._data, row, count, self._at)
        self._at += count * row.itemsize
        return {each.name: rows[f"{i}"].astype(float) for i, each in enumerate(properties)}

    def number(self, kind: str) -> float:
        """The next number."""
        return float(self.numbers(1, kind)[0])

    def numbers(self, count: int, kind: str) -> Array:
        """The next numbers."""
        found = np.frombuffer(self._data, self._order + kind, count, self._at)
        self._at += found.nbytes
        return found


def _read(source: _Text | _Binary, elements: list[_Element]) -> tuple[Array, Indices]:
    """Points (n, 3) and triangles (m, 3)."""
    points, faces = np.empty((0, 3)), list[Indices]()
    for name, count, properties in elements:
        if not any(each.length for each in properties):
            table = source.table(count, properties)
            if name == "vertex":
                points = np.stack([table[axis] for axis in "xyz"], axis=1)
            continue
        for _ in range(count):
            for each in properties:
                corners = _listed(source, each)
                if name == "face" and each.name in ("vertex_indices", "vertex_index"):
                    faces.append(np.stack((np.full(len(corners) - 2, corners[0]), corners[1:-1], corners[2:]), axis=1))
    together = np.concatenate(faces) if faces else np.empty((0, 3), dtype=np.intp)
    if len(together) and together.min() < 0:
        raise ValueError("it names a corner before the first")
    return points, together


def _listed(source: _Text | _Binary, each: _Property) -> Indices:
    """The numbers of one property of one element; fewer than three corners make no face."""
    if not each.length:
        source.number(each.kind)
        return np.zeros(2, dtype=np.intp)
    count = int(source.number(each.length))
    if not 0 <= count <= MOST_CORNERS:
        raise ValueError(f"a list of {count} numbers")
    found = source.numbers(count, each.kind).astype(np.intp)
    if len(found) != count:
        raise ValueError("it ends too soon")
    return found if count >= 2 else np.zeros(2, dtype=np.intp)
