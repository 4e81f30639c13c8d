"""Assembly: room, objects and agents become one MuJoCo model, with everybody in place."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.body.agent import Agent, resolve_agent
from taskgist.world.body.anthropometry import HumanSize
from taskgist.world.body.frames import add_frame
from taskgist.world.body.hands import add_ghosts
from taskgist.world.body.model_files import BUILDERS, body_files, builtin_models, is_found_anywhere, read_model
from taskgist.world.body.named import name_problems
from taskgist.world.body.placing import placed
from taskgist.world.body.profile import AgentProfile, builtin_profile_text
from taskgist.world.body.profile_file import parse_profile
from taskgist.world.body.sizes import size_problems
from taskgist.world.body.urdf import COLLISION_GROUP
from taskgist.world.geometry.bounds import bound_all_shapes
from taskgist.world.geometry.decomposition import decompose
from taskgist.world.scene_file import DEFAULT_STATURE_M, STATURE, AgentEntry, SceneFile
from taskgist.world.state import State

mujoco.set_mju_user_warning(logging.getLogger("taskgist.world").warning)  # otherwise MuJoCo writes a file of its own


@dataclass(frozen=True, eq=False)
class Assembled:
    """A compiled model with its agents, the state of the scene file, and every file that made it."""

    model: mujoco.MjModel
    agents: dict[str, Agent]
    initial: State
    bundle: dict[str, bytes]


def assemble(file: SceneFile, bundle: Mapping[str, bytes]) -> Assembled:
    """Compile a scene.

    Args:
        file: The parsed scene file.
        bundle: Its files by name; built-in profiles and made-to-measure models are added where they are missing.

    Raises:
        SceneError: A model does not compile, or an agent cannot be placed.
    """
    files = dict(bundle)
    profiles = {entry.name: _profile(entry, files, file.where) for entry in file.agents}
    room = _spec(files, file.model, file.where, room=True)
    _check_names(file, room)
    decompose(room, lambda spec: _compile(spec, files, file.where), files, file.where)
    for entry in file.agents:
        body = _agent_spec(profiles[entry.name], files, entry, file.where)
        room.assets = body.assets = _assets(files)  # MuJoCo warns if only one of them has any
        room.attach(body, prefix=f"{entry.name}/", frame=room.worldbody.add_frame())
    model = _compile(room, files, file.where)
    bound_all_shapes(model)
    agents = {
        entry.name: resolve_agent(model, entry.name, profiles[entry.name], _stature(entry)) for entry in file.agents
    }
    return Assembled(model, agents, placed(model, agents, file), files)


def _check_names(file: SceneFile, room: mujoco.MjSpec) -> None:
    """An agent is told from furniture and objects by its name, so none of them may share it."""
    taken = {str(item.name).partition("/")[0] for item in (*room.bodies, *room.geoms)}
    for entry in file.agents:
        if entry.name in taken:
            hint = "rename the agent, or the body or shape of the model"
            raise SceneError(
                "the model has something of that name", where=file.where, field="agents", value=entry.name, hint=hint
            )


def _stature(entry: AgentEntry) -> float:
    return entry.body.get(STATURE, DEFAULT_STATURE_M)


def _profile(entry: AgentEntry, files: dict[str, bytes], where: str) -> AgentProfile:
    if entry.profile_key not in files:
        files[entry.profile_key] = builtin_profile_text(entry.profile).encode()
    at = f"{where}: {entry.profile_key}"
    profile = parse_profile(files[entry.profile_key], where=at, stature_m=_stature(entry))
    if entry.body and profile.model not in BUILDERS:
        hint = "only made-to-measure bodies have sizes: leave them out"
        field, given = f"agents.{entry.name}.body", ", ".join(entry.body)
        raise SceneError(f"the body of {profile.name!r} is as it is", where=where, field=field, value=given, hint=hint)
    if entry.model_key not in files:
        files |= _model(profile, entry, where)
    return profile


def _model(profile: AgentProfile, entry: AgentEntry, where: str) -> dict[str, bytes]:
    """The files of a model that did not come with the scene."""
    at = f"{where}: {entry.profile_key}"
    if not is_found_anywhere(profile.model):
        raise UnknownNameError("model", profile.model, builtin_models(), where=at)
    size = _size(entry, where) if profile.model in BUILDERS else None
    return body_files(profile, entry.model_key, prefix=f"{entry.name}_", folder=None, where=at, size=size)


def _size(entry: AgentEntry, where: str) -> HumanSize:
    measured = {key: value for key, value in entry.body.items() if key != STATURE}
    try:
        return HumanSize.from_stature(_stature(entry), **measured)
    except SceneError as error:
        error.where, error.field = where, f"agents.{entry.name}.body.{error.field}"
        raise


def _spec(files: dict[str, bytes], name: str, where: str, *, room: bool) -> mujoco.MjSpec:
    spec = read_model(files, name, where=where, room=room)
    for problem in size_problems(spec, f"{where}: {name}"):
        raise problem
    return spec


def _agent_spec(profile: AgentProfile, files: dict[str, bytes], entry: AgentEntry, where: str) -> mujoco.MjSpec:
    """An agent's model with all that reasoning needs: a base that is free to move, frames, and shapes of grasps."""
    spec = _spec(files, entry.model_key, entry.name, room=False)
    spec.compiler.balanceinertia = True  # MJCF text of a URDF has lost that; published inertias are often impossible
    for problem in name_problems(spec, profile, f"{where}: {entry.profile_key}"):
        raise problem
    root = spec.worldbody.first_body()
    if not root.joints:
        root.add_freejoint(name="root")
    for label, _, frame in profile.frames:
        add_frame(spec, frame, label)
    for geom in (geom for name in profile.eye.housing for geom in spec.body(name).geoms):
        geom.group = COLLISION_GROUP
    for arm in profile.arms if profile.hand else ():
        assert profile.hand is not None
        add_ghosts(spec.body(arm.hand), arm.side, profile.hand)
    return spec


def _compile(spec: mujoco.MjSpec, files: Mapping[str, bytes], where: str) -> mujoco.MjModel:
    spec.assets = _assets(files)
    try:
        return spec.compile()
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot compile this scene: {error}", where=where) from error


def _assets(files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {name: data for name, data in files.items() if not name.endswith((".toml", ".xml", ".urdf"))}
