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

from collections.abc import Callable, Collection
from pathlib import Path
from typing import Literal, get_args
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.markup import TEXTS_IN_URDF, Marked, asking_mujoco, check_values, parse_markup, written
from taskgist.world.bodies.meshes import check_mesh, flat_name, keep_file, stl_from_dae
from taskgist.world.bodies.mjcf import check_bodies

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
    if shapes == "collision":
        _drop_visuals(robot)
    _drop_textures(robot)
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
            if uri.lower().endswith(".dae"):
                data, name = stl_from_dae(data, uri, limits=limits), f"{name}.stl"
            check_mesh(data, name, where=where, limits=limits)
            names[uri] = keep_file(files, name, data)
        mesh.set("filename", names[uri])
    return names.values()


def _group(spec: mujoco.MjSpec) -> None:
    for body in spec.bodies:
        shown = [geom for geom in body.geoms if not geom.contype and not geom.conaffinity]
        for geom in body.geoms:
            blocks = bool(geom.contype or geom.conaffinity)
            geom.group = COLLISION_GROUP if blocks and shown else VISUAL_GROUP
