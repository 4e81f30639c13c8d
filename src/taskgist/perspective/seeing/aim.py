"""Aiming the head: analytic, joint by joint, for many stances at once.

Each joint of the head turns by the signed angle, about its own axis, between where the eye looks and where the target
is. Turning moves the eye as well, so this is done twice; what remains is below a degree for anything farther than an
arm. No convention about zero angles or signs of a robot's neck is needed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.frames import Frames, Placed
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.linkage import rotated, turn_about

Array = NDArray[np.float64]
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Aims:
    """The head aimed at a target, from n stances.

    Attributes:
        joints: Index into qpos of each joint of the head that may be used, (h,).
        angles: Angles of these joints in radians, (n, h).
        eyes: Where the eye is then, metres, (n, 3).
        turned: How it is turned, (n, 3, 3); it looks along its x axis.
    """

    joints: tuple[int, ...]
    angles: Array
    eyes: Array
    turned: Array

    @property
    def gazes(self) -> Array:
        """Unit directions in which it looks, (n, 3)."""
        return self.turned[:, :, 0]

    def changes(self, index: int) -> dict[int, float]:
        """Angles of one stance, by index into qpos."""
        return dict(zip(self.joints, self.angles[index].tolist(), strict=True))


def aimed(placed: Placed, frames: Frames, target: Array, actions: frozenset[str]) -> Aims:
    """Head angles with which the eye looks at a target, as nearly as the joints' ranges allow.

    Args:
        placed: Where the stances bring the eye and the head's joints.
        frames: Whose; it knows the joints' present angles, which are always allowed, and their ranges.
        target: Point in the world, metres, (3,).
        actions: Virtual actions that may be used.
    """
    head = frames.usable(actions)
    anchors, axes = placed.anchors[:, head.columns], placed.axes[:, head.columns]
    angles, eyes, turned = _aimed(*placed.eyes, anchors, axes, head.inwards, head.now, head.ranges, target)
    return Aims(tuple(joint.index for joint in head.joints), angles, eyes, turned)


def on_the_way(placed: Placed, frames: Frames, aims: Aims, index: int, steps: int, actions: frozenset[str]) -> Aims:
    """The head at equal steps from where it is to where it is aimed from one stance: there at first and at last.

    Args:
        placed: Where the stances bring the eye and the head's joints.
        frames: Whose.
        aims: Where it is aimed from each.
        index: The stance.
        steps: How many steps.
        actions: Virtual actions that may be used.
    """
    head = frames.usable(actions)
    shares = np.arange(steps + 1)[:, None] / steps
    angles = np.where(shares < 1.0, head.now + (aims.angles[index] - head.now) * shares, aims.angles[index])
    eye, matrix = placed.eyes
    anchors, axes = placed.anchors[index, head.columns], placed.axes[index, head.columns]
    eyes, turned = _heads(eye[index], matrix[index], anchors, axes, head.inwards, angles - head.now)
    return Aims(aims.joints, angles, eyes, turned)


@compiled
def _heads(
    eye: Array, matrix: Array, anchors: Array, axes: Array, inwards: NDArray[np.int64], by: Array
) -> tuple[Array, Array]:
    places, turned = np.empty((len(by), 3)), np.empty((len(by), 3, 3))
    for i in range(len(by)):
        places[i], turned[i] = eye, matrix
        for joint in inwards:
            turn_about(anchors[joint], axes[joint], by[i, joint], places[i], turned[i])
    return places, turned


@compiled
def _aimed(
    eyes: Array,
    matrices: Array,
    anchors: Array,
    axes: Array,
    inwards: NDArray[np.int64],
    now: Array,
    ranges: Array,
    target: Array,
) -> tuple[Array, Array, Array]:
    count, joints = len(eyes), len(now)
    angles, places, turned = np.empty((count, joints)), eyes.copy(), matrices.copy()
    by, axis = np.zeros(joints), np.zeros(3)
    for i in range(count):
        by[:] = 0.0
        for _ in range(ROUNDS):
            for joint in range(joints):
                _turn_head(i, places, turned, eyes, matrices, anchors, axes, inwards, by)
                _axis_now(i, joint, axes, inwards, by, axis)
                turn = _angle_about(axis, turned[i, :, 0], target, places[i])
                low, high = min(ranges[joint, 0], now[joint]), max(ranges[joint, 1], now[joint])
                by[joint] = min(max(now[joint] + by[joint] + turn, low), high) - now[joint]
        _turn_head(i, places, turned, eyes, matrices, anchors, axes, inwards, by)
        angles[i] = now + by
    return angles, places, turned


@compiled
def _turn_head(
    i: int,
    places: Array,
    turned: Array,
    eyes: Array,
    matrices: Array,
    anchors: Array,
    axes: Array,
    inwards: NDArray[np.int64],
    by: Array,
) -> None:
    """Write where an eye gets to: the outermost joint turns first."""
    places[i], turned[i] = eyes[i], matrices[i]
    for joint in inwards:
        turn_about(anchors[i, joint], axes[i, joint], by[joint], places[i], turned[i])


@compiled
def _axis_now(i: int, of: int, axes: Array, inwards: NDArray[np.int64], by: Array, axis: Array) -> None:
    """Write the direction of a joint's axis, turned by those joints that carry it, (3,)."""
    axis[:] = axes[i, of]
    within = True
    for joint in inwards:  # those nearer to the eye than the joint itself do not carry it
        if not within:
            x, y, z = rotated(axes[i, joint], math.sin(by[joint]), math.cos(by[joint]), axis[0], axis[1], axis[2])
            axis[0], axis[1], axis[2] = x, y, z
        within = within and joint != of


@compiled
def _angle_about(axis: Array, start: Array, target: Array, eye: Array) -> float:
    """Signed angle about a unit axis that turns a direction towards a target, seen from an eye; vectors (3,)."""
    ax, ay, az = axis[0], axis[1], axis[2]
    sx, sy, sz = start[0], start[1], start[2]
    ex, ey, ez = target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]
    across = ax * (sy * ez - sz * ey) + ay * (sz * ex - sx * ez) + az * (sx * ey - sy * ex)
    along = (sx * ex + sy * ey + sz * ez) - (ax * sx + ay * sy + az * sz) * (ax * ex + ay * ey + az * ez)
    return math.atan2(across, along)
