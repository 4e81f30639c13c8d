"""Shade: which of the points in view something hides from an eye. Compiled loops over the points of a block."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.seen.gaze import AWAY, IN_VIEW, PLACE, TURNED, shown_eye
from taskgist.perspective.maps.seen.shadow import BETWEEN, NONE, first_hiding, hides, near_line
from taskgist.perspective.maps.trials import DOUBTFUL, LOST, WON, Ball
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
OWN, THINGS = 0, 1
"""Rows of the list of near shapes."""


class Shadows(NamedTuple):
    """What hides cells.

    Attributes:
        way: Which of ``own`` each trial has, (trials,).
        own: The agent's own shapes but those of its head, in the frame of the trials, (ways · k, columns).
        own_count: How many these are, k.
        things: All others, in the world, (m, columns).
        hider: What hid each cell last, an index into ``things`` or −1, (cells,); kept up to date.
    """

    way: NDArray[np.intp]
    own: Array
    own_count: int
    things: Array
    hider: NDArray[np.int32]


@compiled
def room_for(shadows: Shadows) -> NDArray[np.int32]:
    """Room for indices of the near shapes: own, and things, (2, as many as there may be)."""
    return np.empty((2, max(shadows.own_count, len(shadows.things))), dtype=np.int32)


@compiled
def shade_all(
    points: Array,
    lanes: Indices,
    which: int,
    ball: Ball,
    swing: float,
    eyes: Array,
    trial: int,
    way: int,
    own: Array,
    own_count: int,
    things: Array,
    hider: NDArray[np.int32],
    near: NDArray[np.int32],
    work: Array,
    count: int,
) -> None:
    """Find out which of some points in view are hidden.

    ``lanes[which]`` tells the rows of the points. In the workspace ``IN_VIEW`` becomes ``LOST`` where something hides
    a point, ``DOUBTFUL`` where only a mesh may, and ``WON`` elsewhere.
    """
    own_near = things_near = -1
    for lane in range(count):
        if work[IN_VIEW + lane] == LOST:
            continue
        work[IN_VIEW + lane], row = LOST, lanes[which, lane]
        x, y, z = points[row, 0], points[row, 1], points[row, 2]
        ex, ey, ez, wx, wy = shown_eye(eyes, trial, work, lane)
        if hider[row] != NONE and hides(things, hider[row], wx, wy, ez, x, y, z) == BETWEEN:
            continue
        if own_near < 0:
            own_near, things_near = _list_near(ball, swing, eyes, trial, way * own_count, own, own_count, things, near)
        cx, cy = (work[AWAY + lane], 0.0) if eyes[trial, TURNED] != 0.0 else (x, y)
        shape, mesh = first_hiding(own, near, OWN, own_near, ex, ey, ez, cx, cy, z)
        if shape != NONE:
            continue
        shape, far_mesh = first_hiding(things, near, THINGS, things_near, wx, wy, ez, x, y, z)
        if shape != NONE:
            hider[row] = shape
        else:
            work[IN_VIEW + lane] = DOUBTFUL if mesh or far_mesh else WON


@compiled
def _list_near(
    ball: Ball,
    swing: float,
    eyes: Array,
    trial: int,
    start: int,
    own: Array,
    own_count: int,
    things: Array,
    near: NDArray[np.int32],
) -> tuple[int, int]:
    """Lists the shapes that may stand between a trial's eye and a block of cells; how many there are."""
    x, y, z, radius = ball
    ex, ey, ez = eyes[trial, 0], eyes[trial, 1], eyes[trial, 2]
    wx, wy, cx, cy, swing_there = ex, ey, x, y, swing
    if eyes[trial, TURNED] != 0.0:  # the eye goes round the base while the chest turns to each cell of the block
        px, py = eyes[trial, PLACE], eyes[trial, PLACE + 1]
        cx, cy = math.hypot(x - px, y - py), 0.0
        cos, sin = ((x - px) / cx, (y - py) / cx) if cx > 0.0 else (1.0, 0.0)
        wx, wy = cos * ex - sin * ey + px, sin * ex + cos * ey + py
        turn = 2.0 if cx <= radius else min(2.0, math.pi / 2 * radius / cx)
        swing_there += turn * math.hypot(ex, ey)
    wide, wide_there = max(swing, radius), max(swing_there, radius)
    own_near = near_line(own, start, start + own_count, ex, ey, ez, cx, cy, z, wide, near, OWN)
    return own_near, near_line(things, 0, len(things), wx, wy, ez, x, y, z, wide_there, near, THINGS)
