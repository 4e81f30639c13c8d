"""What a profile leaves out and its model knows: ranges of joints, lengths of arms."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from taskgist.world.body.profile import DERIVED_M, AgentProfile, Arm, Axis

FULL_TURN_RAD = (-math.pi, math.pi)
"""Range of a joint that turns without end, where a profile gives none."""


def completed(model: mujoco.MjModel, agent: str, profile: AgentProfile) -> AgentProfile:
    """The profile with no gaps: ranges that no joint exceeds, and a length for every arm.

    Args:
        model: The compiled scene.
        agent: Name of the agent, under which its names stand in the model.
        profile: As its document gives it.
    """
    axes = {name: getattr(profile, name) for name in ("pan", "tilt", "turn", "lean")}
    return replace(
        profile,
        **{name: axis and replace(axis, range_rad=range_of(model, agent, axis)) for name, axis in axes.items()},
        arms=tuple(_with_length(model, agent, arm) for arm in profile.arms),
    )


def range_of(model: mujoco.MjModel, agent: str, axis: Axis) -> tuple[float, float]:
    """What the profile allows and the joint can do, radians."""
    joint = model.joint(f"{agent}/{axis.joint}")
    low, high = (float(limit) for limit in joint.range) if joint.limited[0] else FULL_TURN_RAD
    if not joint.limited[0] and all(map(math.isfinite, axis.range_rad)):
        return axis.range_rad
    return max(low, axis.range_rad[0]), min(high, axis.range_rad[1])


def _with_length(model: mujoco.MjModel, agent: str, arm: Arm) -> Arm:
    return arm if arm.length_m != DERIVED_M else replace(arm, length_m=stretched_m(model, agent, arm))


def stretched_m(model: mujoco.MjModel, agent: str, arm: Arm) -> float:
    """The arm stretched out: how far its palm gets from its shoulder within the ranges of its joints, metres.

    One joint after the other is put where the distance is greatest, until nothing changes much; from two
    configurations, so that an arm which begins folded does not stay so.
    """
    shoulder, palm = (
        site_index(model, agent, f"{arm.side}_{name}_frame", frame.name)
        for name, frame in (("shoulder", arm.shoulder), ("palm", arm.palm))
    )
    joints = _joints_between(model, int(model.site_bodyid[palm]), int(model.body(f"{agent}/{arm.root}").id))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    start = data.site_xpos[shoulder].copy()

    def squared(joint: int, value: float) -> float:
        data.qpos[model.jnt_qposadr[joint]] = value
        mujoco.mj_kinematics(model, data)
        return float(np.sum((data.site_xpos[palm] - start) ** 2))

    found = 0.0
    for share in (0.5, 0.3):
        for joint in joints:
            data.qpos[model.jnt_qposadr[joint]] = float(np.dot((1 - share, share), _limits(model, joint)))
        for joint in (*joints, *joints, *joints):
            found = max(found, _best(model, joint, squared))
    return math.sqrt(found)


def _joints_between(model: mujoco.MjModel, body: int, root: int) -> list[int]:
    """Joints from an arm's root to a body that it carries, the farthest first."""
    joints: list[int] = []
    while True:
        joints += range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        if body in (root, 0):
            return joints
        body = int(model.body_parentid[body])


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    low, high = (float(limit) for limit in model.jnt_range[joint])
    return (low, high) if model.jnt_limited[joint] else FULL_TURN_RAD


def _best(model: mujoco.MjModel, joint: int, squared: Callable[[int, float], float]) -> float:
    """Puts a joint where the squared distance is greatest, which it gives.

    About a hinge, the squared distance of two points is a + b cos q + c sin q: three values tell where it is greatest.
    """
    candidates = list(_limits(model, joint))
    if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_HINGE):
        at_0, at_90, at_180 = (squared(joint, angle) for angle in (0.0, math.pi / 2, math.pi))
        middle = (at_0 + at_180) / 2
        top = math.atan2(at_90 - middle, at_0 - middle)
        low, high = candidates
        candidates += [angle for angle in (top - 2 * math.pi, top, top + 2 * math.pi) if low <= angle <= high]
    best = max(candidates, key=lambda value: squared(joint, value))
    return squared(joint, best)


def site_index(model: mujoco.MjModel, agent: str, label: str, name: str) -> int:
    """Index of a frame's site: the one that was added for it, else the model's own of that name."""
    added = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{agent}/{label}"))
    return added if added >= 0 else int(model.site(f"{agent}/{name}").id)
