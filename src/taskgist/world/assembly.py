"""Assembly: files are gathered, room, objects and agents become one MuJoCo model, and everybody is put in place."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from taskgist.common.arrays import Indices
from taskgist.common.files import shown_path
from taskgist.errors import SceneError, UnknownNameError, most_read
from taskgist.settings import DEFAULT, Limits
from taskgist.world.bodies.agent import (
    SEEN_MASK,
    Agent,
    couplings,
    legs_for,
    resolve_agent,
    standing_height_m,
    subtree,
)
from taskgist.world.bodies.hands import add_ghosts
from taskgist.world.bodies.human import HumanSize
from taskgist.world.bodies.markup import asking_mujoco
from taskgist.world.bodies.mending import give_least_mass, has_mass, made_of
from taskgist.world.bodies.model_files import (
    BUILDERS,
    PACKAGE,
    add_body,
    add_model,
    add_spec,
    builtin_models,
    find_file,
    name_problems,
    read_file,
    read_model,
    size_problems,
)
from taskgist.world.bodies.profile import (
    AgentProfile,
    add_frame,
    builtin_profile_text,
    builtin_profiles,
    parse_profile,
)
from taskgist.world.bodies.urdf import COLLISION_GROUP
from taskgist.world.geometry.convex import decompose
from taskgist.world.geometry.distances import bound_all_shapes
from taskgist.world.geometry.transforms import about_z
from taskgist.world.scene_file import AgentEntry, SceneFile, parse_scene_file, write_scene_file
from taskgist.world.seen import hide_stand_ins, show_groups
from taskgist.world.state import State

SCENE_FILE = "scene.toml"
"""Name of the scene file in a bundle."""
STATURE = "stature_m"
DEFAULT_STATURE_M = 1.75


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
    model = find_file(file.model, near=path.parent, where=path, field="scene.model")
    add_model(model, file.model, bundle, room=True, limits=limits)
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
    folder = Path(room.modelfiledir)
    bundle = {SCENE_FILE: write_scene_file(file), **files}
    add_spec(room.copy(), file.model, bundle, where=file.where, folder=folder, limits=limits)
    for agent in file.agents:
        if agent.profile_key not in bundle:
            _add_agent(agent, bundle, Path(), file.where, limits)
        elif agent.model_key not in bundle:
            _add_packaged(agent, bundle, file.where, limits)
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
    found = dict(bundle)
    _add_agent(agent, found, Path(), where, limits)
    found[SCENE_FILE] = write_scene_file(replace(file, agents=(*file.agents, agent)))
    return found


def _add_packaged(agent: AgentEntry, bundle: dict[str, bytes], where: str, limits: Limits) -> None:
    """The model of a profile that is a value, where it is in a package of this machine."""
    at = f"{where}: {agent.profile_key}"
    text = bundle[agent.profile_key]
    profile = parse_profile(text, where=at, stature_m=agent.body.get(STATURE), limits=limits)
    if profile.model.startswith(PACKAGE):
        add_body(profile, agent.model_key, bundle, prefix=f"{agent.name}_", folder=None, where=at, limits=limits)


def _add_agent(agent: AgentEntry, bundle: dict[str, bytes], scene_folder: Path, where: str, limits: Limits) -> None:
    """The profile and the model of an agent."""
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
    add_body(profile, agent.model_key, bundle, prefix=f"{agent.name}_", folder=folder, where=named, limits=limits)
    if folder is not None and agent.model_key in bundle:  # here, where the file's own name is known
        spec = read_model(bundle, agent.model_key, where=named, room=False, limits=limits)
        for problem in name_problems(spec, profile, named):
            raise problem


# --- Placing agents: from a scene file's words to the first state of the scene.

ABOVE_SEATS_M = 1.2
"""Height from which a seat is searched downwards."""


def placed(model: mujoco.MjModel, agents: Mapping[str, Agent], file: SceneFile) -> State:
    """The state in which every agent is where the file says: on the floor, or on the seat that is found there.

    Raises:
        SceneError: There is no seat, or a joint does not go there.
        UnknownNameError: There is no such joint.
    """
    data = mujoco.MjData(model)
    for agent in agents.values():
        data.qpos[agent.base] = (0, 0, -1000, 1, 0, 0, 0)  # out of the way of the search for seats
    mujoco.mj_kinematics(model, data)
    qpos = np.array(data.qpos)
    for entry in file.agents:
        agent = agents[entry.name]
        legs, height = _stance(model, data, agent, entry, file.where)
        given = _given(model, entry, agent, file.where)
        joints = _rest(model, agent) | legs | given
        joints |= _following(model, agent, given)
        for joint, value in joints.items():
            qpos[agent.joints[joint]] = value
        if not agent.profile.legs.feet:
            height = standing_height_m(model, agent, qpos)
        qpos[agent.base] = (*entry.position_m, height, *about_z(entry.yaw_rad))
    return State(qpos)


def _rest(model: mujoco.MjModel, agent: Agent) -> dict[str, float]:
    """Where joints are if the scene says nothing: as the profile has it, else zero or the limit next to it."""
    rest = dict.fromkeys(agent.joints, 0.0) | dict(agent.profile.rest_rad) | dict(agent.profile.rest_m)
    for joint, value in rest.items():
        limits = model.joint(f"{agent.name}/{joint}")
        if limits.limited[0]:
            rest[joint] = float(np.clip(value, *limits.range))
    return rest


def _given(model: mujoco.MjModel, entry: AgentEntry, agent: Agent, where: str) -> dict[str, float]:
    """What the scene says about joints."""
    turns = (entry.joints_rad, mujoco.mjtJoint.mjJNT_HINGE, "joints_deg", math.degrees(1.0), "turns", "degrees")
    slides = (entry.joints_m, mujoco.mjtJoint.mjJNT_SLIDE, "joints_m", 1.0, "slides", "metres")
    for given, kind, table, scale, moves, unit in (turns, slides):
        place = f"agents.{entry.name}.{table}"
        for joint, value in given.items():
            if joint not in agent.joints:
                raise UnknownNameError("joint", joint, agent.joints, where=f"{where}: {place}")
            limits = model.joint(f"{agent.name}/{joint}")
            if int(limits.type[0]) != int(kind):
                hint = "joints_deg is for those that turn, joints_m for those that slide"
                raise SceneError(f"not a joint that {moves}", where=where, field=f"{place}.{joint}", hint=hint)
            low, high = (scale * float(limit) for limit in limits.range)
            if limits.limited[0] and not low - 1e-6 <= scale * value <= high + 1e-6:
                hint = f"it {moves} from {low:.3g} to {high:.3g} {unit}"
                raise SceneError(
                    "beyond the joint", where=where, field=f"{place}.{joint}", value=round(scale * value, 3), hint=hint
                )
    return {**entry.joints_rad, **entry.joints_m}


def _following(model: mujoco.MjModel, agent: Agent, given: Mapping[str, float]) -> dict[str, float]:
    """Where joints are that follow one of those that the scene gives, and that it does not give themselves."""
    found = dict[str, float]()
    names = {joint: str(model.joint(joint).name).removeprefix(f"{agent.name}/") for joint in range(model.njnt)}
    for coupling in couplings(model):
        leader, follower = names[coupling.leader], names[coupling.follower]
        if agent.joints.get(leader) == model.jnt_qposadr[coupling.leader] and leader in given and follower not in given:
            found[follower] = float(coupling.led(model, given[leader]))
    return found


def _stance(
    model: mujoco.MjModel, data: mujoco.MjData, agent: Agent, entry: AgentEntry, where: str
) -> tuple[dict[str, float], float]:
    """Leg angles and height of the root."""
    if entry.posture not in agent.profile.legs.can:
        raise SceneError(
            "this profile does not take that posture",
            where=where,
            field=f"agents.{entry.name}.posture",
            value=entry.posture,
            hint=f"it can be {' or '.join(agent.profile.legs.can)}",
        )
    if entry.posture == "standing":
        return legs_for(model, agent, hip_height_m=math.inf)
    seat = entry.seat_height_m if entry.seat_height_m is not None else _seat_height(model, data, entry, where)
    return legs_for(model, agent, hip_height_m=seat + agent.profile.legs.seat_share * agent.stature_m)


def _seat_height(model: mujoco.MjModel, data: mujoco.MjData, entry: AgentEntry, where: str) -> float:
    top = np.array([*entry.position_m, ABOVE_SEATS_M])
    distance = mujoco.mj_ray(model, data, top, np.array([0.0, 0.0, -1.0]), SEEN_MASK, True, -1, np.zeros(1, np.int32))
    height = ABOVE_SEATS_M - distance
    if distance < 0 or height < 0.2:
        raise SceneError(
            "nothing to sit on there",
            where=where,
            field=f"agents.{entry.name}.position_m",
            value=entry.position_m,
            hint="move the agent over a seat, or give seat_height_m",
        )
    return float(height)


# Otherwise MuJoCo prints its warnings, and writes a file of its own; with no handler at all, Python prints them.
_warnings = logging.getLogger("taskgist.world.mujoco")
_warnings.addHandler(logging.NullHandler())
mujoco.set_mju_user_warning(_warnings.warning)


@dataclass(frozen=True, eq=False)
class Assembled:
    """A compiled model with its agents, the state of the scene file, and every file that made it."""

    model: mujoco.MjModel
    agents: dict[str, Agent]
    initial: State
    bundle: dict[str, bytes]


def assemble(file: SceneFile, bundle: Mapping[str, bytes], *, limits: Limits = DEFAULT.limits) -> Assembled:
    """Compile a scene. No file outside of the bundle is opened, but those that come with taskgist.

    Args:
        file: The parsed scene file.
        bundle: Its files by name; built-in profiles and made-to-measure models are added where they are missing.
        limits: Bounds of what it may hold.

    Raises:
        SceneError: A model does not compile, names a file that is not there, is too large, or an agent cannot be
            placed.
    """
    room, files, profiles = _put_together(file, bundle, limits)
    model = _compile(room, files, file.where)
    _check_objects(model, file, limits)
    bound_all_shapes(model)
    agents = {
        entry.name: resolve_agent(model, entry.name, profiles[entry.name], _stature(entry)) for entry in file.agents
    }
    return Assembled(model, agents, placed(model, agents, file), files)


def as_mjcf(
    file: SceneFile, bundle: Mapping[str, bytes], *, limits: Limits = DEFAULT.limits
) -> tuple[str, dict[str, bytes]]:
    """The model that ``assemble`` compiles as text, and the meshes and images that it names, by their names there.

    Raises:
        SceneError: As ``assemble``.
    """
    spec, files, _ = _put_together(file, bundle, limits)
    _compile(spec, files, file.where)
    text = str(spec.to_xml())
    named = {name: re.search(rf'"((?:[^"]*/)?{re.escape(name)})"', text) for name in files}
    return text, {found[1]: files[name] for name, found in named.items() if found}


def _put_together(
    file: SceneFile, bundle: Mapping[str, bytes], limits: Limits
) -> tuple[mujoco.MjSpec, dict[str, bytes], dict[str, AgentProfile]]:
    """Room, objects and agents as one specification; every file that makes it; and the agents' profiles."""
    files = dict(bundle)
    _check_bytes(files, file.where, limits)
    profiles = {entry.name: _profile(entry, files, file.where, limits) for entry in file.agents}
    room = _spec(files, file.model, file.where, room=True, limits=limits)
    _check_names(file, room)
    _check_flexes(room, f"{file.where}: {file.model}")
    if file.seen_groups is None:
        hide_stand_ins(room, lambda: _compile(room, files, file.where))
    else:
        show_groups(room, file.seen_groups)

    def compiled_room(spec: mujoco.MjSpec) -> mujoco.MjModel:
        model = _compile(spec, files, file.where)
        _check_objects(model, file, limits)
        return model

    decompose(room, compiled_room, files, file.where, limits)
    for entry in file.agents:
        body = _agent_spec(profiles[entry.name], files, entry, file.where, limits)
        room.assets = body.assets = _assets(files)  # MuJoCo warns if only one of them has any
        with asking_mujoco(f"MuJoCo cannot put {entry.name!r} into this scene:", file.where):
            room.attach(body, prefix=f"{entry.name}/", frame=room.worldbody.add_frame())
    return room, files, profiles


def _check_bytes(files: Mapping[str, bytes], where: str, limits: Limits) -> None:
    together = sum(map(len, files.values()))
    if together > limits.bundle_bytes:
        hint = most_read(limits.bundle_bytes, "bundle_bytes")
        raise SceneError("the files of this scene are too large", where=where, value=f"{together:,} bytes", hint=hint)


def _check_flexes(spec: mujoco.MjSpec, where: str) -> None:
    """Refuse what bends: no ray of ours meets it, so that all behind it would be seen."""
    for flex in spec.flexes:
        hint = "leave it out, or make it a mesh (or boxes) where it hangs or lies"
        problem = "a flex (cloth, rope or soft body) is not read"
        raise SceneError(problem, where=where, field="flex", value=flex.name, hint=hint)


def _check_objects(model: mujoco.MjModel, file: SceneFile, limits: Limits) -> None:
    """Refuse objects that no hand deals with: their surfaces are sampled by the centimetre, shape by shape."""
    agents = {entry.name for entry in file.agents}
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for name, body in free_bodies(model, agents).items():
        if file.objects is not None and name not in file.objects:
            continue
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, subtree(model, body)))
        if len(geoms) > limits.body_shapes:
            hint = f"give it a mesh: {most_read(limits.body_shapes, 'body_shapes')}"
            problem, field = f"{name!r} has too many shapes", f"scene.model {file.model!r}"
            raise SceneError(problem, where=file.where, field=field, value=len(geoms), hint=hint)
        extent_m = _extent_m(model, data, body, geoms)
        if not extent_m <= limits.object_extent_m:
            hint = (
                'in millimetres? lengths are in metres: divide sizes by 1000, and give meshes scale="0.001 0.001 0.001"'
                f" (at most {limits.object_extent_m:g} m: setting limits.object_extent_m)"
            )
            problem = f"the box around {name!r} is {extent_m:,.0f} m long"
            raise SceneError(problem, where=file.where, field=f"scene.model {file.model!r}", hint=hint)


def _extent_m(model: mujoco.MjModel, data: mujoco.MjData, body: int, geoms: Indices) -> float:
    """Longest edge of the box around a body's shapes, in the body's own frame; planes apart."""
    geoms = geoms[model.geom_rbound[geoms] > 0]
    if not len(geoms):
        return 0.0
    frame = data.xmat[body].reshape(3, 3)
    turns = frame.T @ data.geom_xmat[geoms].reshape(-1, 3, 3)
    centers, halves = model.geom_aabb[geoms, :3], model.geom_aabb[geoms, 3:]
    middles = (data.geom_xpos[geoms] - data.xpos[body]) @ frame + np.einsum("nij,nj->ni", turns, centers)
    reach = np.einsum("nij,nj->ni", np.abs(turns), halves)
    return float(((middles + reach).max(axis=0) - (middles - reach).min(axis=0)).max())


def free_bodies(model: mujoco.MjModel, agents: Collection[str]) -> dict[str, int]:
    """Every body that moves freely and is no agent's, by name."""
    return {
        str(model.body(b).name): b
        for b in range(1, model.nbody)
        if model.body_jntnum[b] == 1
        and int(model.jnt_type[model.body_jntadr[b]]) == int(mujoco.mjtJoint.mjJNT_FREE)
        and str(model.body(b).name).partition("/")[0] not in agents
    }


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


def _profile(entry: AgentEntry, files: dict[str, bytes], where: str, limits: Limits) -> AgentProfile:
    if entry.profile_key not in files:
        if entry.profile not in builtin_profiles():
            raise _outside("profile", entry.profile, builtin_profiles(), f"{where}: agents.{entry.name}")
        files[entry.profile_key] = builtin_profile_text(entry.profile).encode()
    at = f"{where}: {entry.profile_key}"
    profile = parse_profile(files[entry.profile_key], where=at, stature_m=_stature(entry), limits=limits)
    if entry.body and profile.model not in BUILDERS:
        hint = "only made-to-measure bodies have sizes: leave them out"
        field, given = f"agents.{entry.name}.body", ", ".join(entry.body)
        raise SceneError(f"the body of {profile.name!r} is as it is", where=where, field=field, value=given, hint=hint)
    if entry.model_key not in files:
        if profile.model not in builtin_models():
            raise _outside("model", profile.model, builtin_models(), at)
        size = _size(entry, where) if profile.model in BUILDERS else None
        prefix = f"{entry.name}_"
        add_body(profile, entry.model_key, files, prefix=prefix, folder=None, where=at, size=size, limits=limits)
    return profile


def _outside(kind: str, name: str, known: Collection[str], where: str) -> UnknownNameError:
    """What a bundle names, and neither holds nor finds in taskgist; on this machine it is not looked for."""
    return UnknownNameError(f"{kind} among the scene's own files", name, known, where=where)


def _size(entry: AgentEntry, where: str) -> HumanSize:
    measured = {key: value for key, value in entry.body.items() if key != STATURE}
    try:
        return HumanSize.from_stature(_stature(entry), **measured)
    except SceneError as error:
        error.where, error.field = where, f"agents.{entry.name}.body.{error.field}"
        raise


def _spec(files: dict[str, bytes], name: str, where: str, *, room: bool, limits: Limits) -> mujoco.MjSpec:
    spec = read_model(files, name, where=where, room=room, limits=limits)
    for problem in size_problems(spec, f"{where}: {name}"):
        raise problem
    return spec


def _agent_spec(
    profile: AgentProfile, files: dict[str, bytes], entry: AgentEntry, where: str, limits: Limits
) -> mujoco.MjSpec:
    """An agent's model with all that reasoning needs: a base that is free to move, frames, and shapes of grasps."""
    spec = _spec(files, entry.model_key, entry.name, room=False, limits=limits)
    if len(spec.geoms) > limits.body_shapes:
        hint = f"leave out what is only shown: {most_read(limits.body_shapes, 'body_shapes')}"
        field = f"{entry.name}: {entry.model_key}"
        raise SceneError("a body of too many shapes", where=where, field=field, value=len(spec.geoms), hint=hint)
    _check_flexes(spec, f"{where}: {entry.model_key}")
    spec.compiler.balanceinertia = True  # MJCF text of a URDF has lost that; published inertias are often impossible
    hide_stand_ins(spec, lambda: _compile(spec, files, where))
    for problem in name_problems(spec, profile, f"{where}: {entry.profile_key}"):
        raise problem
    root = spec.worldbody.first_body()
    if not root.joints:
        root.add_freejoint(name="root")
        if not has_mass(root):
            give_least_mass(spec)
    for label, _, frame in profile.frames:
        add_frame(spec, frame, label)
    for geom in (geom for name in profile.eye.housing for geom in spec.body(name).geoms):
        geom.group = COLLISION_GROUP
    for arm in profile.arms if profile.hand else ():
        assert profile.hand is not None
        add_ghosts(spec.body(arm.hand), arm.side, profile.hand)
    return spec


def _compile(spec: mujoco.MjSpec, files: dict[str, bytes], where: str) -> mujoco.MjModel:
    spec.assets = _assets(files)
    with asking_mujoco("MuJoCo cannot compile this scene:", where):
        return made_of(spec, files, mujoco.MjSpec.compile)


def _assets(files: Mapping[str, bytes]) -> dict[str, bytes]:
    return {name: data for name, data in files.items() if not name.endswith((".toml", ".xml", ".urdf"))}
