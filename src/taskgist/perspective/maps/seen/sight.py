"""Sight of cells: does an eye see the centre of each, when the head aims at it? Compiled loops over blocks of cells.

A cell is seen if its centre lies in the gaze cone and in the field of view, and no seen shape is met on the straight
line from the eye. Of a whole block of cells it is often plain that a trial does not see it, and which few shapes may
stand between. What hid a cell last is tried first the next time: it mostly does so again, and where it hides the cell
from a whole box of eyes, none of these is tried.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.cells import LANES
from taskgist.perspective.maps.seen.aiming import ROWS, SWING
from taskgist.perspective.maps.seen.gaze import IN_VIEW, PLACE, TURNED, in_eye, look_all, out_of_cones, show_points
from taskgist.perspective.maps.seen.shade import Shadows, room_for, shade_all
from taskgist.perspective.maps.seen.shadow import NONE, hidden_from_box
from taskgist.perspective.maps.tree import INNER, LEAF, PAST, Tree
from taskgist.perspective.maps.trials import FIRST, WON, Ball, Sweep, ball_around_cells, best_of, judge_all
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
UNRATED = np.inf
LEFT, UNTIL, ACTIVE, ROW = range(4)
"""What is noted of a block: cells that are left, and from which node on; those now asked for, and their rows."""
WORTH_A_LOOK = 15
"""Nodes under smaller ones are tried without asking whether they are in vain."""


class Eyes(NamedTuple):
    """How trials see.

    Attributes:
        head: How the head moves.
        at_once: What an eye sees at once.
        cones: In which lies all that it ever sees, (n, columns).
        eyes: Where it is in each trial, (trials, columns).
        first: Trials of which the best come before all others, (k,).
        tree: The trials, by where their eyes may be.
    """

    head: Array
    at_once: Array
    cones: Array
    eyes: Array
    first: Indices
    tree: Tree


@compiled
def seen_cells(seeing: Eyes, shadows: Shadows, sweep: Sweep, starts: Indices) -> None:
    """Note what trials find out about some cells.

    Args:
        seeing: How they see.
        shadows: What hides cells.
        sweep: The cells, block by block; filled.
        starts: Where blocks begin among them, and where the last one ends, (blocks + 1,).
    """
    head, at_once, cones, eyes, first, (nodes, boxes) = seeing
    points, rows, found, asks, free, asked, facing = sweep
    lanes, work = np.empty((4, LANES), dtype=np.intp), np.empty(ROWS * LANES)
    scores, best, near = np.empty(len(eyes)), np.empty(FIRST, dtype=np.intp), room_for(shadows)
    way, own, own_count, things, hider = shadows
    for block in range(len(starts) - 1):
        count = starts[block + 1] - starts[block]
        ball = ball_around_cells(points, rows, starts[block], starts[block + 1])
        swing = head[SWING] + ball[3]
        scores[:] = UNRATED
        for trial in first:
            scores[trial] = _rate(cones, eyes, trial, ball, swing)
        for lane in range(count):
            lanes[LEFT, lane], lanes[UNTIL, lane] = starts[block] + lane, 0
        node, place, hopeful = 0, 0, best_of(scores, first, best)
        while count and node < len(nodes):
            at, trial = node, nodes[node, LEAF]
            if place < hopeful:
                at, trial = 0, best[place]
                place += 1
            elif trial == INNER:
                worth = nodes[node, PAST] - node >= WORTH_A_LOOK
                node = _next_node(points, rows, things, hider, nodes, boxes, lanes, node, count) if worth else node + 1
                continue
            else:
                node += 1
                if scores[trial] == UNRATED:
                    scores[trial] = _rate(cones, eyes, trial, ball, swing)
                if scores[trial] == -np.inf:
                    continue
            scores[trial] = -np.inf
            asking = _still_asking(rows, lanes, at, count)
            show_points(points, lanes, ROW, asking, eyes, trial, work)
            look_all(head, at_once, work, asking)
            shade_all(
                points, lanes, ROW, ball, head[SWING], eyes, trial, way[trial], own, own_count, things, hider, near,
                work, asking,
            )  # fmt: skip
            x, y = eyes[trial, PLACE], eyes[trial, PLACE + 1]
            judge_all(points, rows, found, asks, free, asked, facing, lanes, ACTIVE, work, IN_VIEW, asking, trial, x, y)
            count = _still_left(found, asks, lanes, count)


@compiled
def _still_asking(rows: Indices, lanes: Indices, node: int, count: int) -> int:
    """Lists the cells for which a node is not in vain; how many there are."""
    asking = 0
    for lane in range(count):
        if lanes[UNTIL, lane] <= node:
            lanes[ACTIVE, asking], lanes[ROW, asking] = lanes[LEFT, lane], rows[lanes[LEFT, lane]]
            asking += 1
    return asking


@compiled
def _still_left(found: NDArray[np.uint8], asks: NDArray[np.int8], lanes: Indices, count: int) -> int:
    """Keeps the cells of a block that are not won, and may still ask; how many there are."""
    kept = 0
    for lane in range(count):
        place = lanes[LEFT, lane]
        if found[place] != WON and asks[place] >= 0:
            lanes[LEFT, kept], lanes[UNTIL, kept] = place, lanes[UNTIL, lane]
            kept += 1
    return kept


@compiled
def _rate(cones: Array, eyes: Array, trial: int, ball: Ball, swing: float) -> float:
    """How well a trial fits a block of cells: the straighter it looks there the better; −∞ if it plainly does not."""
    x, y, z, _ = ball
    if eyes[trial, TURNED] != 0.0:
        x, y = math.hypot(x - eyes[trial, PLACE], y - eyes[trial, PLACE + 1]), 0.0
    x, y, z = in_eye(eyes, trial, x, y, z)
    if out_of_cones(cones, swing, x, y, z):
        return -np.inf
    along = x * cones[0, 0] + y * cones[0, 1] + z * cones[0, 2]
    return float(along / max(math.sqrt(x * x + y * y + z * z), 1e-9))


@compiled
def _next_node(
    points: Array,
    rows: Indices,
    things: Array,
    hider: NDArray[np.int32],
    nodes: Indices,
    boxes: Array,
    lanes: Indices,
    node: int,
    count: int,
) -> int:
    """The next node that is not in vain for all of some cells; notes until where it is for each."""
    following = len(nodes)
    for lane in range(count):
        if lanes[UNTIL, lane] <= node:
            row = rows[lanes[LEFT, lane]]
            x, y, z = points[row, 0], points[row, 1], points[row, 2]
            hidden = hider[row] != NONE and hidden_from_box(things, hider[row], boxes, node, x, y, z)
            lanes[UNTIL, lane] = nodes[node, PAST] if hidden else node + 1
        following = min(following, lanes[UNTIL, lane])
    return following
