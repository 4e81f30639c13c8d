"""Steps of inverse kinematics: damped least squares within the joints' limits. Compiled.

From a configuration the joints step so that the palm comes nearer to a pose, to first order by as much as it is off::

    min |W (J d - e)|² + c |d|²   within   low - values <= d <= high - values       [Wampler 1986]

e is how far the palm is off in place (metres) and in direction (radians, along the axis of the turn that is left), J
the geometric Jacobian, W weighs directions by a lever. Joints that such a step would bring beyond a limit stop at it,
the farthest first, and the others do what is left [Baerlocher & Boulic 2004]. A step of an arm of seven joints takes
some microseconds: thousands of grasps can be asked for.

Arms are given by rows of joints as in ``world.bodies.arm_chain``, all at zero, in the frame of the robot's root; values
are counted from there. Poses are rows of 12: a position, and a matrix row by row.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.bodies.arm_chain import ALONG, LOW, SLIDES, SPAN, STEPS, put, turn_on
from taskgist.world.fit_steps import solve_positive

POSE_COLUMNS = 12
LEVER_M = 0.15
"""The lever with which an error of direction (radians) counts like one of place (metres)."""
DAMPING = 1e-4
"""c above."""
LONGEST_STEP = 0.6
"""No joint steps farther at once, radians or metres."""
MOST_STEPS, PATIENCE, STALLED = 40, 5, 0.6
"""Steps from one start; and the share of the error that must be left after so many of them to call it stuck."""
LIFT_COST = 0.1
"""How much a metre of a lift counts like when configurations to start from are ranked, metres of the palm (ours)."""
TINY = 1e-9


@compiled
def palm_at(joints: Array, palm: Array, values: Array) -> Array:
    """Where a configuration brings the palm, (12,).

    Args:
        joints: The arm, (k, 9).
        palm: The palm while all joints are at zero, (12,).
        values: The configuration, (k,).
    """
    frames, found = np.empty((len(joints) + 1, POSE_COLUMNS)), np.empty(POSE_COLUMNS)
    _carried(joints, palm, values, frames, found)
    return found


@compiled
def levers_m(joints: Array, palm: Array, configurations: Array) -> Array:
    """How far a unit of each joint moves the palm, at most, in any of some configurations (n, k), metres, (k,)."""
    count = len(joints)
    frames, now = np.empty((count + 1, POSE_COLUMNS)), np.empty(POSE_COLUMNS)
    jacobian, found = np.empty((6, count)), np.zeros(count)
    for values in configurations:
        _carried(joints, palm, values, frames, now)
        _put_jacobian(joints, frames, now, jacobian)
        for joint in range(count):
            x, y, z = jacobian[0, joint], jacobian[1, joint], jacobian[2, joint]
            found[joint] = max(found[joint], math.sqrt(x * x + y * y + z * z))
    return found


@compiled
def descend(
    joints: Array, palm: Array, target: Array, values: Array, moving: Mask, near_m: float, near_rad: float
) -> bool:
    """Step towards a pose; whether the palm arrives at it.

    Args:
        joints: The arm, (k, 9); their limits are kept.
        palm: The palm while all joints are at zero, (12,).
        target: Where it is to be, (12,).
        values: Where to start, (k,); written to.
        moving: Which joints may move, (k,).
        near_m: How near it comes in place, metres,
        near_rad: and in direction, radians.
    """
    count = len(joints)
    frames, now = np.empty((count + 1, POSE_COLUMNS)), np.empty(POSE_COLUMNS)
    jacobian, off, step = np.empty((6, count)), np.empty(6), np.empty(count)
    errors = np.empty(MOST_STEPS)
    for number in range(MOST_STEPS):
        _carried(joints, palm, values, frames, now)
        place_m, turn_rad = _off(now, target, off)
        if place_m < near_m and turn_rad < near_rad:
            return True
        errors[number] = place_m + LEVER_M * turn_rad
        if number >= PATIENCE and errors[number] > STALLED * errors[number - PATIENCE]:
            return False
        _put_jacobian(joints, frames, now, jacobian)
        _put_step(joints, jacobian, off, values, moving, step)
        longest = np.abs(step).max()
        share = 1.0 if longest <= LONGEST_STEP else LONGEST_STEP / longest
        for joint in range(count):
            values[joint] += share * step[joint]
    return False


@compiled
def nearest_kept(
    joints: Array,
    palm: Array,
    target: Array,
    ahead: Array,
    least_cosine: float,
    lifts: Array,
    from_now: Array,
    cells: Indices,
    starts: Indices,
    configurations: NDArray[np.uint16],
    most: int,
) -> Array:
    """Configurations of a capability map that bring the palm nearest to a pose, (n, k), at most so many.

    Args:
        joints: The arm, lifts first, (k, 9).
        palm: The palm while all joints are at zero, (12,).
        target: Where it is to be, (12,).
        ahead: Which way the hand points, in the palm's frame, (3,).
        least_cosine: Of the angle between where it is to point, and where it does.
        lifts: Values of the lifts, each tried, (h, l).
        from_now: How far that lifts them from where they are, (h,).
        cells: The map's cell of the place for each of them; −1 where there is none, (h,).
        starts: Where the configurations of each cell begin, (cells + 1,).
        configurations: Those that the map keeps, of the joints after the lifts, in steps of their spans, (c, k - l).
        most: How many are wanted.
    """
    count, lifting = len(joints), lifts.shape[1]
    frames, now, off, values = np.empty((count + 1, POSE_COLUMNS)), np.empty(POSE_COLUMNS), np.empty(6), np.empty(count)
    found, costs, known = np.empty((most, count)), np.full(most, np.inf), 0
    for height in range(len(lifts)):
        if cells[height] < 0:
            continue
        values[:lifting] = lifts[height]
        for row in range(starts[cells[height]], starts[cells[height] + 1]):
            for joint in range(lifting, count):
                share = configurations[row, joint - lifting] / STEPS
                values[joint] = joints[joint, LOW] + joints[joint, SPAN] * share
            _carried(joints, palm, values, frames, now)
            if _cosine(now, target, ahead) < least_cosine:
                continue
            place_m, turn_rad = _off(now, target, off)
            cost = place_m + LEVER_M * turn_rad + LIFT_COST * from_now[height]
            if cost >= costs[most - 1]:
                continue
            place = most - 1
            while place > 0 and costs[place - 1] > cost:
                costs[place], found[place] = costs[place - 1], found[place - 1]
                place -= 1
            costs[place], found[place] = cost, values
            known = min(known + 1, most)
    return found[:known]


@compiled_part
def _carried(joints: Array, palm: Array, values: Array, frames: Array, found: Array) -> None:
    """Write the frame after each joint, (k + 1, 12), and the palm's pose, (12,)."""
    for k in range(POSE_COLUMNS):
        frames[0, k] = 1.0 if k in (3, 7, 11) else 0.0
    for joint in range(len(joints)):
        for k in range(POSE_COLUMNS):
            frames[joint + 1, k] = frames[joint, k]
        turn_on(frames[joint + 1], joints[joint], values[joint])
    last = frames[len(joints)]
    found[0], found[1], found[2] = put(last, palm[0], palm[1], palm[2])
    for row in range(3):
        for column in range(3):
            at = 0.0
            for k in range(3):
                at += last[3 + 3 * row + k] * palm[3 + 3 * k + column]
            found[3 + 3 * row + column] = at


@compiled_part
def _cosine(one: Array, other: Array, axis: Array) -> float:
    """Of the angle between an axis in one frame and the same in another."""
    cosine = 0.0
    for row in range(3, POSE_COLUMNS, 3):
        here = one[row] * axis[0] + one[row + 1] * axis[1] + one[row + 2] * axis[2]
        there = other[row] * axis[0] + other[row + 1] * axis[1] + other[row + 2] * axis[2]
        cosine += here * there
    return cosine


@compiled_part
def _off(now: Array, target: Array, off: Array) -> tuple[float, float]:
    """How far a pose is off in place, metres, and direction, radians; ``off``, (6,), is written to: both as vectors."""
    turn = np.empty((3, 3))  # from now to the target
    for row in range(3):
        off[row] = target[row] - now[row]
        for column in range(3):
            at = 0.0
            for k in range(3):
                at += target[3 + 3 * row + k] * now[3 + 3 * column + k]
            turn[row, column] = at
    x, y, z = (turn[2, 1] - turn[1, 2]) / 2, (turn[0, 2] - turn[2, 0]) / 2, (turn[1, 0] - turn[0, 1]) / 2
    sine, cosine = math.sqrt(x * x + y * y + z * z), (turn[0, 0] + turn[1, 1] + turn[2, 2] - 1) / 2
    angle = math.atan2(sine, cosine)
    if sine < TINY and cosine < 0.0:  # half a turn: its axis is the longest column of turn + 1
        axis = 0
        for other in range(1, 3):
            axis = other if turn[other, other] > turn[axis, axis] else axis
        x, y, z = turn[0, axis] + (axis == 0), turn[1, axis] + (axis == 1), turn[2, axis] + (axis == 2)
        sine = math.sqrt(x * x + y * y + z * z)
    by = angle / sine if sine > 0.0 else 0.0
    off[3], off[4], off[5] = by * x, by * y, by * z
    return math.sqrt(off[0] ** 2 + off[1] ** 2 + off[2] ** 2), angle


@compiled_part
def _put_jacobian(joints: Array, frames: Array, now: Array, jacobian: Array) -> None:
    """Write how the palm moves and turns for a unit of each joint, (6, k)."""
    for joint in range(len(joints)):
        row, frame = joints[joint], frames[joint]
        for k in range(3):
            jacobian[3 + k, joint] = (
                frame[3 + 3 * k] * row[ALONG] + frame[4 + 3 * k] * row[ALONG + 1] + frame[5 + 3 * k] * row[ALONG + 2]
            )
        ax, ay, az = jacobian[3, joint], jacobian[4, joint], jacobian[5, joint]
        if row[SLIDES] == 1.0:
            jacobian[0, joint], jacobian[1, joint], jacobian[2, joint] = ax, ay, az
            jacobian[3, joint] = jacobian[4, joint] = jacobian[5, joint] = 0.0
            continue
        x, y, z = put(frame, row[0], row[1], row[2])
        x, y, z = now[0] - x, now[1] - y, now[2] - z
        jacobian[0, joint], jacobian[1, joint], jacobian[2, joint] = ay * z - az * y, az * x - ax * z, ax * y - ay * x


@compiled_part
def _put_step(joints: Array, jacobian: Array, off: Array, values: Array, moving: Mask, step: Array) -> None:
    """Write the step of damped least squares, (k,), within the joints' limits."""
    count = len(joints)
    normal, right = np.empty((count, count)), np.empty(count)
    for one in range(count):
        right[one] = _weighted(jacobian[:, one], off)
        for other in range(count):
            normal[one, other] = _weighted(jacobian[:, one], jacobian[:, other])
        normal[one, one] += DAMPING
    for joint in range(count):
        if not moving[joint]:
            _fix(normal, right, joint, 0.0)
    for _ in range(count):
        solve_positive(normal, right, step, count)
        worst, beyond, stop = -1, TINY, 0.0
        for joint in range(count):
            low = joints[joint, LOW] - values[joint]
            high = low + joints[joint, SPAN]
            over = max(low - step[joint], step[joint] - high)
            if over > beyond:
                worst, beyond, stop = joint, over, (low if step[joint] < low else high)
        if worst < 0:
            return
        _fix(normal, right, worst, stop)


@compiled_part
def _weighted(one: Array, other: Array) -> float:
    """The product of two rates or errors, (6,) each, directions weighed by the lever."""
    place = one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
    turn = one[3] * other[3] + one[4] * other[4] + one[5] * other[5]
    return float(place + LEVER_M * LEVER_M * turn)


@compiled_part
def _fix(normal: Array, right: Array, joint: int, step: float) -> None:
    """Let the solution of normal equations be known for a joint."""
    for other in range(len(right)):
        right[other] -= normal[other, joint] * step
        normal[other, joint] = normal[joint, other] = 0.0
    normal[joint, joint], right[joint] = 1.0, step
