"""Aiming the head: analytic, joint by joint.

Each joint of the head turns by the signed angle, about its own axis, between where the eye looks and where the target
is. Turning moves the eye as well, so this is done twice; what remains is below a degree for anything farther than an
arm. No convention about zero angles or signs of a robot's neck is needed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.frames import EYE, Neck
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.linkage import POSE, rotated, turn_pose

Array = NDArray[np.float64]
ROUNDS = 2


def aimed(frames: Array, neck: Neck, target: Array) -> Array:
    """Head angles with which the eye looks at a target, as nearly as the joints' ranges allow, radians, (h,).

    Args:
        frames: Where a stance brings the agent's frames, (f, 12).
        neck: The joints that may be used.
        target: Point in the world, metres, (3,).
    """
    angles = np.empty(len(neck.now))
    aim(frames, neck, target, angles, np.empty(POSE))
    return angles


@compiled
def turned_heads(frames: Array, neck: Neck, angles: Array) -> Array:
    """Poses of the eye for angles of the head, (k, h), from a stance that brings the frames somewhere, (f, 12)."""
    eyes = np.empty((len(angles), POSE))
    for i in range(len(angles)):
        turn_head(frames, neck, angles[i], eyes[i])
    return eyes


@compiled
def aim(frames: Array, neck: Neck, target: Array, angles: Array, eye: Array) -> None:
    """Aim the head: angles, (h,), and the pose of the eye with them, (12,), are written."""
    joints, ranges, now = neck.frames, neck.ranges, neck.now
    angles[:] = now
    for _ in range(ROUNDS):
        for joint in range(len(joints)):
            turn_head(frames, neck, angles, eye)
            turn = _angle_left(frames, neck, angles, joint, eye, target)
            angles[joint] = min(max(angles[joint] + turn, ranges[joint, 0]), ranges[joint, 1])
    turn_head(frames, neck, angles, eye)


@compiled
def turn_head(frames: Array, neck: Neck, angles: Array, eye: Array) -> None:
    """Write the pose of the eye, (12,), for angles of the head, (h,): the innermost joint turns first."""
    eye[:] = frames[EYE]
    for joint in neck.inwards:
        screw = frames[neck.frames[joint]]
        turn_pose(eye, screw[:3], screw[3::3], angles[joint] - neck.now[joint])


@compiled
def _angle_left(frames: Array, neck: Neck, angles: Array, of: int, eye: Array, target: Array) -> float:
    """Signed angle by which a joint still has to turn until the eye, as it is, looks at a target."""
    row = frames[neck.frames[of]]
    ax, ay, az = row[3], row[6], row[9]
    within = True
    for joint in neck.inwards:  # those nearer to the eye than the joint itself do not carry it
        if not within:
            screw, by = frames[neck.frames[joint]], angles[joint] - neck.now[joint]
            ax, ay, az = rotated(screw[3], screw[6], screw[9], math.sin(by), math.cos(by), ax, ay, az)
        within = within and joint != of
    sx, sy, sz = eye[3], eye[6], eye[9]
    ex, ey, ez = target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]
    across = ax * (sy * ez - sz * ey) + ay * (sz * ex - sx * ez) + az * (sx * ey - sy * ex)
    along = (sx * ex + sy * ey + sz * ez) - (ax * sx + ay * sy + az * sz) * (ax * ex + ay * ey + az * ez)
    return math.atan2(across, along)
