"""COLLADA meshes (``.dae``), which robot descriptions use and MuJoCo does not read, as binary STL.

Only the shape is taken: triangles and polygons of every geometry that the scene instances, with the transforms of its
nodes and the unit of length. Like ROS's viewers, the declared up axis is left alone: descriptions are written for it.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import SceneError

Array = NDArray[np.float64]
STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("unused", "<u2")])
POLYGONS = ("triangles", "polylist", "polygons")


def stl_from_dae(data: bytes, where: str | Path) -> bytes:
    """Binary STL of a COLLADA document.

    Args:
        data: The document.
        where: File for error messages.

    Raises:
        SceneError: It is not COLLADA, or holds no triangles.
    """
    try:
        root = _without_namespace(ET.fromstring(data))
        unit = root.find("asset/unit")
        scale = float(unit.get("meter", "1")) if unit is not None else 1.0
        geometries = {f"#{each.get('id')}": _triangles(each) for each in root.iter("geometry")}
        parts = [part for scene in root.iter("visual_scene") for part in _placed(scene, np.eye(4), geometries)]
    except (ET.ParseError, ValueError, IndexError, KeyError, AttributeError) as error:
        raise SceneError(f"not a COLLADA mesh that can be read: {error}", where=where, hint=WAY_OUT) from error
    triangles = scale * np.concatenate(parts or [np.empty((0, 3, 3))])
    if not len(triangles):
        raise SceneError("no triangles in this COLLADA mesh", where=where, hint=WAY_OUT)
    return _stl(triangles)


WAY_OUT = "save it as STL or OBJ and name that file instead"


def _without_namespace(root: ET.Element) -> ET.Element:
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    return root


def _placed(node: ET.Element, matrix: Array, geometries: dict[str, Array]) -> Iterator[Array]:
    """Triangles (n, 3, 3) of a node and all below it, in the scene's frame."""
    matrix = matrix @ _transform(node)
    for instance in node.findall("instance_geometry"):
        corners = geometries[instance.get("url", "")]
        yield corners @ matrix[:3, :3].T + matrix[:3, 3]
    for child in node.findall("node"):
        yield from _placed(child, matrix, geometries)


def _transform(node: ET.Element) -> Array:
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
            step[:3, :3] = _rotation(*_floats(part))
        result = result @ step
    return result


def _rotation(x: float, y: float, z: float, degrees: float) -> Array:
    """Rodrigues' formula, (3, 3)."""
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) / np.linalg.norm((x, y, z))
    angle = np.radians(degrees)
    return np.asarray(np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k)


def _triangles(geometry: ET.Element) -> Array:
    """Triangles (n, 3, 3) of a geometry; polygons are cut into fans."""
    sources = {f"#{each.get('id')}": each for each in geometry.iter("source")}
    positions = {
        f"#{each.get('id')}": sources[each.find("input[@semantic='POSITION']").get("source")]  # type: ignore[union-attr,index]
        for each in geometry.iter("vertices")
    }
    corners = [
        _corners(primitive, positions) for kind in POLYGONS for primitive in geometry.iter(kind) if _count(primitive)
    ]
    return np.concatenate(corners or [np.empty((0, 3, 3))])


def _count(primitive: ET.Element) -> int:
    return int(primitive.get("count", "0"))


def _corners(primitive: ET.Element, positions: dict[str, ET.Element]) -> Array:
    inputs = primitive.findall("input")
    vertex = next(each for each in inputs if each.get("semantic") == "VERTEX")
    points = _floats(positions[vertex.get("source", "")].find("float_array")).reshape(-1, 3)
    width = 1 + max(int(each.get("offset", "0")) for each in inputs)
    loops = _loops(primitive, width, int(vertex.get("offset", "0")))
    fans = [(loop[0], loop[k], loop[k + 1]) for loop in loops for k in range(1, len(loop) - 1)]
    return np.asarray(points[np.array(fans, dtype=int).reshape(-1, 3)])


def _loops(primitive: ET.Element, width: int, offset: int) -> list[list[int]]:
    """Indices of the points around each polygon."""
    runs = [np.array((p.text or "").split(), dtype=int)[offset::width] for p in primitive.findall("p")]
    if primitive.tag == "polygons":
        return [list(run) for run in runs]
    indices = np.concatenate(runs or [np.empty(0, dtype=int)])
    counts = primitive.find("vcount")
    if primitive.tag == "triangles" or counts is None:
        return [list(each) for each in indices.reshape(-1, 3)]
    ends = np.cumsum(np.array((counts.text or "").split(), dtype=int))
    return [list(each) for each in np.split(indices, ends[:-1])]


def _floats(element: ET.Element | None) -> Array:
    assert element is not None
    return np.array((element.text or "").split(), dtype=float)


def _stl(triangles: Array) -> bytes:
    records = np.zeros(len(triangles), dtype=STL_TRIANGLE)
    records["corners"] = triangles
    return bytes(80) + len(triangles).to_bytes(4, "little") + records.tobytes()
