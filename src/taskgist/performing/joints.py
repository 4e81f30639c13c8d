"""Joints in an audit: within their limits, no faster than they may be, and still where nobody moves them.

Who performs, or takes, moves by plan. Everybody else stays as it is, but for the head: onlookers look. So do doors and
drawers of the room. What follows another joint (URDF's mimic) is where that one has it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.performing.findings import Finding, Kind, MotionLimits, Tolerances
from taskgist.performing.penetrations import FREE, STILL, Motion
from taskgist.world import Scene
from taskgist.world.bodies.agent import couplings, subtree

SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


def joints(
    motion: Motion, steps: Array, times_s: Array, performers: Mapping[str, MotionLimits], tolerances: Tolerances
) -> Iterator[Finding]:
    """Joints beyond their limits, and joints and bases that move too fast, by steps (n − 1, nv) from frame to frame."""
    model = motion.model
    durations = np.diff(times_s)[:, None]
    speeds = steps / durations
    # At rest before and after: of speeds between frames, the differences take as long as from middle to middle.
    resting = np.zeros((1, model.nv))
    around = np.concatenate((durations[:1], durations, durations[-1:]))
    changes = np.diff(np.concatenate((resting, speeds, resting)), axis=0) / ((around[1:] + around[:-1]) / 2)
    following = {each.follower: each for each in couplings(model)}
    for name in motion.scene.agents:
        limits = performers.get(name, MotionLimits())
        for joint in _joints_of(motion.scene, name):
            unit, positions = UNITS.get(int(model.jnt_type[joint])), motion.qpos[:, model.jnt_qposadr[joint]]
            if not unit or (name not in performers and np.ptp(positions) <= STILL):
                continue
            if joint in following:
                leader = motion.qpos[:, model.jnt_qposadr[following[joint].leader]]
                off = np.abs(positions - following[joint].led(model, leader))
                if _carries_shapes(model, joint):
                    yield from _beyond("coupling", _label(model, joint), times_s, off, tolerances.limit, unit)
            elif model.jnt_limited[joint]:
                low, high = model.jnt_range[joint]
                beyond = np.maximum(low - positions, positions - high)
                yield from _beyond("joint limit", _label(model, joint), times_s, beyond, tolerances.limit, unit)
        for dof, label, unit, speed, acceleration in _dofs(motion.scene, name, limits):
            jump = tolerances.jump_m_s if unit == "m" else tolerances.jump_rad_s
            jumps = np.abs(speeds[:, dof]) > jump
            moved = np.where(jumps, np.abs(steps[:, dof]), 0.0)
            yield from _beyond("jump", label, times_s, moved, 0.0, unit)
            rates = np.where(jumps, 0.0, np.abs(speeds[:, dof]))
            yield from _beyond("speed", label, times_s, rates, speed, f"{unit}/s", 1 + tolerances.rate)
            rates = np.abs(changes[:, dof])
            yield from _beyond("acceleration", label, times_s, rates, acceleration, f"{unit}/s²", 1 + tolerances.rate)


UNITS = {int(mujoco.mjtJoint.mjJNT_HINGE): "rad", int(mujoco.mjtJoint.mjJNT_SLIDE): "m"}
"""Units of joints with one degree of freedom."""


def _carries_shapes(model: mujoco.MjModel, joint: int) -> bool:
    """Whether a joint moves anything: the PR2's model has followers of its fingers that carry nothing."""
    return bool(model.body_geomnum[subtree(model, int(model.jnt_bodyid[joint]))].any())


def strays(
    motion: Motion, times_s: Array, performers: Mapping[str, MotionLimits], tolerances: Tolerances
) -> Iterator[Finding]:
    """What moves that nobody moves: joints of the room, and agents that do nothing, but for the heads of onlookers."""
    scene, model = motion.scene, motion.model
    mine = {*performers, *scene.objects}
    moved = np.zeros((len(times_s), model.nv))
    for row, qpos in zip(moved, motion.qpos, strict=True):
        mujoco.mj_differentiatePos(model, row, 1.0, motion.qpos[0], qpos)
    for dof in np.flatnonzero(np.abs(moved).max(axis=0) > tolerances.limit).tolist():
        joint, owner = int(model.dof_jntid[dof]), _owner(scene, int(model.dof_bodyid[dof]))
        if owner in mine or (owner in scene.agents and _label(model, joint) in _heads(scene, owner)):
            continue
        free = int(model.jnt_type[joint]) == FREE
        label = f"{owner}'s base" if free and owner in scene.agents else _label(model, joint)
        slides = int(model.jnt_type[joint]) == SLIDE or (free and dof - int(model.jnt_dofadr[joint]) < 3)
        unit = "m" if slides else "rad"
        yield from _beyond("stray", label, times_s, np.abs(moved[:, dof]), tolerances.limit, unit)


def _owner(scene: Scene, body: int) -> str:
    """The agent or object of which a body is a part; empty if it is one of the room's."""
    agents = (name for name in scene.agents if body in scene.agent(name).bodies)
    things = (name for name in scene.objects if body in subtree(scene.model, scene.object_body(name)))
    return next(chain(agents, things), "")


def _heads(scene: Scene, name: str) -> set[str]:
    """The joints by which an agent looks at something."""
    profile = scene.agent(name).profile
    return {f"{name}/{axis.joint}" for axis in (profile.pan, profile.tilt) if axis is not None}


def _joints_of(scene: Scene, name: str) -> list[int]:
    return np.flatnonzero(np.isin(scene.model.jnt_bodyid, scene.agent(name).bodies)).tolist()


def _label(model: mujoco.MjModel, joint: int) -> str:
    return str(model.joint(joint).name)


def _dofs(scene: Scene, name: str, limits: MotionLimits) -> Iterator[tuple[int, str, str, float, float]]:
    """Each degree of freedom of an agent: its index, name and unit, its highest speed and acceleration."""
    model = scene.model
    for joint in _joints_of(scene, name):
        dof, label, unit = int(model.jnt_dofadr[joint]), _label(model, joint), UNITS.get(int(model.jnt_type[joint]))
        if unit:
            short = label.removeprefix(f"{name}/")
            yield dof, label, unit, limits.speeds.get(short, np.inf), limits.accelerations.get(short, np.inf)
        else:
            for axis in range(3):
                yield dof + axis, f"{name}'s base", "m", limits.base_m_s, limits.base_m_s2
                yield dof + 3 + axis, f"{name}'s base", "rad", limits.base_rad_s, limits.base_rad_s2


def _beyond(
    kind: Kind, what: str, times_s: Array, amounts: Array, allowed: float, unit: str, slack: float = 1.0
) -> Iterator[Finding]:
    """A finding for each frame in which an amount is more than allowed."""
    for frame in np.flatnonzero(amounts > allowed * slack).tolist():
        yield Finding(kind, what, None, frame, float(times_s[frame]), float(amounts[frame]), allowed, unit)
