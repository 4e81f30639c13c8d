"""URDF, the robot descriptions of ROS, as MuJoCo reads it.

Three things are done before MuJoCo reads a description, and one after:

- meshes are looked up (``package://``) and gathered; COLLADA becomes STL;
- masses that no body can have are left out, for published descriptions hold some, and geometry does not need them;
- every link stays a body of its own, for profiles name camera and tool frames, which have no shape;
- what a link shows is seen (geom group 1) and what it collides with blocks (group 3, unseen). A link that only
  collides is seen by that.

In a room, the description's root link is the world, so that links below it stand for themselves; those on a
``floating`` joint are objects.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal, get_args

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.world.geometry.transforms import matrix_from_wxyz, normalized, wxyz_from_rotation_vector

# --- COLLADA meshes (``.dae``), which robot descriptions use and MuJoCo does not read, as binary STL.
#
# Only the shape is taken: triangles and polygons of every geometry that the scene instances, with the transforms of
# its nodes and the unit of length. Like ROS's viewers, the declared up axis is left alone: descriptions are written
# for it.

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
            *axis, angle_deg = _floats(part)
            turn = wxyz_from_rotation_vector(np.radians(angle_deg) * normalized(axis))
            step[:3, :3] = matrix_from_wxyz(turn)
        result = result @ step
    return result


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


Shapes = Literal["visual", "collision"]
SHAPES: tuple[Shapes, ...] = get_args(Shapes)
VISUAL_GROUP, COLLISION_GROUP = 1, 3
COMPILER = {
    "discardvisual": "false",
    "fusestatic": "false",
    "strippath": "false",
    "balanceinertia": "true",
    "boundmass": "1e-6",
    "boundinertia": "1e-9",
}
"""Links without mass, such as camera frames on a moving head, get the least that MuJoCo takes."""
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


def read_urdf(
    text: bytes,
    read: Callable[[str], bytes],
    *,
    where: str | Path,
    prefix: str = "",
    shapes: Shapes = "visual",
    room: bool = False,
) -> tuple[mujoco.MjSpec, dict[str, bytes]]:
    """A description as a MuJoCo specification.

    Args:
        text: The URDF document.
        read: Gives the content of a mesh by the name under which the document knows it.
        where: File for error messages.
        prefix: Put before the names of mesh files.
        shapes: ``collision`` leaves out what is only shown: less to carry, and to see through.
        room: Whether the root link is the world.

    Returns:
        The specification, and the meshes that it needs by file name.

    Raises:
        SceneError: It is no URDF, or names a mesh that cannot be read.
    """
    robot = _parsed(text, where)
    if shapes == "collision":
        _drop_visuals(robot)
    _drop_textures(robot)
    _drop_impossible_masses(robot)
    if room:
        _call_root_world(robot, where)
    files = _gather_meshes(robot, read, where, prefix)
    robot.insert(0, ET.Element("mujoco"))
    ET.SubElement(robot[0], "compiler", COMPILER)
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(robot, encoding="unicode"), assets=files)
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot read this URDF: {error}", where=where) from error
    _group(spec)
    return spec, files


def _parsed(text: bytes, where: str | Path) -> ET.Element:
    try:
        robot = ET.fromstring(text)
    except ET.ParseError as error:
        raise SceneError(f"not valid XML: {error}", where=where) from error
    if robot.tag != "robot":
        raise SceneError("not a URDF document", where=where, field=robot.tag, hint="its root element is <robot>")
    return robot


def _drop_visuals(robot: ET.Element) -> None:
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)


def _drop_textures(robot: ET.Element) -> None:
    for material in robot.iter("material"):
        for texture in material.findall("texture"):
            material.remove(texture)


def _drop_impossible_masses(robot: ET.Element) -> None:
    for link in robot.iter("link"):
        for inertial in link.findall("inertial"):
            if not _possible(inertial):
                link.remove(inertial)


def _possible(inertial: ET.Element) -> bool:
    """Whether some body has that mass and inertia."""
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is None or inertia is None:
        return False
    try:
        xx, xy, xz, yy, yz, zz = (float(inertia.get(key, "0")) for key in INERTIA)
        heavy = float(mass.get("value", "0")) > 0
    except ValueError:
        return False
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not heavy or not np.isfinite(tensor).all():
        return False
    least, middle, most = np.linalg.eigvalsh(tensor)
    return bool(least > 0 and least + middle >= most)


def _call_root_world(robot: ET.Element, where: str | Path) -> None:
    """Give the root link the name by which MuJoCo makes it the world itself."""
    children = {child.get("link") for child in robot.findall("joint/child")}
    roots = [link for link in robot.findall("link") if link.get("name") not in children]
    if len(roots) != 1:
        names = ", ".join(str(link.get("name")) for link in roots) or "none"
        raise SceneError("a URDF has one root link", where=where, field="link", value=names)
    for parent in robot.findall("joint/parent"):
        if parent.get("link") == roots[0].get("name"):
            parent.set("link", "world")
    roots[0].set("name", "world")


def _gather_meshes(robot: ET.Element, read: Callable[[str], bytes], where: str | Path, prefix: str) -> dict[str, bytes]:
    """Every mesh under a name without folders, to which the document is changed."""
    files: dict[str, bytes] = {}
    for mesh in robot.iter("mesh"):
        uri = mesh.get("filename")
        if not uri:
            raise SceneError("a mesh without a file", where=where, field="mesh", hint='write filename="..."')
        name = prefix + flat_name(uri)
        if name.lower().endswith(".dae"):
            name = f"{name}.stl"
        if name not in files:
            data = read(uri)
            files[name] = stl_from_dae(data, uri) if uri.lower().endswith(".dae") else data
        mesh.set("filename", name)
    return files


def flat_name(uri: str) -> str:
    """A file name, without folders, for what a document names by URI or path; two of them never get the same."""
    return uri.partition("://")[2].strip("/").replace("/", "_") if "://" in uri else uri.replace("/", "_")


def _group(spec: mujoco.MjSpec) -> None:
    for body in spec.bodies:
        shown = [geom for geom in body.geoms if not geom.contype and not geom.conaffinity]
        for geom in body.geoms:
            blocks = bool(geom.contype or geom.conaffinity)
            geom.group = COLLISION_GROUP if blocks and shown else VISUAL_GROUP
