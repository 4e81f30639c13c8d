"""The gaze: where eyes are when their head aims at points, and whether these lie in view. Compiled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.cells import LANES
from taskgist.perspective.maps.seen.aiming import (
    AHEAD,
    ASIDE,
    EYE,
    INNER_COS,
    INNER_SIN,
    OUTER_COS,
    OUTER_SIN,
    ROWS,
    X,
    Y,
    Z,
    about,
    aim_all,
    outer_axis,
    part_of_head,
    within_head,
)
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
PLACE, TURNED, EYE_COLUMNS = 12, 14, 15
"""Columns of a table of eyes, one row for each trial: its position with the head in its middle; its axes, the columns
of a matrix, row by row; where the base stands if the agent turns to what it looks at, and 1 if it does: then all else
is given in the frame under the base that looks along the chest."""
EYE_X, EYE_Y, EYE_Z, IN_VIEW, AWAY, TURN_COS, TURN_SIN = (LANES * row for row in range(9, 16))
"""More rows of the workspace: where the eye gets to, in the frame of its eye; 1 for points in view; how far these are
over the floor from the base of an agent that turns, and cosine and sine of the direction."""
CONE_COS, ACROSS_TAN, UP_TAN = range(3)
"""What the eye sees at once: cosine of the gaze cone's half-angle, and tangents of half the view."""
LIMIT_COS, LIMIT_SIN = 3, 4
"""Columns of a table of cones in the eye's frame, its head in the middle: axis, and cosine and sine of half the angle.
All that is ever seen lies in each of them."""


@compiled
def look_all(head: Array, view: Array, work: Array, count: int) -> None:
    """Aim the head at each of some points, and find out where the eye is then, and whether they are in view."""
    aim_all(head, work, count)
    outer, eye = outer_axis(head), part_of_head(head, EYE)
    ahead_part, aside_part = part_of_head(head, AHEAD), part_of_head(head, ASIDE)
    cone_cos, across_tan, up_tan = view[CONE_COS], view[ACROSS_TAN], view[UP_TAN]
    for lane in range(count):
        cos, sin = work[INNER_COS + lane], work[INNER_SIN + lane]
        turn_cos, turn_sin = work[OUTER_COS + lane], work[OUTER_SIN + lane]
        ix, iy, iz = within_head(eye, cos, sin)
        fx, fy, fz = within_head(ahead_part, cos, sin)
        sx, sy, sz = within_head(aside_part, cos, sin)
        px, py, pz = about(outer, turn_cos, -turn_sin, work[X + lane], work[Y + lane], work[Z + lane])
        dx, dy, dz = px - ix, py - iy, pz - iz
        ahead, aside = dx * fx + dy * fy + dz * fz, dx * sx + dy * sy + dz * sz
        squared = dx * dx + dy * dy + dz * dz
        up = math.sqrt(max(squared - ahead * ahead - aside * aside, 0.0))
        inside = (ahead > 0.0) & (ahead >= cone_cos * math.sqrt(squared))
        inside = inside & (abs(aside) <= across_tan * ahead) & (up <= up_tan * ahead)
        work[IN_VIEW + lane] = 1.0 if inside else 0.0
        work[EYE_X + lane], work[EYE_Y + lane], work[EYE_Z + lane] = about(outer, turn_cos, turn_sin, ix, iy, iz)


@compiled
def show_points(points: Array, lanes: Indices, which: int, count: int, eyes: Array, trial: int, work: Array) -> None:
    """Bring the points in one row of ``lanes`` into the workspace, as a trial has them."""
    for lane in range(count):
        row = lanes[which, lane]
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        if eyes[trial, TURNED] != 0.0:
            x, y = x - eyes[trial, PLACE], y - eyes[trial, PLACE + 1]
            away = math.hypot(x, y)
            cos, sin = (x / away, y / away) if away > 1e-9 else (1.0, 0.0)
            work[AWAY + lane], work[TURN_COS + lane], work[TURN_SIN + lane] = away, cos, sin
            x, y = away, 0.0
        work[X + lane], work[Y + lane], work[Z + lane] = in_eye(eyes, trial, x, y, z)


@compiled
def shown_eye(eyes: Array, trial: int, work: Array, lane: int) -> tuple[float, float, float, float, float]:
    """Where the eye is that looks at a point of the workspace: in the trial's own frame, then x and y in the world."""
    x, y, z = in_trial(eyes, trial, work[EYE_X + lane], work[EYE_Y + lane], work[EYE_Z + lane])
    if eyes[trial, TURNED] == 0.0:
        return x, y, z, x, y
    cos, sin = work[TURN_COS + lane], work[TURN_SIN + lane]
    return x, y, z, cos * x - sin * y + eyes[trial, PLACE], sin * x + cos * y + eyes[trial, PLACE + 1]


@compiled
def eye_positions(points: Array, rows: Indices, head: Array, view: Array, eyes: Array, trial: int) -> Array:
    """Where the eye of a trial is when the head aims at each of some points, metres in the world, (n, 3)."""
    found, work = np.empty((len(rows), 3)), np.empty(ROWS * LANES)
    for start in range(0, len(rows), LANES):
        count = min(LANES, len(rows) - start)
        show_points(points, rows[start : start + count].reshape(1, count), 0, count, eyes, trial, work)
        look_all(head, view, work, count)
        for lane in range(count):
            _, _, z, x, y = shown_eye(eyes, trial, work, lane)
            found[start + lane, 0], found[start + lane, 1], found[start + lane, 2] = x, y, z
    return found


@compiled
def out_of_cones(cones: Array, swing: float, x: float, y: float, z: float) -> bool:
    """Whether a point of the eye's frame is plainly out of view, however the head turns and wherever the eye goes.

    Args:
        cones: All that is seen lies in each.
        swing: How far eye and point move at most, together.
        x: The point; all in metres.
        y: As above.
        z: As above.
    """
    away = math.sqrt(x * x + y * y + z * z)
    if away <= swing:
        return False
    sin = swing / away
    cos = math.sqrt(1.0 - sin * sin)
    for cone in range(len(cones)):
        limit_cos, limit_sin = cones[cone, LIMIT_COS], cones[cone, LIMIT_SIN]
        narrow = limit_cos * sin + limit_sin * cos > 0.0  # both angles make less than half a circle
        along = x * cones[cone, 0] + y * cones[cone, 1] + z * cones[cone, 2]
        if narrow and along < away * (limit_cos * cos - limit_sin * sin):
            return True
    return False


@compiled
def in_eye(eyes: Array, trial: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point in the frame of a trial's eye, its head in the middle."""
    dx, dy, dz = x - eyes[trial, 0], y - eyes[trial, 1], z - eyes[trial, 2]
    return (
        dx * eyes[trial, 3] + dy * eyes[trial, 6] + dz * eyes[trial, 9],
        dx * eyes[trial, 4] + dy * eyes[trial, 7] + dz * eyes[trial, 10],
        dx * eyes[trial, 5] + dy * eyes[trial, 8] + dz * eyes[trial, 11],
    )


@compiled
def in_trial(eyes: Array, trial: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """The reverse of ``in_eye``: a point of the eye's frame in the one in which its trial is told."""
    return (
        x * eyes[trial, 3] + y * eyes[trial, 4] + z * eyes[trial, 5] + eyes[trial, 0],
        x * eyes[trial, 6] + y * eyes[trial, 7] + z * eyes[trial, 8] + eyes[trial, 1],
        x * eyes[trial, 9] + y * eyes[trial, 10] + z * eyes[trial, 11] + eyes[trial, 2],
    )
