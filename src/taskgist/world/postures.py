"""Postures: sitting and standing, over feet that stay where they are.

Standing up moves the pelvis over the feet, by about a thigh forward; sitting down is the reverse, onto something.
Both give a new state of one agent and leave everything else alone; whether there is room is for ``perspective`` to
judge.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.bodies.agent import Agent, ankle_height_m, body_index, leg_lengths_m, legs_for
from taskgist.world.bodies.profile import Posture
from taskgist.world.geometry.transforms import about_z, yaw_of
from taskgist.world.stage import Stage
from taskgist.world.state import State


def posture_of(stage: Stage, agent: Agent, settings: Contact) -> Posture | None:
    """Sitting or standing, from the inclination of the thighs; None if the legs were not tracked (5.2.1)."""
    if not stage.state.known([f"{agent.name}/legs", agent.name]):
        return None
    if not agent.thigh_bodies:
        return "standing"
    down = np.mean([-stage.body_axis(body, 2) for body in agent.thigh_bodies], axis=0)
    inclination = math.acos(float(np.clip(-down[2] / np.linalg.norm(down), -1.0, 1.0)))
    return "sitting" if inclination > settings.sitting_thigh_rad else "standing"


def with_posture(stage: Stage, agent: Agent, posture: Posture, *, seat_height_m: float | None = None) -> State:
    """The state in which the agent has taken the other posture over its feet.

    Args:
        stage: The scene in its present state.
        agent: The agent; its torso, head and arms keep their angles.
        posture: The posture to take.
        seat_height_m: Height of what it sits down onto.
    """
    model, state = stage.scene.model, stage.state
    floor = floor_height_m(stage, agent)
    hip_height = math.inf
    if posture == "sitting":
        assert seat_height_m is not None
        hip_height = seat_height_m - floor + agent.profile.legs.seat_share * agent.stature_m
    angles, height = legs_for(model, agent, hip_height_m=hip_height)
    feet = np.mean([stage.body_position(body_index(model, agent, foot)) for foot in agent.profile.legs.feet], axis=0)
    yaw = yaw_of(state.qpos[agent.base][3:])
    thigh, _ = leg_lengths_m(model, agent)
    back = thigh * math.sin(angles[agent.profile.legs.hips[0]])
    place = feet[:2] - back * np.array([math.cos(yaw), math.sin(yaw)])
    upright = state.replace({agent.joints[joint]: angle for joint, angle in angles.items()})
    return upright.replace(at=agent.base, to=(*place, floor + height, *about_z(yaw)))


def floor_height_m(stage: Stage, agent: Agent) -> float:
    """Height in metres of what the lower foot stands on."""
    model = stage.scene.model
    ankles = [stage.body_position(body_index(model, agent, foot))[2] for foot in agent.profile.legs.feet]
    return float(min(ankles)) - ankle_height_m(model, agent)


def seat_position(stage: Stage, agent: Agent) -> NDArray[np.float64]:
    """Floor point (2,) over which the pelvis would be if the agent sat down with level thighs and kept its feet."""
    model = stage.scene.model
    feet = np.mean([stage.body_position(body_index(model, agent, foot)) for foot in agent.profile.legs.feet], axis=0)
    yaw = yaw_of(stage.state.qpos[agent.base][3:])
    thigh, _ = leg_lengths_m(model, agent)
    return np.asarray(feet[:2] - thigh * np.array([math.cos(yaw), math.sin(yaw)]))
