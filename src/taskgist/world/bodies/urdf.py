"""URDF, the robot descriptions of ROS, as MuJoCo reads it.

Three things are done before MuJoCo reads a description, and one after:

- meshes are looked up (``package://``) and gathered, as MuJoCo reads them;
- masses that no body can have are left out, for published descriptions hold some, and geometry does not need them;
- every link stays a body of its own, for profiles name camera and tool frames, which have no shape;
- what a link shows is seen (geom group 1) and what it collides with blocks (group 3, unseen). A link that only
  collides is seen by that.

In a room, the description's root link is the world, so that links below it stand for themselves; those on a
``floating`` joint are objects.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Literal, get_args
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.foreign import KNOWN, not_a_model
from taskgist.world.bodies.markup import TEXTS_IN_URDF, Marked, asking_mujoco, check_values, parse_markup, written
from taskgist.world.bodies.meshes import flat_name, keep_file, readable_mesh
from taskgist.world.bodies.mjcf import check_bodies
from taskgist.world.geometry.pieces import SHEET_M

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
    files: dict[str, bytes],
    *,
    where: str | Path,
    prefix: str = "",
    shapes: Shapes = "visual",
    room: bool = False,
    limits: Limits = DEFAULT.limits,
) -> mujoco.MjSpec:
    """A description as a MuJoCo specification.

    Args:
        text: The URDF document.
        read: Gives the content of a mesh by the name under which the document knows it.
        files: The bundle, to which the meshes are added.
        where: File for error messages.
        prefix: Put before the names of mesh files.
        shapes: ``collision`` leaves out what is only shown: less to carry, and to see through.
        room: Whether the root link is the world.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: It is no URDF, or names a mesh that cannot be read.
    """
    robot = parse_markup(text, where=where, limits=limits)
    if robot.tag != "robot":
        raise SceneError("not a URDF document", where=where, field=robot.tag, hint="its root element is <robot>")
    _check_complete(robot, where)
    if shapes == "collision":
        _drop_visuals(robot)
    _drop_textures(robot)
    _drop_repeated_names(robot)
    _mend_sizes(robot)
    _drop_impossible_masses(robot)
    check_values(robot, where=where, texts=TEXTS_IN_URDF)
    _check_depth(robot, where, limits)
    check_bodies(len(robot.findall("link")), where, limits)
    if room:
        _call_root_world(robot, where)
    else:
        _fix_to_root(robot)
    needed = _gather_meshes(robot, read, files, where, prefix, limits)
    _set_compiler(robot)
    with asking_mujoco("MuJoCo cannot read this URDF:", where):
        spec = mujoco.MjSpec.from_string(written(robot), assets={name: files[name] for name in needed})
    _group(spec)
    return spec


UNEXPANDED = ("${", "$(")
"""What begins an expression of xacro."""


def _check_complete(robot: Element, where: str | Path) -> None:
    """Refuse what is no description of a robot yet: xacro that is not expanded, SRDF, or a document without links."""
    name = str(where).rpartition(": ")[2]
    for element in robot.iter():
        expressions = [value for value in element.attrib.values() if any(mark in value for mark in UNEXPANDED)]
        if element.tag.startswith("xacro:") or expressions:
            what = f"{KNOWN['xacro'].what}: {expressions[0] if expressions else f'<{element.tag}>'}"
            raise not_a_model(KNOWN["xacro"]._replace(what=what), name, str(where))
    if robot.find("link") is None:
        if robot.find("group") is not None or robot.find("disable_collisions") is not None:
            raise not_a_model(KNOWN["srdf"], name, str(where))
        hint = "xacro leaves such a document of a file that defines a macro: expand the one that calls it"
        raise SceneError("a URDF without any link", where=where, field="link", hint=hint)


def _check_depth(robot: Element, where: str | Path, limits: Limits) -> None:
    """Refuse links that hang on each other without end, or too many of them one below the other."""
    parents: dict[str | None, str | None] = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link")] = parent.get("link")
    depths: dict[str | None, int] = {}
    for link in parents:
        chain: list[str | None] = []
        name: str | None = link
        while name in parents and name not in depths and len(chain) <= limits.model_depth:
            chain.append(name)
            name = parents[name]
        depth = depths.get(name, 0) + len(chain)
        if depth > limits.model_depth:
            hint = f"at most {limits.model_depth} are read (setting limits.model_depth), and none is its own parent"
            raise SceneError("too many links one below the other", where=where, field="link", value=link, hint=hint)
        depths |= {each: depth - i for i, each in enumerate(chain)}


def _set_compiler(robot: Marked) -> None:
    """Say how MuJoCo is to read it; what the description itself says about that is for others."""
    for given in robot.findall("mujoco"):
        robot.remove(given)
    settings = Element("mujoco")
    SubElement(settings, "compiler", COMPILER)
    robot.insert(0, settings)


def _drop_visuals(robot: Element) -> None:
    for link in robot.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)


def _drop_textures(robot: Element) -> None:
    for material in robot.iter("material"):
        for texture in material.findall("texture"):
            material.remove(texture)


def _drop_repeated_names(robot: Element) -> None:
    """Let the first shape of a name have it: MuJoCo does so, too, and complains on the terminal."""
    seen: set[str] = set()
    for kind in ("visual", "collision"):
        for shape in robot.iter(kind):
            if shape.get("name") in seen:
                del shape.attrib["name"]
            seen.add(shape.get("name", ""))


def _mend_sizes(robot: Element) -> None:
    """Give a thickness to boards and discs that have none; leave out what has no size at all beside other shapes."""
    for link in robot.iter("link"):
        shapes = [*link.findall("visual"), *link.findall("collision")]
        for shape, solid in [(each, solid) for each in shapes for solid in each.findall("geometry/*")]:
            sizes = {key: solid.get(key, "").split() for key in ("size", "radius", "length") if key in solid.attrib}
            across = sizes.get("radius", sizes.get("size", []))
            if not all(map(_is_zero, across)):
                for key, numbers in sizes.items():
                    solid.set(key, " ".join(f"{SHEET_M:g}" if _is_zero(each) else each for each in numbers))
            elif across and len(shapes) > 1:
                link.remove(shape)


def _is_zero(text: str) -> bool:
    try:
        return float(text) == 0.0
    except ValueError:
        return False


def _drop_impossible_masses(robot: Element) -> None:
    for link in robot.iter("link"):
        for inertial in link.findall("inertial"):
            if not _possible(inertial):
                link.remove(inertial)


def _possible(inertial: Element) -> bool:
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


def _call_root_world(robot: Element, where: str | Path) -> None:
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


def _fix_to_root(robot: Element) -> None:
    """Make floating joints at the root fixed ones: what moves as a whole is the whole body, and not a part of it."""
    children = {child.get("link") for child in robot.findall("joint/child")}
    for joint in robot.findall("joint"):
        parent = joint.find("parent")
        if joint.get("type") == "floating" and parent is not None and parent.get("link") not in children:
            joint.set("type", "fixed")


def _gather_meshes(
    robot: Element,
    read: Callable[[str], bytes],
    files: dict[str, bytes],
    where: str | Path,
    prefix: str,
    limits: Limits,
) -> Collection[str]:
    """Put every mesh under a name without folders, to which the document is changed; these names."""
    names: dict[str, str] = {}
    for mesh in robot.iter("mesh"):
        uri = mesh.get("filename")
        if not uri:
            raise SceneError("a mesh without a file", where=where, field="mesh", hint='write filename="..."')
        if uri not in names:
            data, name = read(uri), prefix + flat_name(uri)
            data, ending = readable_mesh(data, name, where=where, limits=limits)
            names[uri] = keep_file(files, name + ending, data)
        mesh.set("filename", names[uri])
    return names.values()


def _group(spec: mujoco.MjSpec) -> None:
    for body in spec.bodies:
        shown = [geom for geom in body.geoms if not geom.contype and not geom.conaffinity]
        for geom in body.geoms:
            blocks = bool(geom.contype or geom.conaffinity)
            geom.group = COLLISION_GROUP if blocks and shown else VISUAL_GROUP
