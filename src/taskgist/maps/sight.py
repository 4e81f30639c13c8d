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

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.maps.footing import (
    DOUBTFUL,
    FIRST,
    INNER,
    LEAF,
    LOST,
    PAST,
    WON,
    Ball,
    Sweep,
    Tree,
    ball_around_cells,
    best_of,
    judge_all,
)
from taskgist.maps.gaze import (
    AWAY,
    IN_VIEW,
    PLACE,
    ROWS,
    SWING,
    TURNED,
    in_eye,
    look_all,
    out_of_cones,
    show_points,
    shown_eye,
)
from taskgist.maps.grid import LANES
from taskgist.world.geometry import rays as raycast

# --- Shadows: whether shapes stand between an eye and a point. Compiled.
#
# Shapes are rows of a table, all in one frame.

APART, BETWEEN, MAY_BE = 0, 1, 2
END = 1.0 - 1e-9
"""Share of the way to a point on which something hides it."""
NONE = -1
KIND, SIZE, BOUNDS, RADIUS, POSITION, MATRIX, COLUMNS = 0, 1, 4, 10, 11, 14, 23
"""Columns of a table of shapes: MuJoCo's type; half sizes; middle and half sizes of the box around it, in its frame;
radius of the sphere around it, infinite for planes; position; rotation row by row. Metres."""


@compiled
def near_line(
    shapes: Array,
    start: int,
    end: int,
    ex: float,
    ey: float,
    ez: float,
    x: float,
    y: float,
    z: float,
    wide: float,
    near: NDArray[np.int32],
    which: int,
) -> int:
    """Lists the shapes that may stand between two points, or points not farther from these than a width; how many."""
    dx, dy, dz = x - ex, y - ey, z - ez
    squared = dx * dx + dy * dy + dz * dz
    inverse = 1.0 / squared if squared > 0.0 else 0.0
    count = 0
    for shape in range(start, end):
        gx, gy, gz = shapes[shape, POSITION] - ex, shapes[shape, POSITION + 1] - ey, shapes[shape, POSITION + 2] - ez
        share = min(1.0, max(0.0, (gx * dx + gy * dy + gz * dz) * inverse))
        gx, gy, gz = gx - share * dx, gy - share * dy, gz - share * dz
        reach = shapes[shape, RADIUS] + wide
        if gx * gx + gy * gy + gz * gz <= reach * reach:
            near[which, count] = shape
            count += 1
    return count


@compiled
def first_hiding(
    shapes: Array,
    near: NDArray[np.int32],
    which: int,
    count: int,
    ex: float,
    ey: float,
    ez: float,
    x: float,
    y: float,
    z: float,
) -> tuple[int, bool]:
    """The first of some shapes between two points, −1 for none; and whether a mesh may be, too."""
    dx, dy, dz = x - ex, y - ey, z - ez
    inverse = 1.0 / (dx * dx + dy * dy + dz * dz)
    mesh = False
    for place in range(count):
        shape = near[which, place]
        gx, gy, gz = shapes[shape, POSITION] - ex, shapes[shape, POSITION + 1] - ey, shapes[shape, POSITION + 2] - ez
        share = min(1.0, max(0.0, (gx * dx + gy * dy + gz * dz) * inverse))
        gx, gy, gz = gx - share * dx, gy - share * dy, gz - share * dz
        if gx * gx + gy * gy + gz * gz > shapes[shape, RADIUS] ** 2:
            continue
        met = hides(shapes, shape, ex, ey, ez, x, y, z)
        if met == BETWEEN:
            return shape, mesh
        mesh = mesh or met == MAY_BE
    return NONE, mesh


@compiled
def hidden_from_box(shapes: Array, shape: int, boxes: Array, box: int, x: float, y: float, z: float) -> bool:
    """Whether a shape hides a point from everywhere in a box, the row of a table (least, greatest coordinates).

    The shadow of a convex shape is convex: what lies in it with all its corners lies in it as a whole.
    """
    for corner in range(8):
        cx = boxes[box, 3] if corner & 1 else boxes[box, 0]
        cy = boxes[box, 4] if corner & 2 else boxes[box, 1]
        cz = boxes[box, 5] if corner & 4 else boxes[box, 2]
        if hides(shapes, shape, cx, cy, cz, x, y, z) != BETWEEN:
            return False
    return True


@compiled
def hides(shapes: Array, shape: int, ex: float, ey: float, ez: float, x: float, y: float, z: float) -> int:
    """Whether a shape stands between two points: ``BETWEEN`` if so, ``MAY_BE`` if it may, being a mesh."""
    p, m, s, b = POSITION, MATRIX, SIZE, BOUNDS
    gx, gy, gz = ex - shapes[shape, p], ey - shapes[shape, p + 1], ez - shapes[shape, p + 2]
    dx, dy, dz = x - ex, y - ey, z - ez
    px = gx * shapes[shape, m] + gy * shapes[shape, m + 3] + gz * shapes[shape, m + 6]
    py = gx * shapes[shape, m + 1] + gy * shapes[shape, m + 4] + gz * shapes[shape, m + 7]
    pz = gx * shapes[shape, m + 2] + gy * shapes[shape, m + 5] + gz * shapes[shape, m + 8]
    wx = dx * shapes[shape, m] + dy * shapes[shape, m + 3] + dz * shapes[shape, m + 6]
    wy = dx * shapes[shape, m + 1] + dy * shapes[shape, m + 4] + dz * shapes[shape, m + 7]
    wz = dx * shapes[shape, m + 2] + dy * shapes[shape, m + 5] + dz * shapes[shape, m + 8]
    kind = int(shapes[shape, KIND])
    if kind in raycast.FORMULAS:
        sx, sy, sz = shapes[shape, s], shapes[shape, s + 1], shapes[shape, s + 2]
        return BETWEEN if raycast.surface(kind, sx, sy, sz, px, py, pz, wx, wy, wz) < END else APART
    px, py, pz = px - shapes[shape, b], py - shapes[shape, b + 1], pz - shapes[shape, b + 2]
    sx, sy, sz = shapes[shape, b + 3], shapes[shape, b + 4], shapes[shape, b + 5]
    within = abs(px) <= sx and abs(py) <= sy and abs(pz) <= sz
    return MAY_BE if within or raycast.box(sx, sy, sz, px, py, pz, wx, wy, wz) <= 1.0 else APART


# --- Shade: which of the points in view something hides from an eye. Compiled loops over the points of a block.

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
