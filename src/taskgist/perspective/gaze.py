"""The gaze: a head aimed at a point, and how far something is beside the line of sight. Compiled.

Aiming is analytic, joint by joint. Each joint of the head turns by the signed angle, about its own axis, between where
the eye looks and where the target is. Turning moves the eye as well, so this is done twice; what remains is below a
degree for anything farther than an arm. No convention about zero angles or signs of a robot's neck is needed.

Search and maps aim alike: the search at the middle of an object, a map at the centre of each cell.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.candidates import EYE, Neck
from taskgist.world.geometry.linkage import POSE, rotated, turn_pose

ROUNDS = 2
ANGLE, SINE, COSINE, TURN_COLUMNS = 0, 1, 2, 3
"""Columns of a table of turns, one row for each joint of a head: its angle in radians, and sine and cosine of how far
it has turned from its present angle."""


def aimed(frames: Array, neck: Neck, target: Array) -> Array:
    """Head angles with which the eye looks at a target, as nearly as the joints' ranges allow, radians, (h,).

    Args:
        frames: Where a candidate brings the agent's frames, (f, 12).
        neck: The joints that may be used.
        target: Point in the world, metres, (3,).
    """
    turns = np.empty((len(neck.now), TURN_COLUMNS))
    aim(frames, *neck, target, turns, np.empty(POSE))
    return turns[:, ANGLE].copy()


@compiled
def aim(
    frames: Array, joints: Indices, inwards: Indices, now: Array, ranges: Array, target: Array, turns: Array, eye: Array
) -> None:
    """Aim the head at a target, (3,): turns of its joints, (h, TURN_COLUMNS), and the eye's pose, (12,), are written.

    Joints are a ``Neck``'s arrays one by one: compiled code passes arrays on for nothing, but not tuples of them. On
    the way only the eye's position and its gaze count; the rest of its pose is turned once, at the end.
    """
    for joint in range(len(joints)):
        turns[joint, ANGLE], turns[joint, SINE], turns[joint, COSINE] = now[joint], 0.0, 1.0
    for _ in range(ROUNDS):
        for joint in range(len(joints)):
            turn = _angle_left(frames, joints, inwards, now, turns, joint, target)
            angle = min(max(turns[joint, ANGLE] + turn, ranges[joint, 0]), ranges[joint, 1])
            _turn_to(turns, joint, angle, now[joint])
    turn_head(frames, joints, inwards, now, turns, eye)


@compiled_part
def _angle_left(
    frames: Array, joints: Indices, inwards: Indices, now: Array, turns: Array, of: int, target: Array
) -> float:
    """Signed angle by which a joint still has to turn until the eye, as the head is turned, looks at a target."""
    x, y, z = frames[EYE, 0], frames[EYE, 1], frames[EYE, 2]
    gx, gy, gz = frames[EYE, 3], frames[EYE, 6], frames[EYE, 9]
    own = joints[of]
    ax, ay, az = frames[own, 3], frames[own, 6], frames[own, 9]
    carried = False
    for joint in inwards:  # the innermost turns first; those nearer to the eye than the joint itself do not carry it
        row, sine, cosine = joints[joint], turns[joint, SINE], turns[joint, COSINE]
        jx, jy, jz = frames[row, 3], frames[row, 6], frames[row, 9]
        if carried:
            ax, ay, az = rotated(jx, jy, jz, sine, cosine, ax, ay, az)
        carried = carried or joint == of
        if turns[joint, ANGLE] != now[joint]:
            cx, cy, cz = frames[row, 0], frames[row, 1], frames[row, 2]
            x, y, z = rotated(jx, jy, jz, sine, cosine, x - cx, y - cy, z - cz)
            x, y, z = x + cx, y + cy, z + cz
            gx, gy, gz = rotated(jx, jy, jz, sine, cosine, gx, gy, gz)
    tx, ty, tz = target[0] - x, target[1] - y, target[2] - z
    across = ax * (gy * tz - gz * ty) + ay * (gz * tx - gx * tz) + az * (gx * ty - gy * tx)
    along = (gx * tx + gy * ty + gz * tz) - (ax * gx + ay * gy + az * gz) * (ax * tx + ay * ty + az * tz)
    return math.atan2(across, along)


@compiled_part
def turn_head(frames: Array, joints: Indices, inwards: Indices, now: Array, turns: Array, eye: Array) -> None:
    """Write the pose of the eye, (12,), for turns of the head's joints, (h, TURN_COLUMNS)."""
    for k in range(POSE):
        eye[k] = frames[EYE, k]
    for joint in inwards:
        if turns[joint, ANGLE] != now[joint]:
            row, sine, cosine = joints[joint], turns[joint, SINE], turns[joint, COSINE]
            cx, cy, cz = frames[row, 0], frames[row, 1], frames[row, 2]
            turn_pose(eye, cx, cy, cz, frames[row, 3], frames[row, 6], frames[row, 9], sine, cosine)


@compiled
def turned_heads(frames: Array, neck: Neck, angles: Array) -> Array:
    """Poses of the eye for angles of the head, (k, h), from a candidate that brings the frames somewhere, (f, 12)."""
    joints, inwards, now = neck.frames, neck.inwards, neck.now
    eyes, turns = np.empty((len(angles), POSE)), np.empty((len(now), TURN_COLUMNS))
    for i in range(len(angles)):
        for joint in range(len(turns)):
            _turn_to(turns, joint, angles[i, joint], now[joint])
        turn_head(frames, joints, inwards, now, turns, eyes[i])
    return eyes


@compiled_part
def _turn_to(turns: Array, joint: int, angle: float, now: float) -> None:
    turns[joint, ANGLE], turns[joint, SINE], turns[joint, COSINE] = angle, math.sin(angle - now), math.cos(angle - now)


@compiled
def off_gaze(eye: Array, center: Array, radius_m: float) -> float:
    """Angle between the gaze of an eye, pose (12,), and a ball about a point (3,): 0 or less for what is ahead."""
    x, y, z = center[0] - eye[0], center[1] - eye[1], center[2] - eye[2]
    gx, gy, gz = eye[3], eye[6], eye[9]
    distance = math.sqrt(x * x + y * y + z * z)
    if distance <= radius_m:
        return 0.0
    ahead = x * gx + y * gy + z * gz
    aside = math.sqrt((y * gz - z * gy) ** 2 + (z * gx - x * gz) ** 2 + (x * gy - y * gx) ** 2)
    return math.atan2(aside, ahead) - math.asin(radius_m / distance)
