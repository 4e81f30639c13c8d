"""Aiming the head: analytic, joint by joint.

Each joint of the head turns by the signed angle, about its own axis, between where the eye looks and where the target
is. Turning moves the eye as well, so this is done twice; what remains is below a degree for anything farther than an
arm. No convention about zero angles or signs of a robot's neck is needed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.virtual_actions import PAN, TILT
from taskgist.world import Agent, Stage, State

Array = NDArray[np.float64]
ROUNDS = 2


def head_joints(agent: Agent, actions: frozenset[str]) -> dict[str, tuple[int, tuple[float, float]]]:
    """Index into qpos and range in radians of the head's joints, by the virtual action that moves them."""
    axes = {PAN: agent.profile.pan, TILT: agent.profile.tilt}
    return {
        action: (agent.joints[axis.joint], axis.range_rad)
        for action, axis in axes.items()
        if axis and action in actions
    }


def aimed(stage: Stage, agent: Agent, state: State, target: Array, actions: frozenset[str]) -> dict[int, float]:
    """Head angles with which the eye looks at a target, as nearly as the joints' ranges allow.

    Args:
        stage: The scene; shows some other state afterwards.
        agent: The agent.
        state: From where; the current angles are always allowed.
        target: Point in the world, metres, (3,).
        actions: Virtual actions that may be used.

    Returns:
        Angles in radians by index into qpos.
    """
    joints = head_joints(agent, actions)
    names = {PAN: agent.profile.pan, TILT: agent.profile.tilt}
    angles = {index: float(state.qpos[index]) for index, _ in joints.values()}
    for _ in range(ROUNDS):
        for action, (index, range_rad) in joints.items():
            axis = names[action]
            assert axis is not None
            stage.show(state.replace(angles))
            eye = stage.eye(agent)
            turn = _angle_about(stage.joint_axis(agent, axis.joint), eye.matrix[:, 0], target - eye.position)
            angles[index] = clamped(angles[index] + turn, range_rad, float(state.qpos[index]))
    return angles


def on_the_way(state: State, angles: Mapping[int, float], steps: int) -> list[dict[int, float]]:
    """Angles at equal steps from a state's to the given ones, these last."""
    return [
        {index: _between(float(state.qpos[index]), angle, step / steps) for index, angle in angles.items()}
        for step in range(1, steps + 1)
    ]


def clamped(angle_rad: float, range_rad: tuple[float, float], current_rad: float) -> float:
    """The angle within a range that the current angle widens if it lies outside."""
    low, high = min(range_rad[0], current_rad), max(range_rad[1], current_rad)
    return min(max(angle_rad, low), high)


def _between(start: float, end: float, share: float) -> float:
    return start + (end - start) * share


def _angle_about(axis: Array, start: Array, end: Array) -> float:
    """Signed angle about a unit axis that turns one direction towards another; vectors (3,)."""
    ax, ay, az = axis.tolist()
    sx, sy, sz = start.tolist()
    ex, ey, ez = end.tolist()
    across = ax * (sy * ez - sz * ey) + ay * (sz * ex - sx * ez) + az * (sx * ey - sy * ex)
    along = (sx * ex + sy * ey + sz * ez) - (ax * sx + ay * sy + az * sz) * (ax * ex + ay * ey + az * ez)
    return math.atan2(across, along)
