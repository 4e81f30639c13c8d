"""COLLADA meshes (``.dae``), which robot descriptions use and MuJoCo does not read, as triangles.

Only the shape is taken: triangles and polygons of every geometry that the scene instances, with the transforms of
its nodes and the unit of length. Like ROS's viewers, the declared up axis is left alone: descriptions are written
for it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree.ElementTree import Element

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.markup import parse_markup
from taskgist.world.geometry.transforms import matrix_from_wxyz, normalized, wxyz_from_rotation_vector

POLYGONS = ("triangles", "polylist", "polygons")


def triangles_from_dae(data: bytes, where: str | Path, *, limits: Limits = DEFAULT.limits) -> Array:
    """Triangles of a COLLADA document, metres, float32 (n, 3, 3).

    Args:
        data: The document.
        where: File for error messages.
        limits: The largest mesh.

    Raises:
        SceneError: It is not COLLADA, holds no triangles, or too many of them.
    """
    try:
        triangles = _scaled(data, where, limits)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise SceneError(f"not a COLLADA mesh that can be read: {error}", where=where, hint=WAY_OUT) from error
    except SceneError as error:
        error.hint = WAY_OUT
        raise
    if not len(triangles):
        raise SceneError("no triangles in this COLLADA mesh", where=where, hint=WAY_OUT)
    return triangles


WAY_OUT = "save it as STL or OBJ and name that file instead"


def _scaled(data: bytes, where: str | Path, limits: Limits) -> Array:
    """All triangles of a document, metres, (n, 3, 3)."""
    most = limits.mesh_faces
    root = _without_namespace(parse_markup(data, where=where, limits=limits, most_elements=most))
    unit = root.find("asset/unit")
    scale = float(unit.get("meter", "1")) if unit is not None else 1.0
    if not 0 < scale < math.inf:
        raise ValueError(f"its unit is {scale:g} metres")
    geometries = {f"#{each.get('id')}": _triangles(each, most) for each in root.iter("geometry")}
    parts: list[Array] = [np.empty((0, 3, 3))]
    for scene in root.iter("visual_scene"):
        for part in _placed(scene, np.eye(4), geometries):
            parts.append(part)
            if sum(map(len, parts)) > most:
                raise ValueError(f"it has more than {most:,} triangles (setting limits.mesh_faces)")
    with np.errstate(all="ignore"):  # what overflows is told of
        triangles = (scale * np.concatenate(parts)).astype(np.float32)
    if not np.isfinite(triangles).all():
        raise ValueError("its corners are not finite numbers")
    return np.asarray(triangles)


def _without_namespace(root: Element) -> Element:
    for element in root.iter():
        element.tag = element.tag.rpartition(":")[2]
    return root


def _placed(node: Element, matrix: Array, geometries: dict[str, Array]) -> Iterator[Array]:
    """Triangles (n, 3, 3) of a node and all below it, in the scene's frame."""
    matrix = matrix @ _transform(node)
    for instance in node.findall("instance_geometry"):
        corners = geometries[instance.get("url", "")]
        yield corners @ matrix[:3, :3].T + matrix[:3, 3]
    for child in node.findall("node"):
        yield from _placed(child, matrix, geometries)


def _transform(node: Element) -> Array:
    """A node's own transform, (4, 4): the product of its parts in their order."""
    result = np.eye(4)
    for part in node:
        step = np.eye(4)
        if part.tag == "matrix":
            step = _floats(part).reshape(4, 4)
        elif part.tag == "translate":
            step[:3, 3] = _floats(part)
        elif part.tag == "scale":
            step[:3, :3] = np.diag(_floats(part))
        elif part.tag == "rotate":
            *axis, angle_deg = _floats(part)
            turn = wxyz_from_rotation_vector(np.radians(angle_deg) * normalized(axis))
            step[:3, :3] = matrix_from_wxyz(turn)
        result = result @ step
    return result


def _triangles(geometry: Element, most: int) -> Array:
    """Triangles (n, 3, 3) of a geometry; polygons are cut into fans."""
    sources = {f"#{each.get('id')}": each for each in geometry.iter("source")}
    positions = {
        f"#{each.get('id')}": _floats(sources[_input(each, "POSITION").get("source", "")].find("float_array"), most)
        for each in geometry.iter("vertices")
    }
    points = {key: array.reshape(-1, 3) for key, array in positions.items()}
    corners = [
        _corners(primitive, points, most)
        for kind in POLYGONS
        for primitive in geometry.iter(kind)
        if int(primitive.get("count", "0"))
    ]
    return np.concatenate(corners or [np.empty((0, 3, 3))])


def _input(element: Element, semantic: str) -> Element:
    for each in element.findall("input"):
        if each.get("semantic") == semantic:
            return each
    raise ValueError(f"<{element.tag}> has no input {semantic}")


def _corners(primitive: Element, points: dict[str, Array], most: int) -> Array:
    vertex = _input(primitive, "VERTEX")
    offsets = [_natural(each.get("offset", "0")) for each in primitive.findall("input")]
    indices = _fans(primitive, 1 + max(offsets), _natural(vertex.get("offset", "0")), most)
    if indices.size and indices.min() < 0:
        raise ValueError("it names a corner before the first")
    return np.asarray(points[vertex.get("source", "")][indices])


def _natural(text: str) -> int:
    number = int(text)
    if not 0 <= number < MOST_INPUTS:
        raise ValueError(f"an offset of {number}")
    return number


MOST_INPUTS = 64
"""Numbers for each corner of a polygon: position, normal, texture and so on."""


def _fans(primitive: Element, width: int, offset: int, most: int) -> Indices:
    """Indices of the points of each triangle, (n, 3); polygons are cut into fans."""
    runs = [_numbers(p, int, most)[offset::width] for p in primitive.findall("p")]
    indices = np.concatenate(runs or [np.empty(0, dtype=int)])
    listed = primitive.find("vcount")
    if primitive.tag == "polygons":
        counts = np.array([len(run) for run in runs], dtype=int)
    elif primitive.tag == "triangles" or listed is None:
        return indices.reshape(-1, 3)
    else:
        counts = _numbers(listed, int, most)
    if (counts == 3).all():
        return indices.reshape(-1, 3)
    loops = np.split(indices, np.cumsum(counts)[:-1])
    fans = [(loop[0], loop[k], loop[k + 1]) for loop in loops for k in range(1, len(loop) - 1)]
    return np.array(fans, dtype=int).reshape(-1, 3)


def _floats(element: Element | None, most: int = 16) -> Array:
    if element is None:
        raise ValueError("a source without a <float_array>")
    return _numbers(element, float, most)


NUMBERS_PER_FACE = 12
"""Numbers of a mesh for each triangle: the indices of three corners, with their normals and texture, and some more."""
NOT_IN_NUMBERS = re.compile(r"[^0-9eE+.\-\s]", re.ASCII)


def _numbers(element: Element, kind: type, most: int) -> Array:
    """The numbers that an element holds, plain and finite."""
    text = element.text or ""
    if NOT_IN_NUMBERS.search(text):
        raise ValueError(f"<{element.tag}> holds what is no plain number")
    bytes_ = np.frombuffer(text.encode("ascii"), np.uint8)
    if np.count_nonzero(np.diff((bytes_ > ord(" ")).astype(np.int8)) > 0) > NUMBERS_PER_FACE * most:
        raise ValueError(f"<{element.tag}> holds too many numbers for {most:,} triangles (setting limits.mesh_faces)")
    return np.array(text.split(), dtype=kind)
