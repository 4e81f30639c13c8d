"""Gathering: a scene file, and everything that it needs, becomes a bundle of files in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco

from taskgist.common.files import shown_path
from taskgist.errors import SceneError, UnknownNameError
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.bases import is_free
from taskgist.world.bodies.model_files import (
    PACKAGE,
    add_body,
    add_model,
    add_spec,
    find_file,
    name_problems,
    read_file,
    read_model,
)
from taskgist.world.bodies.profile import builtin_profile_text, builtin_profiles, parse_profile
from taskgist.world.bodies.urdf import read_urdf
from taskgist.world.composing import movers, name_things
from taskgist.world.scene_file import AgentEntry, PlacedModel, SceneFile, parse_scene_file, write_scene_file

SCENE_FILE = "scene.toml"
"""Name of the scene file in a bundle."""
STATURE = "stature_m"


def bundle_from_path(path: Path, *, limits: Limits = DEFAULT.limits) -> dict[str, bytes]:
    """Gather a scene file and everything that it needs into memory.

    Args:
        path: The scene's TOML file.
        limits: Bounds of what it may hold.

    Returns:
        File contents by the names that ``parse_scene_file`` and ``assemble`` look for.

    Raises:
        SceneError: A file is missing or is no model.
    """
    text = read_file(path, most_bytes=limits.toml_bytes, setting="toml_bytes")
    file = parse_scene_file(text, where=shown_path(path), limits=limits)
    bundle = {SCENE_FILE: text}
    if file.model is not None:
        model = find_file(file.model, near=path.parent, where=path, field="scene.model")
        room = add_model(model, file.model, bundle, room=True, limits=limits)
        _name_movers(file, room, bundle)
    for each in file.placed:
        found = find_file(each.file, near=path.parent, where=path, field=each.table)
        if each.is_mesh:
            _add_mesh(found, each, bundle, str(path), limits)
        else:
            add_model(found, each.key, bundle, room=each.kind == "furniture", limits=limits)
    for agent in file.agents:
        _add_agent(agent, bundle, path.parent, str(path), limits)
    return bundle


def bundle_from_spec(
    room: mujoco.MjSpec, file: SceneFile, files: Mapping[str, bytes], *, limits: Limits = DEFAULT.limits
) -> dict[str, bytes]:
    """Gather a room that is a value, its agents, and everything that they need.

    Args:
        room: The room's model; it stays as it is.
        file: The scene file; its model's name is that which the room gets in the bundle.
        files: What is not on disk: profiles and models of agents by the names that ``assemble`` looks for.
        limits: Bounds of what it may hold.

    Returns:
        As ``bundle_from_path``.

    Raises:
        SceneError: As there.
    """
    assert file.model is not None
    folder = Path(room.modelfiledir)
    bundle = {SCENE_FILE: write_scene_file(file), **files}
    room = room.copy()
    add_spec(room, file.model, bundle, where=file.where, folder=folder, limits=limits)
    for agent in file.agents:
        if agent.profile_key not in bundle:
            _add_agent(agent, bundle, Path(), file.where, limits)
        elif agent.model_key not in bundle and agent.room_body is None:
            _add_packaged(agent, bundle, file.where, limits)
    _name_movers(file, room, bundle)
    return bundle


def bundle_with_agent(
    bundle: Mapping[str, bytes], agent: AgentEntry, *, where: str, limits: Limits = DEFAULT.limits
) -> dict[str, bytes]:
    """The files of a scene with one more agent in it.

    Args:
        bundle: The scene's files.
        agent: Who comes in, the last of all; a profile of its own is looked for from the working folder.
        where: What the scene comes from, for messages.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: Somebody of that name is there, or its profile or model cannot be used.
    """
    file = parse_scene_file(bundle[SCENE_FILE], where=where, limits=limits)
    if agent.name in {each.name for each in file.agents}:
        raise SceneError("is in the room already", where=where, field="agents", value=agent.name, hint="another name")
    if agent.room_body is not None:
        hint = "name it in the scene file, or bring in a model of its own"
        problem, field = "who comes in is no body of the room", f"agents.{agent.name}.room_body"
        raise SceneError(problem, where=where, field=field, value=agent.room_body, hint=hint)
    found = dict(bundle)
    _add_agent(agent, found, Path(), where, limits)
    found[SCENE_FILE] = write_scene_file(replace(file, agents=(*file.agents, agent)))
    return found


def _name_movers(file: SceneFile, room: mujoco.MjSpec, bundle: dict[str, bytes]) -> None:
    """Name as objects the bodies that move freely without a free joint, where the scene file names none.

    In a bundle only free bodies are objects by themselves, as in recordings from before others could be.
    """
    if file.objects is not None:
        return
    name_things(room)
    names = movers(room, file)
    if any(not is_free(room.body(name)) for name in names):
        bundle[SCENE_FILE] = write_scene_file(replace(file, objects=names))


def _add_mesh(path: Path, each: PlacedModel, bundle: dict[str, bytes], where: str, limits: Limits) -> None:
    """An object that is a mesh, as a model of one body: the link that a URDF would make of it."""
    at = f"{where}: {each.table}"
    robot = Element("robot", name=each.name)
    shape = SubElement(SubElement(SubElement(robot, "link", name=each.name), "collision"), "geometry")
    SubElement(shape, "mesh", filename=path.name, scale=" ".join([repr(each.scale)] * 3))

    def read(_: str) -> bytes:
        return read_file(path, named_by=at, most_bytes=limits.mesh_bytes, setting="mesh_bytes")

    spec = read_urdf(tostring(robot), read, bundle, where=at, limits=limits)
    for mesh in spec.meshes:  # scans have holes, so that nothing is inside of them
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
    for geom in spec.geoms if each.mass_kg is not None else ():
        geom.mass = each.mass_kg
    add_spec(spec, each.key, bundle, where=at, limits=limits)


def _add_packaged(agent: AgentEntry, bundle: dict[str, bytes], where: str, limits: Limits) -> None:
    """The model of a profile that is a value, where it is in a package of this machine."""
    at = f"{where}: {agent.profile_key}"
    text = bundle[agent.profile_key]
    profile = parse_profile(text, where=at, stature_m=agent.body.get(STATURE), limits=limits)
    if profile.model.startswith(PACKAGE):
        add_body(profile, agent.model_key, bundle, prefix=f"{agent.name}_", folder=None, where=at, limits=limits)


def _add_agent(agent: AgentEntry, bundle: dict[str, bytes], scene_folder: Path, where: str, limits: Limits) -> None:
    """The profile and the model of an agent; a body of the room is in the room's model."""
    if agent.profile in builtin_profiles():
        text, folder, named = builtin_profile_text(agent.profile).encode(), None, f"profile {agent.profile}"
    else:
        path = scene_folder / agent.profile
        field = f"{where}: agents.{agent.name}"
        if path.suffix != ".toml":
            raise UnknownNameError("profile", agent.profile, builtin_profiles(), where=field)
        text = read_file(path, named_by=f"{field}.profile", most_bytes=limits.toml_bytes, setting="toml_bytes")
        folder, named = path.parent, shown_path(path)
    profile = parse_profile(text, where=named, stature_m=agent.body.get(STATURE), limits=limits)
    bundle[agent.profile_key] = text
    if agent.room_body is not None:
        return
    add_body(profile, agent.model_key, bundle, prefix=f"{agent.name}_", folder=folder, where=named, limits=limits)
    if folder is not None and agent.model_key in bundle:  # here, where the file's own name is known
        spec = read_model(bundle, agent.model_key, where=named, room=False, limits=limits)
        for problem in name_problems(spec, profile, named):
            raise problem
