"""Linkage: where a few joints of an agent, and a move of its base, bring eye and shoulders, for many angles at once.

Turning a joint moves all that hangs on it as one rigid body: about the joint's axis (or along it, for a slide). So a
frame's new place is its present one, moved by each joint that carries it, the outermost first, and by the base last
(the product of exponentials [Brockett 1984]). This is MuJoCo's own kinematics for thousands of states of a handful of
frames; it needs no other state to be shown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)
POSE = 12
"""Numbers of a pose as a row: position, then matrix row by row."""


@dataclass(frozen=True, eq=False)
class Linkage:
    """Joints and frames of an agent, as they are in one state.

    Attributes:
        joints: Index into qpos of each joint, from the base outwards, (j,).
        anchors: A point on each joint's axis, metres, (j, 3).
        axes: Unit directions of the axes, (j, 3).
        slides: Whether a joint slides along its axis instead of turning about it, (j,).
        positions: Where the frames are, metres, (f, 3).
        matrices: How they are turned, (f, 3, 3).
        carried: Whether each joint carries each frame, (j, f).
        base: Where the agent's base is, metres, (3,).
    """

    joints: Indices
    anchors: Array
    axes: Array
    slides: Mask
    positions: Array
    matrices: Array
    carried: Mask
    base: Array

    @classmethod
    def of(cls, stage: Stage, agent: Agent, joints: tuple[str, ...], frames: tuple[tuple[int, Pose], ...]) -> Linkage:
        """The linkage in the state that a stage shows.

        Args:
            stage: The scene in a state.
            agent: The agent.
            joints: Names of joints.
            frames: Frames as the bodies that they are fixed to, and their poses.
        """
        model = stage.scene.model
        indices = sorted(int(model.joint(f"{agent.name}/{name}").id) for name in joints)  # parents come first
        screws = [stage.screw(joint) for joint in indices]
        bodies = [body for body, _ in frames]
        return cls(
            joints=np.array([model.jnt_qposadr[joint] for joint in indices], dtype=np.intp),
            anchors=np.array([anchor for anchor, _ in screws]).reshape(-1, 3),
            axes=np.array([axis for _, axis in screws]).reshape(-1, 3),
            slides=np.array([model.jnt_type[joint] == SLIDE for joint in indices], dtype=np.bool_),
            positions=np.array([pose.position for _, pose in frames]).reshape(-1, 3),
            matrices=np.array([pose.matrix for _, pose in frames]).reshape(-1, 3, 3),
            carried=_carried(model, [int(model.jnt_bodyid[joint]) for joint in indices], bodies),
            base=stage.body_position(agent.root_body),
        )

    def moved(self, by: Array) -> Array:
        """Where the joints bring the frames.

        Args:
            by: How far each joint moves, radians or metres, (n, j).

        Returns:
            Poses, as rows: positions in metres, then matrices row by row, (n, f, 12).
        """
        joints = (self.anchors, self.axes, self.slides, self.carried)
        return _moved(*joints, self.positions, self.matrices.reshape(-1, 9), by)


def _carried(model: mujoco.MjModel, carriers: list[int], bodies: list[int]) -> Mask:
    """Whether each frame's body hangs on each joint's, (j, f)."""
    chains = [_ancestors(model, body) for body in bodies]
    return np.array([[carrier in chain for chain in chains] for carrier in carriers], dtype=np.bool_).reshape(
        len(carriers), len(bodies)
    )


def _ancestors(model: mujoco.MjModel, body: int) -> set[int]:
    chain = {body}
    while body:
        body = int(model.body_parentid[body])
        chain.add(body)
    return chain


@compiled
def _moved(
    anchors: Array,
    axes: Array,
    slides: Mask,
    carried: Mask,
    positions: Array,
    matrices: Array,
    by: Array,
) -> Array:
    count, frames = len(by), len(positions)
    rows = np.empty((count, frames, POSE))
    for i in range(count):
        for f in range(frames):
            for k in range(3):
                rows[i, f, k] = positions[f, k]
            for k in range(9):
                rows[i, f, 3 + k] = matrices[f, k]
            for j in range(len(anchors) - 1, -1, -1):
                if not carried[j, f]:
                    continue
                if slides[j]:
                    for k in range(3):
                        rows[i, f, k] += axes[j, k] * by[i, j]
                elif by[i, j] != 0.0:
                    cx, cy, cz = anchors[j, 0], anchors[j, 1], anchors[j, 2]
                    ax, ay, az = axes[j, 0], axes[j, 1], axes[j, 2]
                    turn_pose(rows[i, f], cx, cy, cz, ax, ay, az, math.sin(by[i, j]), math.cos(by[i, j]))
    return rows


@compiled_part
def turn_pose(
    pose: Array, cx: float, cy: float, cz: float, ax: float, ay: float, az: float, sine: float, cosine: float
) -> None:
    """Turn a pose, a row of 12 that is written to, about a unit axis through a point."""
    x, y, z = rotated(ax, ay, az, sine, cosine, pose[0] - cx, pose[1] - cy, pose[2] - cz)
    pose[0], pose[1], pose[2] = x + cx, y + cy, z + cz
    for k in range(3, 6):
        x, y, z = rotated(ax, ay, az, sine, cosine, pose[k], pose[k + 3], pose[k + 6])
        pose[k], pose[k + 3], pose[k + 6] = x, y, z


@compiled
def rotated(
    ax: float, ay: float, az: float, sine: float, cosine: float, x: float, y: float, z: float
) -> tuple[float, float, float]:
    """A vector turned about a unit axis [Rodrigues]."""
    along = (ax * x + ay * y + az * z) * (1.0 - cosine)
    return (
        x * cosine + (ay * z - az * y) * sine + ax * along,
        y * cosine + (az * x - ax * z) * sine + ay * along,
        z * cosine + (ax * y - ay * x) * sine + az * along,
    )


@compiled_part
def carry_pose(pose: Array, base: Array, offset_m: Array, sine: float, cosine: float, out: Array) -> None:
    """Write a pose after a move of the base that it belongs to: turned about the vertical, then moved.

    Args:
        pose: Row of 12.
        base: Where the base is before, metres, at least (2,).
        offset_m: How far it moves along the world's x and y, (2,).
        sine: Of the turn.
        cosine: Of the turn.
        out: Row of 12.
    """
    x, y = pose[0] - base[0], pose[1] - base[1]
    out[0] = base[0] + offset_m[0] + cosine * x - sine * y
    out[1] = base[1] + offset_m[1] + sine * x + cosine * y
    out[2] = pose[2]
    for k in range(3, 6):
        out[k] = cosine * pose[k] - sine * pose[k + 3]
        out[k + 3] = sine * pose[k] + cosine * pose[k + 3]
        out[k + 6] = pose[k + 6]
