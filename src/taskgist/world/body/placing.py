"""Placing agents: from a scene file's words to the first state of the scene."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mujoco
import numpy as np

from taskgist.errors import SceneError, UnknownNameError
from taskgist.world.body.agent import SEEN_MASK, Agent
from taskgist.world.body.legs import legs_for, standing_height_m
from taskgist.world.geometry.rotations import about_z
from taskgist.world.scene_file import AgentEntry, SceneFile
from taskgist.world.state import State

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
        joints = _rest(model, agent) | legs | _given(model, entry, agent, file.where)
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
    for given, kind, field, scale, moves, unit in (turns, slides):
        place = f"agents.{entry.name}.{field}"
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
