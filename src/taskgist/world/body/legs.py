"""Legs: the angles with which a body's soles stand on the floor while its hips are at a height."""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.body.agent import Agent
from taskgist.world.geometry.shapes import lowest_point


def legs_for(model: mujoco.MjModel, agent: Agent, *, hip_height_m: float) -> tuple[dict[str, float], float]:
    """Leg angles with which the soles stand on the floor while the hips are at a height.

    The shanks stay upright; thighs are as inclined as the height asks for.

    Args:
        model: The compiled scene.
        agent: The agent.
        hip_height_m: Wanted height of the hips over the floor; at or above standing height the legs are straight.

    Returns:
        Joint angles in radians by name, and the height of the root in metres that results; for a body without legs,
        none and the height at which its model puts the root.
    """
    legs = agent.profile.legs
    if not legs.feet:
        return {}, float(model.body_pos[agent.root_body][2])
    thigh, lower = leg_lengths_m(model, agent)
    drop = np.clip((hip_height_m - lower) / thigh, -1.0, 1.0)
    flexion = math.acos(drop)
    angles = dict.fromkeys(legs.hips, flexion) | dict.fromkeys(legs.knees, flexion) | dict.fromkeys(legs.ankles, 0.0)
    return angles, float(lower + thigh * drop)


def leg_lengths_m(model: mujoco.MjModel, agent: Agent) -> tuple[float, float]:
    """Lengths in metres of the thigh, and of shank and foot together (knee to sole)."""
    foot = body_index(model, agent, agent.profile.legs.feet[0])
    shank = int(model.body_parentid[foot])
    soles = [-(model.geom_pos[g][2] - model.geom_size[g][2]) for g in agent.geoms if int(model.geom_bodyid[g]) == foot]
    thigh_m = float(np.linalg.norm(model.body_pos[shank]))
    return thigh_m, float(np.linalg.norm(model.body_pos[foot])) + float(max(soles))


def ankle_height_m(model: mujoco.MjModel, agent: Agent) -> float:
    """Height in metres of the ankles over the soles."""
    foot = body_index(model, agent, agent.profile.legs.feet[0])
    return leg_lengths_m(model, agent)[1] - float(np.linalg.norm(model.body_pos[foot]))


def standing_height_m(model: mujoco.MjModel, agent: Agent, qpos: NDArray[np.float64]) -> float:
    """Height in metres of the root at which the agent's lowest shape touches the floor.

    Args:
        model: The compiled scene.
        agent: The agent.
        qpos: Its joints as they are; where its base is does not matter, (nq,).
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qpos[agent.base] = (0, 0, 0, 1, 0, 0, 0)
    mujoco.mj_kinematics(model, data)
    matrices = data.geom_xmat.reshape(-1, 3, 3)
    lowest = [(geom, lowest_point(model, int(geom), matrices[geom])) for geom in agent.geoms]
    heights = [data.geom_xpos[geom][2] + matrices[geom][2] @ point for geom, point in lowest if point is not None]
    return -float(min(heights, default=0.0))


def body_index(model: mujoco.MjModel, agent: Agent, name: str) -> int:
    """Index of one of the agent's bodies by its name without prefix."""
    return int(model.body(f"{agent.name}/{name}").id)
