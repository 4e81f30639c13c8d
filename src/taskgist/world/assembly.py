"""Assembly: room, objects and agents become one MuJoCo model, with everybody in place."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.agent import GHOST_GROUP, GHOST_SHAPES, SEEN_MASK, Agent, resolve_agent
from taskgist.world.anthropometry import HumanSize
from taskgist.world.human import human_mjcf
from taskgist.world.legs import legs_for
from taskgist.world.profile import AgentProfile, builtin_profile_text, parse_profile
from taskgist.world.rotations import about_z
from taskgist.world.scene_file import DEFAULT_STATURE_M, STATURE, AgentEntry, SceneFile
from taskgist.world.state import State

mujoco.set_mju_user_warning(logging.getLogger("taskgist.world").warning)  # otherwise MuJoCo writes a file of its own

BUILDERS: dict[str, Callable[[HumanSize], str]] = {"human": human_mjcf}
"""Models that are made to measure, by the name under which a profile asks for them."""

ABOVE_SEATS_M = 1.2
"""Height from which a seat is searched downwards."""


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
    room = _spec(files, file.model, file.where)
    _check_names(file, room)
    for entry in file.agents:
        body = _agent_spec(profiles[entry.name], files, entry)
        room.attach(body, prefix=f"{entry.name}/", frame=room.worldbody.add_frame())
    model = _compile(room, files, file.where)
    agents = {
        entry.name: resolve_agent(model, entry.name, profiles[entry.name], _stature(entry)) for entry in file.agents
    }
    initial = _place(model, agents, file)
    return Assembled(model, agents, initial, files)


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
    profile = parse_profile(files[entry.profile_key], where=f"{where}: {entry.profile_key}", stature_m=_stature(entry))
    if entry.model_key not in files:
        if profile.model not in BUILDERS:
            raise UnknownNameError("model", profile.model, BUILDERS, where=f"{where}: {entry.profile_key}")
        files[entry.model_key] = BUILDERS[profile.model](_size(entry, where)).encode()
    return profile


def _size(entry: AgentEntry, where: str) -> HumanSize:
    measured = {key: value for key, value in entry.body.items() if key != STATURE}
    try:
        return HumanSize.from_stature(_stature(entry), **measured)
    except SceneError as error:
        error.where, error.field = where, f"agents.{entry.name}.body.{error.field}"
        raise


def _spec(files: Mapping[str, bytes], name: str, where: str) -> mujoco.MjSpec:
    if name not in files:
        raise SceneError("no such file", where=where, field="scene.model", value=name)
    try:
        return mujoco.MjSpec.from_string(files[name].decode("utf-8"))
    except (ValueError, UnicodeDecodeError) as error:
        raise SceneError(f"MuJoCo cannot read this model: {error}", where=f"{where}: {name}") from error


def _agent_spec(profile: AgentProfile, files: Mapping[str, bytes], entry: AgentEntry) -> mujoco.MjSpec:
    spec = _spec(files, entry.model_key, entry.name)
    if profile.hand is None:
        return spec
    hand = profile.hand
    breadth, thickness = hand.palm_m
    finger = (hand.finger_length_m / 2, hand.finger_thickness_m / 2, breadth / 2)
    sizes = {"palm": (thickness / 2, hand.opening_m / 2, breadth / 2), "fingers": finger, "thumb": finger}
    for arm in profile.arms:
        body = spec.body(arm.hand)
        if body is None:
            raise SceneError("no such body", where=entry.name, field="arms.hand", value=arm.hand)
        for shape in GHOST_SHAPES:
            body.add_geom(
                name=f"{arm.side}_grasp_{shape}",
                type=mujoco.mjtGeom.mjGEOM_BOX,
                size=sizes[shape],
                group=GHOST_GROUP,
                contype=0,
                conaffinity=0,
                mass=0,
                rgba=(1, 0, 1, 0),
            )
    return spec


def _compile(spec: mujoco.MjSpec, files: Mapping[str, bytes], where: str) -> mujoco.MjModel:
    spec.assets = {name: data for name, data in files.items() if not name.endswith((".toml", ".xml"))}
    try:
        return spec.compile()
    except ValueError as error:
        raise SceneError(f"MuJoCo cannot compile this scene: {error}", where=where) from error


def _place(model: mujoco.MjModel, agents: Mapping[str, Agent], file: SceneFile) -> State:
    """Put every agent where the file says: on the floor, or on the seat that is found there."""
    data = mujoco.MjData(model)
    for agent in agents.values():
        data.qpos[agent.base] = (0, 0, -1000, 1, 0, 0, 0)  # out of the way of the search for seats
    mujoco.mj_kinematics(model, data)
    qpos = np.array(data.qpos)
    for entry in file.agents:
        agent = agents[entry.name]
        legs, height = _stance(model, data, agent, entry, file.where)
        qpos[agent.base] = (*entry.position_m, height, *about_z(entry.yaw_rad))
        for joint, angle in (legs | _joints(model, entry, agent, file.where)).items():
            qpos[agent.joints[joint]] = angle
    return State(qpos)


def _joints(model: mujoco.MjModel, entry: AgentEntry, agent: Agent, where: str) -> dict[str, float]:
    field = f"agents.{entry.name}.joints_deg"
    for joint, angle in entry.joints_rad.items():
        if joint not in agent.joints:
            raise UnknownNameError("joint", joint, agent.joints, where=f"{where}: {field}")
        limits = model.joint(f"{agent.name}/{joint}")
        low, high = (math.degrees(limit) for limit in limits.range)
        if limits.limited[0] and not low - 1e-6 <= math.degrees(angle) <= high + 1e-6:
            hint, given = f"it turns from {low:.0f} to {high:.0f} degrees", round(math.degrees(angle), 3)
            raise SceneError("beyond the joint", where=where, field=f"{field}.{joint}", value=given, hint=hint)
    return dict(entry.joints_rad)


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
