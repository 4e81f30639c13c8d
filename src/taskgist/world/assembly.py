"""Assembly: room, objects and agents become one MuJoCo model, and everybody is put in place."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices
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
from taskgist.world.bodies.eyes import add_frame
from taskgist.world.bodies.from_model import completed_by_model
from taskgist.world.bodies.hands import add_ghosts
from taskgist.world.bodies.human import HumanSize
from taskgist.world.bodies.markup import asking_mujoco
from taskgist.world.bodies.mending import give_least_mass, has_mass
from taskgist.world.bodies.model_files import BUILDERS, add_body, builtin_models, name_problems
from taskgist.world.bodies.profile import (
    AgentProfile,
    builtin_profile_text,
    builtin_profiles,
    parse_profile,
)
from taskgist.world.bodies.urdf import COLLISION_GROUP
from taskgist.world.composing import Composed, assets, check_free_name, compiled, compose, read_spec
from taskgist.world.gathering import STATURE
from taskgist.world.geometry.convex import decompose
from taskgist.world.geometry.distances import bound_all_shapes
from taskgist.world.geometry.transforms import Pose, about_z, wxyz_from_matrix
from taskgist.world.scene_file import AgentEntry, SceneFile
from taskgist.world.seen import hide_stand_ins, show_groups
from taskgist.world.state import State

DEFAULT_STATURE_M = 1.75

# --- Placing agents: from a scene file's words to the first state of the scene.

ABOVE_SEATS_M = 1.2
"""Height from which a seat is searched downwards."""


def placed(model: mujoco.MjModel, agents: Mapping[str, Agent], file: SceneFile, composed: Composed) -> State:
    """The state in which every agent is where the file says: on the floor, or on the seat that is found there.

    Who is a body of the room's model, and is not put elsewhere, stands where it has that body.

    Raises:
        SceneError: There is no seat, or a joint does not go there.
        UnknownNameError: There is no such joint.
    """
    data = mujoco.MjData(model)
    data.qpos[:] = composed.start(model)
    for agent in agents.values():
        data.qpos[agent.base] = (0, 0, -1000, 1, 0, 0, 0)  # out of the way of the search for seats
    mujoco.mj_kinematics(model, data)
    qpos = np.array(data.qpos)
    for entry in file.agents:
        agent, standing = agents[entry.name], composed.standing.get(entry.name)
        place, wxyz = _heading(entry, standing)
        legs, height = _stance(model, data, agent, entry, place, file.where)
        given = _given(model, entry, agent, file.where)
        joints = _rest(model, agent) | legs | given
        joints |= _following(model, agent, given)
        for joint, value in joints.items():
            qpos[agent.joints[joint]] = value
        if not agent.profile.legs.feet:
            height = standing_height_m(model, agent, qpos) if standing is None else float(standing.position[2])
        qpos[agent.base] = (*place, height, *wxyz)
    return State(qpos)


def _heading(entry: AgentEntry, standing: Pose | None) -> tuple[Array, Array]:
    """Floor point (2,) and wxyz of an agent's root."""
    place, wxyz = np.zeros(2), about_z(entry.yaw_rad or 0.0)
    if standing is not None and entry.yaw_rad is None:
        wxyz = wxyz_from_matrix(standing.matrix)
    if entry.position_m is not None:
        place = np.array(entry.position_m)
    elif standing is not None:
        place = standing.position[:2]
    return place, wxyz


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
    model: mujoco.MjModel, data: mujoco.MjData, agent: Agent, entry: AgentEntry, place: Array, where: str
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
    seat = entry.seat_height_m if entry.seat_height_m is not None else _seat_height(model, data, entry, place, where)
    return legs_for(model, agent, hip_height_m=seat + agent.profile.legs.seat_share * agent.stature_m)


def _seat_height(model: mujoco.MjModel, data: mujoco.MjData, entry: AgentEntry, place: Array, where: str) -> float:
    top = np.array([*place, ABOVE_SEATS_M])
    distance = mujoco.mj_ray(model, data, top, np.array([0.0, 0.0, -1.0]), SEEN_MASK, True, -1, np.zeros(1, np.int32))
    height = ABOVE_SEATS_M - distance
    if distance < 0 or height < 0.2:
        raise SceneError(
            "nothing to sit on there",
            where=where,
            field=f"agents.{entry.name}.position_m",
            value=tuple(float(value) for value in place),
            hint="move the agent over a seat, or give seat_height_m",
        )
    return float(height)


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
    composed, files, profiles = _put_together(file, bundle, limits)
    model = compiled(composed.room, files, file.where)
    _check_objects(model, file, limits)
    bound_all_shapes(model)
    agents = {
        entry.name: resolve_agent(model, entry.name, profiles[entry.name], _stature(entry)) for entry in file.agents
    }
    return Assembled(model, agents, placed(model, agents, file, composed), files)


def as_mjcf(
    file: SceneFile, bundle: Mapping[str, bytes], *, limits: Limits = DEFAULT.limits
) -> tuple[str, dict[str, bytes]]:
    """The model that ``assemble`` compiles as text, and the meshes and images that it names, by their names there.

    Raises:
        SceneError: As ``assemble``.
    """
    composed, files, _ = _put_together(file, bundle, limits)
    compiled(composed.room, files, file.where)
    with asking_mujoco("MuJoCo cannot write this scene:", file.where):
        text = str(composed.room.to_xml())
    named = {name: re.search(rf'"((?:[^"]*/)?{re.escape(name)})"', text) for name in files}
    return text, {found[1]: files[name] for name, found in named.items() if found}


def _put_together(
    file: SceneFile, bundle: Mapping[str, bytes], limits: Limits
) -> tuple[Composed, dict[str, bytes], dict[str, AgentProfile]]:
    """Room, objects and agents as one specification; every file that makes it; and the agents' profiles."""
    files = dict(bundle)
    _check_bytes(files, file.where, limits)
    composed = compose(file, files, limits)
    room = composed.room
    profiles = {entry.name: _profile(entry, files, file.where, limits) for entry in file.agents}
    for entry in file.agents:
        check_free_name(room, entry.name, file.where, f"agents.{entry.name}")
    if file.seen_groups is None:
        hide_stand_ins(room, lambda: compiled(room, files, file.where))
    else:
        show_groups(room, file.seen_groups)

    def compiled_room(spec: mujoco.MjSpec) -> mujoco.MjModel:
        model = compiled(spec, files, file.where)
        _check_objects(model, file, limits)
        return model

    decompose(room, compiled_room, files, file.where, limits)
    for entry in file.agents:
        body, profiles[entry.name] = _agent_spec(profiles[entry.name], files, entry, file.where, limits)
        room.assets = body.assets = assets(files)  # MuJoCo warns if only one of them has any
        with asking_mujoco(f"MuJoCo cannot put {entry.name!r} into this scene:", file.where):
            room.attach(body, prefix=f"{entry.name}/", frame=room.worldbody.add_frame())
    return composed, files, profiles


def _check_bytes(files: Mapping[str, bytes], where: str, limits: Limits) -> None:
    together = sum(map(len, files.values()))
    if together > limits.bundle_bytes:
        hint = most_read(limits.bundle_bytes, "bundle_bytes")
        raise SceneError("the files of this scene are too large", where=where, value=f"{together:,} bytes", hint=hint)


def _check_objects(model: mujoco.MjModel, file: SceneFile, limits: Limits) -> None:
    """Refuse objects that no hand deals with: their surfaces are sampled by the centimetre, shape by shape."""
    agents = {entry.name for entry in file.agents}
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for name, body in free_bodies(model, agents).items():
        if not file.takes(name):
            continue
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, subtree(model, body)))
        if len(geoms) > limits.body_shapes:
            hint = f"give it a mesh: {most_read(limits.body_shapes, 'body_shapes')}"
            problem, field = f"{name!r} has too many shapes", file.field_of_model(name)
            raise SceneError(problem, where=file.where, field=field, value=len(geoms), hint=hint)
        extent_m = _extent_m(model, data, body, geoms)
        if not extent_m <= limits.object_extent_m:
            hint = (
                'in millimetres? lengths are in metres: divide sizes by 1000, and give meshes scale="0.001 0.001 0.001"'
                f" (at most {limits.object_extent_m:g} m: setting limits.object_extent_m)"
            )
            problem = f"the box around {name!r} is {extent_m:,.0f} m long"
            raise SceneError(problem, where=file.where, field=file.field_of_model(name), hint=hint)


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


def _agent_spec(
    profile: AgentProfile, files: dict[str, bytes], entry: AgentEntry, where: str, limits: Limits
) -> tuple[mujoco.MjSpec, AgentProfile]:
    """An agent's model with all that reasoning needs: a base that is free to move, frames, and shapes of grasps.

    Beside it, its profile with what that leaves to the model.
    """
    spec = read_spec(files, entry.model_key, where, agent=True, limits=limits)
    if len(spec.geoms) > limits.body_shapes:
        hint = f"leave out what is only shown: {most_read(limits.body_shapes, 'body_shapes')}"
        field = f"{entry.name}: {entry.model_key}"
        raise SceneError("a body of too many shapes", where=where, field=field, value=len(spec.geoms), hint=hint)
    spec.compiler.balanceinertia = True  # MJCF text of a URDF has lost that; published inertias are often impossible
    hide_stand_ins(spec, lambda: compiled(spec, files, where))
    for problem in name_problems(spec, profile, f"{where}: {entry.profile_key}"):
        raise problem
    at = f"{where}: {entry.profile_key}"
    profile = completed_by_model(profile, spec, lambda: compiled(spec, files, where), at)
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
    return spec, profile
