"""Models as files of a bundle: one flat MJCF document, and its meshes beside it, wherever they come from.

MJCF is gathered as it is; URDF becomes MJCF here, so that a recording of a robot opens without ROS and without the
package that the robot came from.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Collection, Iterator
from importlib import resources
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.files import is_file, read_whole, reading, shown_path
from taskgist.common.toml import UNREADABLE
from taskgist.errors import InputError, SceneError, UnknownNameError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.bases import FREE, HINGE, SLIDE, stand_still
from taskgist.world.bodies.foreign import HEAD_BYTES, check_model
from taskgist.world.bodies.human import HumanSize, human_mjcf
from taskgist.world.bodies.markup import asking_mujoco, parse_markup
from taskgist.world.bodies.mending import made_of, solid_meshes, thicken_flat_meshes
from taskgist.world.bodies.meshes import flat_name, keep_file, readable_mesh
from taskgist.world.bodies.mjcf import from_files, from_folder, read_kept, read_mjcf
from taskgist.world.bodies.profile import AgentProfile, Arm
from taskgist.world.bodies.urdf import Shapes, read_urdf

# --- What a profile names, held against what its model has: every name that is missing, with the one that was meant.


def name_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    """Every name of the profile that its model does not have, and every one of the wrong kind.

    Args:
        spec: The model.
        profile: The profile.
        where: Profile's file for the messages.
    """
    yield from _root_problems(spec, profile, where)
    bodies = {str(body.name) for body in spec.bodies if body.name != "world"}
    for field, name in _bodies(profile):
        if name not in (*bodies, UNREADABLE):
            yield UnknownNameError("body", name, bodies, where=f"{where}: {field}")
    yield from _camera_problems(spec, profile.eye.camera, where)
    yield from _frame_problems(spec, profile, where, bodies)
    yield from _joint_problems(spec, profile, where)
    for arm in profile.arms:
        yield from _arm_problems(spec, arm, where)


def _root_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    roots = [str(body.name) or "(no name)" for body in spec.worldbody.bodies]
    if len(roots) != 1:
        names = ", ".join(roots) or "none"
        hint = "keep the robot, and leave floor and furniture to the scene"
        problem = f"a model of an agent has one top-level body, {profile.model!r} has {len(roots)}: {names}"
        yield SceneError(problem, where=where, field="model", hint=hint)
        return
    joints = spec.worldbody.first_body().joints
    if joints and [joint.type for joint in joints] != [FREE]:
        hint = "without any it is made free to stand anywhere, as are bases that slide along x and y and turn about z"
        problem = "the root body of an agent's model has a free joint, or none"
        yield SceneError(problem, where=where, field="model", value=str(joints[0].name), hint=hint)


def _camera_problems(spec: mujoco.MjSpec, camera: str | None, where: str) -> Iterator[InputError]:
    cameras = [str(each.name) for each in spec.cameras if each.name]
    if camera is None or camera in (*cameras, UNREADABLE):
        return
    if cameras:
        yield UnknownNameError("camera", camera, cameras, where=f"{where}: eye.camera")
    else:
        hint = 'name a link of the robot instead: frame = "...", with optical = true for a ROS optical frame'
        yield SceneError("the model has no cameras", where=where, field="eye.camera", value=camera, hint=hint)


def _bodies(profile: AgentProfile) -> Iterator[tuple[str, str]]:
    yield from (("eye.exclude", name) for name in (profile.eye.exclude, *profile.eye.housing))
    yield from ((f"posture.{key}", name) for key in ("thighs", "feet") for name in getattr(profile.legs, key))
    for arm in profile.arms:
        yield f"arms.{arm.side}.root", arm.root
        yield f"arms.{arm.side}.hand", arm.hand
        if arm.carrier:
            yield f"arms.{arm.side}.carrier", arm.carrier
    yield from ((f"parts.{part}", name) for part, names in profile.parts for name in names)


def _frame_problems(
    spec: mujoco.MjSpec, profile: AgentProfile, where: str, bodies: Collection[str]
) -> Iterator[InputError]:
    sites = {str(site.name) for site in spec.sites if site.name}
    for _, field, frame in (each for each in profile.frames if each[2].name != UNREADABLE):
        if frame.name not in sites and frame.name not in bodies:
            yield UnknownNameError("site or body", frame.name, {*sites, *bodies}, where=f"{where}: {field}")
        elif frame.name in sites and not frame.is_plain:
            hint = "move and turn the site in the model, or name the body that it sits in"
            yield SceneError("a site is taken as it stands", where=where, field=field, value=frame.name, hint=hint)


def _joint_problems(spec: mujoco.MjSpec, profile: AgentProfile, where: str) -> Iterator[InputError]:
    kinds = {str(joint.name): joint.type for joint in spec.joints if joint.type in (HINGE, SLIDE)}
    for joint in spec.joints:
        if joint.type in (HINGE, SLIDE) and not joint.name:
            hint = "name it in the model: recordings tell joints by their names"
            body = str(joint.parent.name)
            yield SceneError("a joint without a name", where=where, field="model", value=f"body {body}", hint=hint)
    for field, name in _joints(profile):
        if name not in (*kinds, UNREADABLE):
            yield UnknownNameError("joint", name, kinds, where=f"{where}: {field}")
        elif kinds.get(name, HINGE) != HINGE and field != "rest_m":
            hint = "give its rest under [rest_m]" if field == "rest_deg" else "name a joint that turns"
            yield SceneError("a joint that slides", where=where, field=field, value=name, hint=hint)


def _joints(profile: AgentProfile) -> Iterator[tuple[str, str]]:
    yield from ((field, axis.joint) for field, axis in profile.axes)
    for key in ("hips", "knees", "ankles"):
        yield from ((f"posture.{key}", name) for name in getattr(profile.legs, key))
    yield from (("rest_deg", name) for name, _ in profile.rest_rad)
    yield from (("rest_m", name) for name, _ in profile.rest_m)


def _arm_problems(spec: mujoco.MjSpec, arm: Arm, where: str) -> Iterator[InputError]:
    """A hand that its arm does not carry, or a palm: how far it reaches would be told of something else."""
    root = spec.body(arm.root) if arm.root else None
    site = spec.site(arm.palm.name) if arm.palm.name else None
    palm = str(site.parent.name) if site is not None else arm.palm.name
    for key, name in (("hand", arm.hand), ("palm", palm)):
        body = spec.body(name) if name else None
        if root is not None and body is not None and arm.root not in _carriers(body):
            hint = f"name what hangs on {arm.root!r}, or another root"
            problem = f"the {key} is no part of the arm, which begins with {arm.root!r}"
            yield SceneError(problem, where=where, field=f"arms.{arm.side}.{key}", value=name, hint=hint)


def _carriers(body: mujoco.MjsBody) -> set[str]:
    """Names of a body and all that carry it."""
    names: set[str] = set()
    while body is not None and body.name != "world":
        names.add(str(body.name))
        body = body.parent
    return names


# --- Finding files that robot descriptions name: ``package://`` as ROS means it, ``file://``, and relative paths.
#
# The first part of ``package://NAME/rest`` is the folder of a package. It is searched among the folders of
# ``ROS_PACKAGE_PATH`` and ``AMENT_PREFIX_PATH``, around the file that names it, and where Python's packages keep
# their shared data: the pip package ``example-robot-data`` (extra ``robots``) puts its robots there.

PACKAGE = "package://"
FILE = "file://"
ROBOTS = "example-robot-data"
SHARES = ("cmeel.prefix/share", "share")
"""Where below a folder of Python's path, or its prefix, packages keep shared data."""


def find_file(uri: str, *, near: Path | None, where: str | Path, field: str) -> Path:
    """The file that a robot description, a profile or a scene names.

    Args:
        uri: ``package://NAME/path``, ``file:///path``, or a path relative to ``near``.
        near: Folder of the file that names it; None for what comes with taskgist.
        where: File for error messages.
        field: Field for error messages.

    Raises:
        SceneError: There is no such file.
    """
    if uri.startswith(PACKAGE):
        return _in_package(uri, near, where, field)
    path = Path(uri.removeprefix(FILE))
    path = path if near is None else near / path
    if os.path.lexists(path):  # whether it is a file that can be read is told where it is read
        return path
    raise SceneError("no such file", where=where, field=field, value=str(path), hint="paths are relative to the file")


def _in_package(uri: str, near: Path | None, where: str | Path, field: str) -> Path:
    name, _, rest = uri.removeprefix(PACKAGE).lstrip("/").partition("/")
    for root in _roots(near):
        for folder in (root / name, root):
            if (folder is not root or root.name == name) and is_file(folder / rest):
                return folder / rest
    hint = f"add the folder that holds {name!r} to ROS_PACKAGE_PATH"
    if name == ROBOTS:
        hint = f"pip install 'taskgist[robots]', or {hint}"
    raise SceneError("no such file in any package", where=where, field=field, value=uri, hint=hint)


def _roots(near: Path | None) -> Iterator[Path]:
    """Folders that may hold a package, the surest first."""
    if near is not None:
        yield from (near.resolve(), *near.resolve().parents)
    for folder in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep):
        if folder:
            yield Path(folder)
    for folder in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if folder:
            yield Path(folder) / "share"
    for folder in (*sys.path, sys.prefix):
        yield from (Path(folder) / share for share in SHARES)


# --- Shapes of no size: MuJoCo refuses them without saying which one it means.

SIZES = {
    mujoco.mjtGeom.mjGEOM_SPHERE: 1,
    mujoco.mjtGeom.mjGEOM_CAPSULE: 2,
    mujoco.mjtGeom.mjGEOM_CYLINDER: 2,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: 3,
    mujoco.mjtGeom.mjGEOM_BOX: 3,
}
"""How many sizes each kind of shape has."""


def size_problems(spec: mujoco.MjSpec, where: str) -> Iterator[InputError]:
    """Every shape of a model whose size is zero or less."""
    for geom in spec.geoms:
        if geom.type not in SIZES or geom.meshname:
            continue
        count = 1 if np.isfinite(geom.fromto[0]) else SIZES[geom.type]
        sizes = [float(size) for size in geom.size[:count]]
        if any(size <= 0 for size in sizes):
            kind = geom.type.name.removeprefix("mjGEOM_").lower()
            name = repr(str(geom.name)) if geom.name else "without a name"
            field = f"{kind} {name} of body {str(geom.parent.name)!r}"
            hint = f"give it {count} size{'s' if count > 1 else ''} above zero, in metres"
            yield SceneError("a shape of no size", where=where, field=field, value=sizes, hint=hint)


BUILDERS: dict[str, Callable[[HumanSize], str]] = {"human": human_mjcf}
"""Models that are made to measure, by the name under which a profile asks for them."""


def builtin_models() -> tuple[str, ...]:
    """Names of the models that come with taskgist, made to measure or not."""
    return tuple(sorted((*BUILDERS, *(path.stem for path in _folder().glob("*.xml")))))


def add_body(
    profile: AgentProfile,
    key: str,
    files: dict[str, bytes],
    *,
    prefix: str,
    folder: Path | None,
    where: str,
    size: HumanSize | None = None,
    limits: Limits = DEFAULT.limits,
) -> None:
    """Add the files of an agent's model to a bundle.

    Args:
        profile: Names the model: built in, ``package://...``, or a file.
        key: Name of the model's document in the bundle.
        files: The bundle.
        prefix: Put before the names of its meshes.
        folder: To which a file is relative; None if the profile is built in.
        where: The profile's file, for messages.
        size: For models that are made to measure; without it, these are left to whoever knows the size.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: A file is missing or is no model.
    """
    if profile.model in BUILDERS:
        if size:
            files[key] = BUILDERS[profile.model](size).encode()
        return
    if profile.model in builtin_models():
        path = _folder() / f"{profile.model}.xml"
    else:
        path = find_file(profile.model, near=folder, where=where, field="model")
    add_model(path, key, files, prefix=prefix, shapes=profile.shapes, limits=limits)


def add_model(
    path: Path,
    key: str,
    files: dict[str, bytes],
    *,
    prefix: str = "",
    shapes: Shapes = "visual",
    room: bool = False,
    limits: Limits = DEFAULT.limits,
) -> mujoco.MjSpec:
    """Add a model to a bundle: one flat XML document under ``key``, and its meshes under names without folders.

    Args:
        path: MJCF or URDF.
        key: Name of the document.
        files: The bundle.
        prefix: Put before the names of meshes.
        shapes: Which shapes of a URDF are seen.
        room: Whether a URDF's root link is the world.
        limits: Bounds of what it may hold.

    Returns:
        The model.

    Raises:
        SceneError: A file is missing or is no model.
    """
    with reading(path, error=SceneError) as stream:
        check_model(stream.read(HEAD_BYTES), path.name, shown_path(path))
    text = read_file(path, most_bytes=limits.document_bytes)
    if is_urdf(text):
        near = path.parent
        spec = read_urdf(
            text,
            lambda uri: read_file(
                find_file(uri, near=near, where=path, field="mesh"),
                named_by=str(path),
                most_bytes=limits.mesh_bytes,
                setting="mesh_bytes",
            ),
            files,
            where=path,
            prefix=prefix,
            shapes=shapes,
            room=room,
            limits=limits,
        )
    else:
        root = parse_markup(text, where=path, limits=limits)
        read = from_folder(path.parent, path, limits=limits)
        spec = read_mjcf(root, read, files, where=str(path), prefix=prefix, limits=limits)
    files[key] = _xml(spec, files, str(path))
    return spec


def add_spec(
    spec: mujoco.MjSpec,
    key: str,
    files: dict[str, bytes],
    *,
    where: str,
    folder: Path = Path(),
    limits: Limits = DEFAULT.limits,
) -> None:
    """Add a specification to a bundle: one flat MJCF document under ``key``, and its meshes without folders.

    Args:
        spec: The model, which gets the new names; meshes are taken from its ``assets``, else from disk.
        key: Name of the document.
        files: The bundle.
        where: File for error messages.
        folder: To which files on disk are relative.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: A file is missing, or this is no model.
    """
    given = dict(spec.assets)
    kept: dict[str, bytes] = {}

    def content(name: str) -> bytes:
        if name in given:
            return bytes(given[name])
        path = folder / spec.meshdir / name
        return read_file(path, named_by=where, most_bytes=limits.mesh_bytes, setting="mesh_bytes")

    def keep(name: str, data: bytes) -> str:
        flat = keep_file(files, name.replace("/", "_"), data)
        kept[flat] = files[flat]
        return flat

    for mesh in (each for each in spec.meshes if each.file):
        data, ending = readable_mesh(content(mesh.file), mesh.file, where=where, kind=mesh.content_type, limits=limits)
        mesh.file = keep(mesh.file + ending, data)
        mesh.content_type = "" if ending else mesh.content_type
    for field in (each for each in spec.hfields if each.file):
        field.file = keep(field.file, content(field.file))
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for looks in (*spec.textures, *spec.skins):  # which nothing here looks at
        spec.delete(looks)
    spec.assets = kept
    spec.meshdir = spec.texturedir = ""
    files[key] = _xml(spec, files, where)


def _xml(spec: mujoco.MjSpec, files: dict[str, bytes], where: str) -> bytes:
    for problem in size_problems(spec, where):
        raise problem
    try:
        thicken_flat_meshes(spec, files, solid_meshes(spec))  # before the library that makes hulls sees them
    except SceneError as error:
        error.where = where
        raise
    with asking_mujoco("MuJoCo cannot read this model:", where):
        return str(made_of(spec, files, mujoco.MjSpec.to_xml)).encode()


def read_model(
    files: dict[str, bytes], name: str, *, where: str, room: bool, limits: Limits = DEFAULT.limits
) -> mujoco.MjSpec:
    """A model of a bundle, which names nothing outside of it.

    Args:
        files: The bundle; files that the model needs are added under the names that MuJoCo asks for.
        name: Name of the model's document.
        where: File for error messages.
        room: Whether it is no robot: a URDF's root link is the world then, and joints at the root stay.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: It is missing or is no model, or it names a file that is not in the bundle.
    """
    if name not in files:
        raise SceneError("no such file", where=where, field="scene.model", value=name)
    where = f"{where}: {name}"
    check_model(files[name], name, where)
    read = from_files(files, where)
    if is_urdf(files[name]):
        spec = read_urdf(
            files[name],
            lambda uri: read((uri, flat_name(uri)), "mesh")[1],
            files,
            where=where,
            room=room,
            limits=limits,
        )
    else:
        kept = read_kept(files[name], where=where, limits=limits)
        spec = kept or read_mjcf(
            parse_markup(files[name], where=where, limits=limits), read, files, where=where, limits=limits
        )
    if not room:
        stand_still(spec)
    return spec


def read_file(
    path: Path,
    *,
    named_by: str | None = None,
    most_bytes: int = DEFAULT.limits.document_bytes,
    setting: str = "document_bytes",
) -> bytes:
    """A regular file's content.

    Args:
        path: The file.
        named_by: The file that names it, for messages.
        most_bytes: It may not be larger.
        setting: The limit that says so.

    Raises:
        SceneError: It cannot be read, or is too large.
    """
    hint = f"named by {named_by}" if named_by else "check the path"
    return read_whole(path, most_bytes=most_bytes, setting=setting, error=SceneError, hint=hint)


def _folder() -> Path:
    return Path(str(resources.files("taskgist.world") / "models"))


def is_urdf(text: bytes) -> bool:
    """Whether a model's text is a URDF document."""
    return b"<robot" in text and b"<mujoco" not in text.partition(b"<robot")[0]
