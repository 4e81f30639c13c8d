"""Models as files of a bundle: one flat MJCF document, and its meshes beside it, wherever they come from.

MJCF is gathered as it is; URDF becomes MJCF here, so that a recording of a robot opens without ROS and without the
package that the robot came from.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import resources
from pathlib import Path

import mujoco

from taskgist.errors import SceneError
from taskgist.world.body.anthropometry import HumanSize
from taskgist.world.body.human import human_mjcf
from taskgist.world.body.packages import PACKAGE, find_file
from taskgist.world.body.profile import AgentProfile
from taskgist.world.body.sizes import size_problems
from taskgist.world.body.urdf import Shapes, flat_name, is_urdf, read_urdf

BUILDERS: dict[str, Callable[[HumanSize], str]] = {"human": human_mjcf}
"""Models that are made to measure, by the name under which a profile asks for them."""


def builtin_models() -> tuple[str, ...]:
    """Names of the models that come with taskgist, made to measure or not."""
    return tuple(sorted((*BUILDERS, *(path.stem for path in _folder().glob("*.xml")))))


def body_files(
    profile: AgentProfile, key: str, *, prefix: str, folder: Path | None, where: str, size: HumanSize | None = None
) -> dict[str, bytes]:
    """The files of an agent's model.

    Args:
        profile: Names the model: built in, ``package://...``, or a file.
        key: Name of the model's document in the bundle.
        prefix: Put before the names of its meshes.
        folder: To which a file is relative; None if the profile is built in.
        where: The profile's file, for messages.
        size: For models that are made to measure; without it, these are left to whoever knows the size.

    Raises:
        SceneError: A file is missing or is no model.
    """
    if profile.model in BUILDERS:
        return {key: BUILDERS[profile.model](size).encode()} if size else {}
    if profile.model in builtin_models():
        path = _folder() / f"{profile.model}.xml"
    else:
        path = find_file(profile.model, near=folder, where=where, field="model")
    return model_files(path, key, prefix=prefix, shapes=profile.shapes)


def is_found_anywhere(model: str) -> bool:
    """Whether a model is found without the folder of the file that names it."""
    return model in builtin_models() or model.startswith(PACKAGE)


def model_files(
    path: Path, key: str, *, prefix: str = "", shapes: Shapes = "visual", room: bool = False
) -> dict[str, bytes]:
    """A model as one flat XML document under ``key``, and its meshes under names without folders.

    Args:
        path: MJCF or URDF.
        key: Name of the document.
        prefix: Put before the names of meshes.
        shapes: Which shapes of a URDF are seen.
        room: Whether a URDF's root link is the world.

    Raises:
        SceneError: A file is missing or is no model.
    """
    text = read_file(path)
    if is_urdf(text):
        near = path.parent
        spec, files = read_urdf(
            text,
            lambda uri: read_file(find_file(uri, near=near, where=path, field="mesh")),
            where=path,
            prefix=prefix,
            shapes=shapes,
            room=room,
        )
    else:
        spec, files = _mjcf(path, prefix)
    return {**files, key: _xml(spec, files, path)}


def _mjcf(path: Path, prefix: str) -> tuple[mujoco.MjSpec, dict[str, bytes]]:
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=path) from error
    files: dict[str, bytes] = {}
    for meshes, folder in ((spec.meshes, spec.meshdir), (spec.textures, spec.texturedir)):
        for asset in meshes:
            if asset.file:
                source = path.parent / folder / asset.file
                asset.file = prefix + asset.file.replace("/", "_")
                files[asset.file] = read_file(source, named_by=str(path))
    spec.meshdir = spec.texturedir = ""
    return spec, files


def _xml(spec: mujoco.MjSpec, files: Mapping[str, bytes], path: Path) -> bytes:
    spec.assets = dict(files)
    for problem in size_problems(spec, str(path)):
        raise problem
    try:
        return str(spec.to_xml()).encode()
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=path) from error


def read_model(files: dict[str, bytes], name: str, *, where: str, room: bool) -> mujoco.MjSpec:
    """A model of a bundle; meshes of a URDF are added to the bundle under the names that MuJoCo asks for.

    Args:
        files: The bundle.
        name: Name of the model's document.
        where: File for error messages.
        room: Whether a URDF's root link is the world.

    Raises:
        SceneError: It is missing or is no model.
    """
    if name not in files:
        raise SceneError("no such file", where=where, field="scene.model", value=name)
    where = f"{where}: {name}"
    if is_urdf(files[name]):
        spec, meshes = read_urdf(files[name], lambda uri: _mesh(files, uri, where), where=where, room=room)
        files |= meshes
        return spec
    try:
        return mujoco.MjSpec.from_string(files[name].decode("utf-8"))
    except (ValueError, UnicodeDecodeError) as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=where) from error


def _mesh(files: Mapping[str, bytes], uri: str, where: str) -> bytes:
    for name in (uri, flat_name(uri)):
        if name in files:
            return files[name]
    raise SceneError("no such file", where=where, field="mesh", value=uri)


def read_file(path: Path, *, named_by: str | None = None) -> bytes:
    """A file's content.

    Raises:
        SceneError: It cannot be read.
    """
    try:
        return path.read_bytes()
    except OSError as error:
        hint = f"named by {named_by}" if named_by else "check the path"
        raise SceneError(f"cannot be read: {error.strerror}", where=path, hint=hint) from error


def _folder() -> Path:
    return Path(str(resources.files("taskgist.world") / "models"))
