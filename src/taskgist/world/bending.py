"""Bending at the hips and crouching: the pelvis is lowered and pitched over feet that stay where they are.

Hips move back, or forward, until the body balances over its feet as it did before: who bends by 60° with straight legs
and hips in place falls over. Legs follow by inverse kinematics, each in the vertical plane that the agent faces along;
what their joints do not allow is no posture.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import multiply, wxyz_from_rotation_vector, yaw_of
from taskgist.world.stage import Stage
from taskgist.world.state import State

ROUNDS = 8
BALANCED_M = 0.003
"""How near the centre of mass comes to where it was, along the direction that the agent faces."""
PARALLEL = 0.9
"""Least cosine between a leg's joint and the lateral axis: legs that are twisted further are not bent (ours)."""
SLACK_RAD = 1e-6


class Leg(NamedTuple):
    """One leg of an agent that stands, in the vertical plane that the agent faces along.

    Lengths are in metres, joints come from hip to ankle. ``signs`` tell whether a joint's angle grows as
    what hangs on it swings back, ``indices`` are into qpos.
    """

    hip: Array
    ankle: Array
    thigh_m: float
    shank_m: float
    angles_rad: tuple[float, float]
    signs: tuple[float, ...]
    indices: tuple[int, ...]
    ranges: tuple[tuple[float, float], ...]


def bent(
    stage: Stage, agent: Agent, start: State, legs: Sequence[Leg], *, lowered_m: float, pitch_rad: float
) -> State | None:
    """An agent that stands, after it has lowered its hips and pitched its pelvis forward.

    Args:
        stage: The scene; it shows another state afterwards.
        agent: The agent; torso, head and arms keep their angles.
        start: How it stands.
        legs: Its legs then (``legs_of``).
        lowered_m: How far the hips are lowered; further, where the legs are too short for the feet to stay.
        pitch_rad: How far the pelvis is pitched forward.

    Returns:
        The state; None for what its legs do not do, or if it has none that bend.
    """
    if not legs:
        return None
    base, yaw = np.array(start.qpos[agent.base]), yaw_of(start.qpos[agent.base][3:])
    ahead, left = np.array([math.cos(yaw), math.sin(yaw), 0.0]), np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    turn = wxyz_from_rotation_vector(pitch_rad * left)
    to_middle = np.array([*np.mean([leg.hip for leg in legs], axis=0)])
    from_root = np.array([base[:3] @ ahead, base[2]]) - to_middle
    balanced, back_m = _center_m(stage.show(start), agent, ahead), 0.0
    for _ in range(ROUNDS):
        hip = np.array([to_middle[0] - back_m, to_middle[1] - lowered_m])
        hip[1] = min(hip[1], *(_highest_m(leg, hip[0] + leg.hip[0] - to_middle[0]) for leg in legs))
        angles: dict[int, float] = {}
        for leg in legs:
            found = _bent_leg(start, leg, hip + _pitched(leg.hip - to_middle, pitch_rad), pitch_rad)
            if found is None:
                return None
            angles |= found
        root = hip + _pitched(from_root, pitch_rad)
        place = base[:3] + (root[0] - base[:3] @ ahead) * ahead
        place[2] = root[1]
        state = start.replace(angles, at=agent.base, to=np.concatenate((place, multiply(turn, base[3:]))))
        off_m = _center_m(stage.show(state), agent, ahead) - balanced
        if abs(off_m) <= BALANCED_M:
            return state if _within(state, legs) else None
        back_m += off_m
    return None


def legs_of(stage: Stage, agent: Agent) -> list[Leg]:
    """The legs of an agent that stands, in the state that the stage shows.

    None if it has none, or if one of their joints does not bend them forward.
    """
    model, names = stage.scene.model, agent.profile.legs
    yaw = yaw_of(stage.state.qpos[agent.base][3:])
    ahead, left = np.array([math.cos(yaw), math.sin(yaw), 0.0]), np.array([-math.sin(yaw), math.cos(yaw), 0.0])
    legs = []
    for triple in zip(names.hips, names.knees, names.ankles, strict=True):
        joints = [int(model.joint(f"{agent.name}/{name}").id) for name in triple]
        screws = [stage.screw(joint) for joint in joints]
        signs = [float(axis @ left) for _, axis in screws]
        if min(map(abs, signs)) < PARALLEL:
            return []
        hip, knee, ankle = (np.array([anchor @ ahead, anchor[2]]) for anchor, _ in screws)
        legs.append(
            Leg(
                hip=hip,
                ankle=ankle,
                thigh_m=float(np.linalg.norm(knee - hip)),
                shank_m=float(np.linalg.norm(ankle - knee)),
                angles_rad=(_swung(knee - hip), _swung(ankle - knee)),
                signs=tuple(math.copysign(1.0, sign) for sign in signs),
                indices=tuple(agent.joints[name] for name in triple),
                ranges=tuple(_range(model, joint) for joint in joints),
            )
        )
    return legs


def _range(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    low, high = (float(limit) for limit in model.jnt_range[joint])
    return (low, high) if model.jnt_limited[joint] else (-math.inf, math.inf)


def _swung(down: Array) -> float:
    """How far a segment that would hang straight down has swung back, radians."""
    return math.atan2(-down[0], -down[1])


def _pitched(arm: Array, pitch_rad: float) -> Array:
    """Something ahead and above of the hips, (2,), after the pelvis was pitched forward."""
    cosine, sine = math.cos(pitch_rad), math.sin(pitch_rad)
    return np.array([cosine * arm[0] + sine * arm[1], cosine * arm[1] - sine * arm[0]])


def _highest_m(leg: Leg, ahead_m: float) -> float:
    """Height at which the stretched leg holds a hip that is so far ahead; the ankle's if it is too far."""
    length, aside = leg.thigh_m + leg.shank_m, ahead_m - leg.ankle[0]
    return float(leg.ankle[1]) + math.sqrt(max(0.0, length**2 - aside**2))


def _bent_leg(state: State, leg: Leg, hip: Array, pitch_rad: float) -> dict[int, float] | None:
    """Angles of a leg's joints by index into qpos, with its hip elsewhere; None if its segments do not meet."""
    down = leg.ankle - hip
    distance = float(np.linalg.norm(down))
    length = leg.thigh_m + leg.shank_m
    if not abs(leg.thigh_m - leg.shank_m) < distance <= length + SLACK_RAD:
        return None
    distance = min(distance, length)
    cosine = (leg.thigh_m**2 + distance**2 - leg.shank_m**2) / (2 * leg.thigh_m * distance)
    thigh = _swung(down) - math.acos(min(1.0, cosine))  # knees bend forward
    knee = hip + leg.thigh_m * np.array([-math.sin(thigh), -math.cos(thigh)])
    shank = _swung(leg.ankle - knee)
    thigh_by, shank_by = thigh - leg.angles_rad[0], shank - leg.angles_rad[1]
    turns = (thigh_by - pitch_rad, shank_by - thigh_by, -shank_by)
    return {
        index: float(state.qpos[index]) + sign * turn
        for index, sign, turn in zip(leg.indices, leg.signs, turns, strict=True)
    }


def _within(state: State, legs: Sequence[Leg]) -> bool:
    """Whether the joints of some legs are within their ranges."""
    return all(
        low - SLACK_RAD <= state.qpos[index] <= high + SLACK_RAD
        for leg in legs
        for index, (low, high) in zip(leg.indices, leg.ranges, strict=True)
    )


def _center_m(stage: Stage, agent: Agent, ahead: Array) -> float:
    """How far ahead in the world the agent's centre of mass is, metres."""
    return float(stage.center_of_mass(agent.bodies) @ ahead)
