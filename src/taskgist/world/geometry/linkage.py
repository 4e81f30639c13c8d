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
from numpy.typing import NDArray

from taskgist.world.body.agent import Agent
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.pose import Pose
from taskgist.world.stage import Stage

Array = NDArray[np.float64]
SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


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

    joints: NDArray[np.intp]
    anchors: Array
    axes: Array
    slides: NDArray[np.bool_]
    positions: Array
    matrices: Array
    carried: NDArray[np.bool_]
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

    def moved(self, by: Array) -> tuple[Array, Array]:
        """Where the joints bring the frames.

        Args:
            by: How far each joint moves, radians or metres, (n, j).

        Returns:
            Positions, (n, f, 3), and matrices, (n, f, 3, 3).
        """
        joints = (self.anchors, self.axes, self.slides, self.carried)
        return _moved(*joints, self.positions, self.matrices, by)

    def displaced(
        self, frames: tuple[Array, Array], which: NDArray[np.intp], offsets_m: Array, turns_rad: Array
    ) -> tuple[Array, Array]:
        """Where moves of the base bring frames afterwards.

        Args:
            frames: Positions and matrices of some states, as from ``moved``.
            which: From which of these each of the new ones starts, (n,).
            offsets_m: How far the base moves, metres along the world's x and y, (n, 2).
            turns_rad: How far the agent turns about the vertical through its base before that, (n,).

        Returns:
            As ``moved``.
        """
        return _displaced(*frames, which, self.base, offsets_m, turns_rad)


def _carried(model: mujoco.MjModel, carriers: list[int], bodies: list[int]) -> NDArray[np.bool_]:
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
    slides: NDArray[np.bool_],
    carried: NDArray[np.bool_],
    positions: Array,
    matrices: Array,
    by: Array,
) -> tuple[Array, Array]:
    count, frames = len(by), len(positions)
    places, turned = np.empty((count, frames, 3)), np.empty((count, frames, 3, 3))
    for i in range(count):
        for f in range(frames):
            places[i, f], turned[i, f] = positions[f], matrices[f]
            for j in range(len(anchors) - 1, -1, -1):
                if not carried[j, f]:
                    continue
                if slides[j]:
                    places[i, f] += axes[j] * by[i, j]
                else:
                    turn_about(anchors[j], axes[j], by[i, j], places[i, f], turned[i, f])
    return places, turned


@compiled
def _displaced(
    positions: Array,
    matrices: Array,
    which: NDArray[np.intp],
    base: Array,
    offsets_m: Array,
    turns_rad: Array,
) -> tuple[Array, Array]:
    count, frames = len(which), positions.shape[1]
    places, turned = np.empty((count, frames, 3)), np.empty((count, frames, 3, 3))
    for i in range(count):
        sine, cosine = math.sin(turns_rad[i]), math.cos(turns_rad[i])
        for f in range(frames):
            place, matrix = positions[which[i], f], matrices[which[i], f]
            x, y = place[0] - base[0], place[1] - base[1]
            places[i, f, 0] = base[0] + offsets_m[i, 0] + cosine * x - sine * y
            places[i, f, 1] = base[1] + offsets_m[i, 1] + sine * x + cosine * y
            places[i, f, 2] = place[2]
            for k in range(3):
                turned[i, f, 0, k] = cosine * matrix[0, k] - sine * matrix[1, k]
                turned[i, f, 1, k] = sine * matrix[0, k] + cosine * matrix[1, k]
                turned[i, f, 2, k] = matrix[2, k]
    return places, turned


@compiled
def turn_about(anchor: Array, axis: Array, angle_rad: float, place: Array, matrix: Array) -> None:
    """Turn a place (3,) and a frame (3, 3), both written to, about an axis through a point [Rodrigues]."""
    if angle_rad == 0.0:
        return
    sine, cosine = math.sin(angle_rad), math.cos(angle_rad)
    x, y, z = rotated(axis, sine, cosine, place[0] - anchor[0], place[1] - anchor[1], place[2] - anchor[2])
    place[0], place[1], place[2] = x + anchor[0], y + anchor[1], z + anchor[2]
    for k in range(3):
        x, y, z = rotated(axis, sine, cosine, matrix[0, k], matrix[1, k], matrix[2, k])
        matrix[0, k], matrix[1, k], matrix[2, k] = x, y, z


@compiled
def rotated(axis: Array, sine: float, cosine: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector turned about a unit axis (3,)."""
    ax, ay, az = axis[0], axis[1], axis[2]
    along = (ax * x + ay * y + az * z) * (1.0 - cosine)
    return (
        x * cosine + (ay * z - az * y) * sine + ax * along,
        y * cosine + (az * x - ax * z) * sine + ay * along,
        z * cosine + (ax * y - ay * x) * sine + az * along,
    )
