"""Steps of a fit: a tree of joints on a free root is drawn to targets by damped least squares. Compiled.

A *feature* of a body is a point that is fixed to it, or a direction. Both are a place p, carried by one joint, and a
lever o that turns with another one (or the same); a direction has the lever alone. A fit makes the least of::

    E = sum w² |p + o - target|²  +  sum c² (q - rest)²

by Gauss-Newton steps within the joints' limits [Levenberg 1944]::

    min |J d + e|² + (damping + lm E_features) |d|²   within   0.95 (low - q) <= d <= 0.95 (high - q)

The steps are those of mink's quadratic program: the tests hold each to it. Which bounds hold is found by an active set,
as of primal-dual methods [Hintermüller, Ito & Kunisch 2002], which begins with that of the step before; what is left is
solved by Cholesky's factors. A step is halved until it helps. One of a whole body takes some tens of microseconds.

Poses are rows of 12: a position, and a matrix row by row. Joints are rows as in ``bodies.arm_chain``, all at zero in
the frame of the root; values are counted from there. A configuration of n degrees of freedom is the root's, six of
which move it, if it moves at all: along the axes of the world, and about its own; then the free joints.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.bodies.arm_chain import ALONG, SLIDES, put, turn_on

POSE_COLUMNS, ROOT_DOFS = 12, 6
WEIGHT, PLACE, LEVER, FEATURE_COLUMNS = 0, 1, 4, 7
"""Columns of a feature: its weight; place (3) and lever (3) while all joints are at zero, in the root's axes."""
ROOT, NOWHERE = -1, -2
"""What carries a place instead of a joint: the root, or nothing, for a direction has none."""
LM_DAMPING = 1e-3
"""Share of the squared error that is added to the diagonal: steps stay short while the targets are far."""
LIMIT_SHARE = 0.95
"""How much of the way to its limit a joint goes in one step."""
LONGEST_STEP = 0.5
"""Radians or metres that one step may change a joint by."""
CONVERGED_RAD = 2e-4
HALVINGS = 8
NEGLIGIBLE_GAIN = 1e-4
"""Share of the error below which a step is the last one."""
MOST_SETS, SLACK = 50, 1e-10
"""Sets of active bounds tried for a step; and how far beyond a bound counts as within it."""
FREE, AT_LOW, AT_HIGH = 0, 1, 2


@compiled
def places_of(
    joints: Array, parents: Indices, features: Array, carriers: Indices, roots: Array, values: Array
) -> Array:
    """Where features are, or point, in some configurations, (n, f, 3).

    Args:
        joints: The joints, parents first, (j, 9).
        parents: The joint that carries each; −1 for the root, (j,).
        features: (f, 7).
        carriers: What carries the place of each, and what turns its lever, (f, 2).
        roots: Poses of the root: metres, wxyz, (n, 7).
        values: Values of all joints, (n, j).
    """
    root, frames = np.empty(POSE_COLUMNS), np.empty((len(joints), POSE_COLUMNS))
    found = np.empty((len(values), len(features), 3))
    for row in range(len(values)):
        _put_frames(joints, parents, roots[row], values[row], root, frames)
        for feature in range(len(features)):
            px, py, pz, ox, oy, oz = _placed(features[feature], carriers[feature], root, frames)
            found[row, feature, 0], found[row, feature, 1], found[row, feature, 2] = px + ox, py + oy, pz + oz
    return found


@compiled
def descend(
    joints: Array,
    parents: Indices,
    free: Indices,
    limits: Array,
    features: Array,
    carriers: Indices,
    targets: Array,
    posture: Array,
    rest: Array,
    base: Array,
    values: Array,
    active: NDArray[np.int8],
    damping: float,
    iterations: int,
) -> float:
    """Draw a body to targets: steps until none changes much, or there were enough. The least cost E that they reach.

    Args:
        joints: The joints, parents first, (j, 9).
        parents: The joint that carries each; −1 for the root, (j,).
        free: Which of them move, (k,).
        limits: Least and greatest value of those, (k, 2).
        features: (f, 7).
        carriers: What carries the place of each, and what turns its lever, (f, 2).
        targets: Where they are to be, metres, or to point, (f, 3); those that are not finite are left out.
        posture: How strongly each free joint is drawn to rest, c above, (k,).
        rest: Values of the free joints at rest, (k,).
        base: Pose of the root: metres, wxyz, (7,); written to.
        values: Values of all joints, (j,); written to.
        active: Which bound each degree of freedom is at, (n,); written to. With n = k the root stays where it is.
        damping: Pull of a step towards none.
        iterations: Most steps.
    """
    count, known = len(active), _known(targets)
    root, frames = np.empty(POSE_COLUMNS), np.empty((len(joints), POSE_COLUMNS))
    errors, normal, right = np.empty((len(known), 3)), np.empty((count, count)), np.empty(count)
    bounds, step = np.empty((count, 2)), np.empty(count)
    base_before, values_before = np.empty(7), np.empty(len(values))
    dofs = _dofs(len(joints), free, count)
    cost, apart, longest = np.inf, 0.0, np.inf
    for number in range(iterations + 1):  # the first time all stays where it is: each function is compiled in once
        if number > 0:
            _put_normal(joints, parents, dofs, features, carriers, known, root, frames, errors, normal, right)
            _add_posture(free, posture, rest, values, limits, damping + LM_DAMPING * apart, normal, right, bounds)
            _bounded(normal, right, bounds, active, step)
            longest = _shortened(step)
        _copy(base, base_before)
        _copy(values, values_before)
        change = 0.0
        for _ in range(HALVINGS):
            if number > 0:
                _go(free, step, base, values)
            _put_frames(joints, parents, base, values, root, frames)
            apart = _errors(features, carriers, targets, known, root, frames, errors)
            now = apart + _posture_cost(free, posture, rest, values)
            if now < cost:
                change = longest if now < (1.0 - NEGLIGIBLE_GAIN) * cost else 0.0
                cost = now
                break
            _copy(base_before, base)
            _copy(values_before, values)
            step *= 0.5
            longest *= 0.5
        if change < CONVERGED_RAD:
            break
    return cost


@compiled_part
def _copy(source: Array, target: Array) -> None:
    """Copy numbers, (n,); numba takes seconds to compile ``target[:] = source``, which checks shapes."""
    for row in range(len(source)):
        target[row] = source[row]


@compiled_part
def _shortened(step: Array) -> float:
    """Shorten a step that is too long; the largest change that it makes then, radians or metres."""
    longest = 0.0
    for change in step:
        longest = max(longest, abs(change))
    if longest > LONGEST_STEP:
        step *= LONGEST_STEP / longest
    return min(longest, LONGEST_STEP)


@compiled_part
def _known(targets: Array) -> Indices:
    """Indices of the targets that are finite."""
    known, count = np.empty(len(targets), dtype=np.int64), 0
    for row in range(len(targets)):
        if math.isfinite(targets[row, 0] + targets[row, 1] + targets[row, 2]):
            known[count] = row
            count += 1
    return known[:count]


@compiled_part
def _dofs(joints: int, free: Indices, count: int) -> Indices:
    """Degree of freedom of each joint, −1 where it stays, and at the end the root's first one, (j + 1,)."""
    dofs, first = np.full(joints + 1, -1), count - len(free)
    for place in range(len(free)):
        dofs[free[place]] = first + place
    if first == ROOT_DOFS:
        dofs[joints] = 0
    return dofs


@compiled_part
def _put_frames(joints: Array, parents: Indices, base: Array, values: Array, root: Array, frames: Array) -> None:
    """Write the pose of the root, (12,), and those after each joint, (j, 12)."""
    length = math.sqrt(base[3] ** 2 + base[4] ** 2 + base[5] ** 2 + base[6] ** 2)
    w, x, y, z = base[3] / length, base[4] / length, base[5] / length, base[6] / length
    root[0], root[1], root[2] = base[0], base[1], base[2]
    root[3], root[4], root[5] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    root[6], root[7], root[8] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    root[9], root[10], root[11] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)
    for joint in range(len(joints)):
        parent = parents[joint]
        for k in range(POSE_COLUMNS):
            frames[joint, k] = root[k] if parent == ROOT else frames[parent, k]
        turn_on(frames[joint], joints[joint], values[joint])


@compiled_part
def _placed(
    feature: Array, carriers: Indices, root: Array, frames: Array
) -> tuple[float, float, float, float, float, float]:
    """Place and lever of a feature in the world."""
    px, py, pz = 0.0, 0.0, 0.0
    if carriers[0] != NOWHERE:
        frame = root if carriers[0] == ROOT else frames[carriers[0]]
        px, py, pz = put(frame, feature[PLACE], feature[PLACE + 1], feature[PLACE + 2])
    frame = root if carriers[1] == ROOT else frames[carriers[1]]
    x, y, z = feature[LEVER], feature[LEVER + 1], feature[LEVER + 2]
    return (
        px,
        py,
        pz,
        frame[3] * x + frame[4] * y + frame[5] * z,
        frame[6] * x + frame[7] * y + frame[8] * z,
        frame[9] * x + frame[10] * y + frame[11] * z,
    )


@compiled_part
def _errors(
    features: Array, carriers: Indices, targets: Array, known: Indices, root: Array, frames: Array, errors: Array
) -> float:
    """Write how far each feature is from its target, (f, 3); the sum of their squares, weighted."""
    total = 0.0
    for row in range(len(known)):
        feature = known[row]
        px, py, pz, ox, oy, oz = _placed(features[feature], carriers[feature], root, frames)
        x, y, z = px + ox - targets[feature, 0], py + oy - targets[feature, 1], pz + oz - targets[feature, 2]
        errors[row, 0], errors[row, 1], errors[row, 2] = x, y, z
        total += features[feature, WEIGHT] ** 2 * (x * x + y * y + z * z)
    return total


@compiled_part
def _posture_cost(free: Indices, posture: Array, rest: Array, values: Array) -> float:
    total = 0.0
    for place in range(len(free)):
        total += (posture[place] * (values[free[place]] - rest[place])) ** 2
    return total


@compiled_part
def _put_normal(
    joints: Array,
    parents: Indices,
    dofs: Indices,
    features: Array,
    carriers: Indices,
    known: Indices,
    root: Array,
    frames: Array,
    errors: Array,
    normal: Array,
    right: Array,
) -> None:
    """Write the normal equations of all features: JᵀJ, its lower half, (n, n), and −Jᵀe, (n,)."""
    axes, anchors = np.empty((len(joints), 3)), np.empty((len(joints), 3))
    for joint in range(len(joints)):
        frame, row = frames[joint], joints[joint]
        anchors[joint, 0], anchors[joint, 1], anchors[joint, 2] = put(frame, row[0], row[1], row[2])
        for k in range(3):
            axes[joint, k] = (
                frame[3 + 3 * k] * row[ALONG] + frame[4 + 3 * k] * row[ALONG + 1] + frame[5 + 3 * k] * row[ALONG + 2]
            )
    normal[:], right[:] = 0.0, 0.0
    moving, rates, rows = np.empty(len(right), dtype=np.int64), np.empty((len(right), 3)), np.full(len(right), -1)
    place, lever = np.empty(3), np.empty(3)
    for row in range(len(known)):
        carried, weight = carriers[known[row]], features[known[row], WEIGHT]
        place[0], place[1], place[2], lever[0], lever[1], lever[2] = _placed(
            features[known[row]], carried, root, frames
        )
        filled = _put_turns(joints, parents, dofs, carried, place, lever, axes, anchors, moving, rates, rows)
        if dofs[len(joints)] == 0:
            filled = _put_root(carried[0] != NOWHERE, place, lever, root, moving, rates, filled)
        for one in range(filled):
            dof, x, y, z = moving[one], weight**2 * rates[one, 0], weight**2 * rates[one, 1], weight**2 * rates[one, 2]
            right[dof] -= x * errors[row, 0] + y * errors[row, 1] + z * errors[row, 2]
            rows[dof] = -1
            for other in range(one + 1):
                to = moving[other]
                normal[max(dof, to), min(dof, to)] += x * rates[other, 0] + y * rates[other, 1] + z * rates[other, 2]


@compiled_part
def _put_turns(
    joints: Array,
    parents: Indices,
    dofs: Indices,
    carried: Indices,
    place: Array,
    lever: Array,
    axes: Array,
    anchors: Array,
    moving: Indices,
    rates: Array,
    rows: Indices,
) -> int:
    """Write how a feature moves for a unit of each free joint that carries it, (m, 3), and which these are; how many.

    ``rows`` tells where the rate of each degree of freedom stands: joints that carry the place and turn the lever, too,
    have one for both.
    """
    filled = 0
    for part in range(2):
        joint = carried[part]
        while joint >= 0:
            dof = dofs[joint]
            if dof >= 0:
                if rows[dof] < 0:
                    rows[dof], moving[filled] = filled, dof
                    rates[filled, 0] = rates[filled, 1] = rates[filled, 2] = 0.0
                    filled += 1
                ax, ay, az, rate = axes[joint, 0], axes[joint, 1], axes[joint, 2], rates[rows[dof]]
                if joints[joint, SLIDES] == 0.0:
                    x, y, z = lever[0], lever[1], lever[2]
                    if part == 0:
                        x, y, z = (
                            place[0] - anchors[joint, 0],
                            place[1] - anchors[joint, 1],
                            place[2] - anchors[joint, 2],
                        )
                    ax, ay, az = ay * z - az * y, az * x - ax * z, ax * y - ay * x
                elif part == 1:
                    ax, ay, az = 0.0, 0.0, 0.0
                rate[0], rate[1], rate[2] = rate[0] + ax, rate[1] + ay, rate[2] + az
            joint = parents[joint]
    return filled


@compiled_part
def _put_root(placed: bool, place: Array, lever: Array, root: Array, moving: Indices, rates: Array, filled: int) -> int:
    """Write how a feature moves with the root, after the joints' rates; how many there are then."""
    x, y, z = lever[0], lever[1], lever[2]
    if placed:
        x, y, z = place[0] + x - root[0], place[1] + y - root[1], place[2] + z - root[2]
        for k in range(3):
            moving[filled], rates[filled, 0], rates[filled, 1], rates[filled, 2] = k, 0.0, 0.0, 0.0
            rates[filled, k] = 1.0
            filled += 1
    for k in range(3):
        ax, ay, az = root[3 + k], root[6 + k], root[9 + k]
        moving[filled] = 3 + k
        rates[filled, 0], rates[filled, 1], rates[filled, 2] = ay * z - az * y, az * x - ax * z, ax * y - ay * x
        filled += 1
    return filled


@compiled_part
def _add_posture(
    free: Indices,
    posture: Array,
    rest: Array,
    values: Array,
    limits: Array,
    damping: float,
    normal: Array,
    right: Array,
    bounds: Array,
) -> None:
    """Add the pull to rest and the damping; write within which bounds a step is to be, (n, 2)."""
    first = len(right) - len(free)
    for dof in range(len(right)):
        normal[dof, dof] += damping
        bounds[dof, 0], bounds[dof, 1] = -np.inf, np.inf
    for place in range(len(free)):
        dof, value, pull = first + place, values[free[place]], posture[place] ** 2
        normal[dof, dof] += pull
        right[dof] -= pull * (value - rest[place])
        bounds[dof, 0] = LIMIT_SHARE * (limits[place, 0] - value)
        bounds[dof, 1] = LIMIT_SHARE * (limits[place, 1] - value)


@compiled_part
def _bounded(normal: Array, right: Array, bounds: Array, active: NDArray[np.int8], step: Array) -> None:
    """Write the step of least cost within bounds, (n,).

    Which of them it is at is guessed, the rest solved, and the guess mended: what is beyond a bound is put on it, and
    what the cost draws off its bound is let go.
    """
    count = len(right)
    inner, small = np.empty(count, dtype=np.int64), np.empty((count, count))
    target, found = np.empty(count), np.empty(count)
    for _ in range(MOST_SETS):
        size = 0
        for dof in range(count):
            if active[dof] == FREE:
                inner[size] = dof
                size += 1
            else:
                step[dof] = bounds[dof, active[dof] - 1]
        for row in range(size):
            target[row] = right[inner[row]]
            for other in range(count):
                if active[other] != FREE:
                    target[row] -= normal[max(inner[row], other), min(inner[row], other)] * step[other]
            for column in range(row + 1):
                small[row, column] = normal[inner[row], inner[column]]
        solve_positive(small, target, found, size)
        for row in range(size):
            step[inner[row]] = found[row]
        if not _mended(normal, right, bounds, active, step):
            return
    _clip(step, bounds)  # a guess that goes round in circles: the line search sees to what is left


@compiled_part
def _clip(step: Array, bounds: Array) -> None:
    for dof in range(len(step)):
        step[dof] = min(max(step[dof], bounds[dof, 0]), bounds[dof, 1])


@compiled_part
def _mended(normal: Array, right: Array, bounds: Array, active: NDArray[np.int8], step: Array) -> bool:
    """Whether a guess of active bounds had to be mended; it is written to."""
    mended = False
    for dof in range(len(right)):
        before = active[dof]
        if before == FREE:
            if step[dof] < bounds[dof, 0] - SLACK:
                active[dof] = AT_LOW
            elif step[dof] > bounds[dof, 1] + SLACK:
                active[dof] = AT_HIGH
        else:
            slope = -right[dof]
            for other in range(len(right)):
                slope += normal[max(dof, other), min(dof, other)] * step[other]
            slope = slope if before == AT_LOW else -slope
            if slope < -SLACK:
                active[dof] = FREE
        mended = mended or active[dof] != before
    return mended


@compiled_part
def _go(free: Indices, step: Array, base: Array, values: Array) -> None:
    """Step: joints by their values, the root along the axes of the world and about its own."""
    first = len(step) - len(free)
    for place in range(len(free)):
        values[free[place]] += step[first + place]
    if first != ROOT_DOFS:
        return
    for k in range(3):
        base[k] += step[k]
    angle = math.sqrt(step[3] ** 2 + step[4] ** 2 + step[5] ** 2)
    half = math.sin(angle / 2) / angle if angle > 0.0 else 0.5
    w, x, y, z = math.cos(angle / 2), half * step[3], half * step[4], half * step[5]
    a, b, c, d = base[3], base[4], base[5], base[6]
    base[3], base[4] = a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y
    base[5], base[6] = a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w
    length = math.sqrt(base[3] ** 2 + base[4] ** 2 + base[5] ** 2 + base[6] ** 2)
    for k in range(3, 7):
        base[k] /= length


@compiled_part
def solve_positive(normal: Array, right: Array, found: Array, count: int) -> None:
    """Solve the first so many of positive definite equations by Cholesky's factors.

    Args:
        normal: The matrix, (n, n), of which the lower half is read.
        right: The right sides, (n,).
        found: The solution, (n,); written to.
        count: How many equations.
    """
    upper = np.empty((count, count))  # rows of the factor's transpose: its inner loop runs along them
    for j in range(count):
        for i in range(j, count):
            upper[j, i] = normal[i, j]
        for k in range(j):
            factor = upper[k, j]
            for i in range(j, count):
                upper[j, i] -= factor * upper[k, i]
        pivot = upper[j, j] = math.sqrt(upper[j, j])
        for i in range(j + 1, count):
            upper[j, i] /= pivot
    for i in range(count):
        found[i] = right[i]
        for j in range(i):
            found[i] -= upper[j, i] * found[j]
        found[i] /= upper[i, i]
    for i in range(count - 1, -1, -1):
        for k in range(i + 1, count):
            found[i] -= upper[i, k] * found[k]
        found[i] /= upper[i, i]
