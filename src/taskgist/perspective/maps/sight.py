"""Sight of cells: does the eye see the centre of each, when the head aims at it? Compiled loops over cells.

A cell is seen if its centre lies in the gaze cone and in the field of view, and no seen shape is met on the straight
line from the eye. What hid a cell last is tried first the next time: it mostly does so again.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.head import AHEAD, ASIDE, EYE, SWING, aimed, into_head, out_of_head, within_head
from taskgist.world.geometry import raycast
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
NOT_SEEN, SEEN, SEEN_UNLESS_MESH = 0, 1, 2
APART, BETWEEN, MAY_BE = 0, 1, 2
END = 1.0 - 1e-9
"""Share of the way to a cell's centre on which something hides it."""
NONE = -1


KIND, SIZE, BOUNDS, RADIUS, POSITION, MATRIX, COLUMNS = 0, 1, 4, 10, 11, 14, 23
"""Columns of a table of shapes: MuJoCo's type; half sizes; middle and half sizes of the box around it, in its frame;
radius of the sphere around it, infinite for planes; position; rotation row by row. Metres."""
PLACE, TURNED = 12, 14
"""Parts of the row that tells where an eye is: its position with the head in its middle; its axes, the columns of a
matrix, row by row; where the base stands if the agent turns to what it looks at, and 1 if it does: then all else is
given in the frame under the base that looks along the chest. One array, as compiled code passes it on for nothing."""


CONE_COS, ACROSS_TAN, UP_TAN, OFF_COS, OFF_SIN = range(5)
"""Parts of the row that tells what the eye sees at once: cosine of the gaze cone's half-angle; tangents of half the
view; cosine and sine of the angle beyond which nothing is seen however the head turns, −1 and 0 if there is none."""


@compiled
def seen_cells(
    centers: Array,
    cells: Indices,
    head: Array,
    gaze: Array,
    eyes: Array,
    own: Array,
    things: Array,
    hider: NDArray[np.int32],
) -> NDArray[np.uint8]:
    """Whether each of some cells is seen when the head aims at it.

    Args:
        centers: Centres of all cells, metres in the world, (cells, 3).
        cells: Which are asked for, (n,).
        head: How the head moves; not at all with limits of zero.
        gaze: What the eye sees at once.
        eyes: Where it is.
        own: The agent's own shapes but those of its head, in the frame of ``eyes``.
        things: All others, in the world.
        hider: What hid each cell last, an index into ``things`` or −1, (cells,); kept up to date.

    Returns:
        ``NOT_SEEN``, ``SEEN``, or ``SEEN_UNLESS_MESH`` where the line passes the box around a mesh, (n,).
    """
    found = np.zeros(len(cells), dtype=np.uint8)
    for row in range(len(cells)):
        cell = cells[row]
        x, y, z = centers[cell, 0], centers[cell, 1], centers[cell, 2]
        cos, sin, px, py = 1.0, 0.0, 0.0, 0.0
        if eyes[TURNED] != 0.0:
            px, py = eyes[PLACE], eyes[PLACE + 1]
            away = math.hypot(x - px, y - py)
            if away > 1e-9:
                cos, sin = (x - px) / away, (y - py) / away
            x, y = away, 0.0
        ex, ey, ez, inside = _gazing(head, gaze, eyes, x, y, z)
        if not inside:
            continue
        wx, wy = cos * ex - sin * ey + px, sin * ex + cos * ey + py
        tx, ty = centers[cell, 0], centers[cell, 1]
        if hider[cell] != NONE and _hides(things, hider[cell], wx, wy, ez, tx, ty, z) == BETWEEN:
            continue
        first, mesh = _first_hiding(own, ex, ey, ez, x, y, z)
        if first != NONE:
            continue
        first, far_mesh = _first_hiding(things, wx, wy, ez, tx, ty, z)
        if first != NONE:
            hider[cell] = first
            continue
        found[row] = SEEN_UNLESS_MESH if mesh or far_mesh else SEEN
    return found


@compiled
def eye_positions(centers: Array, cells: Indices, head: Array, eyes: Array) -> Array:
    """Where the eye is when the head aims at each of some cells, metres in the world, (n, 3)."""
    found = np.empty((len(cells), 3))
    for row in range(len(cells)):
        x, y, z = centers[cells[row], 0], centers[cells[row], 1], centers[cells[row], 2]
        cos, sin, px, py = 1.0, 0.0, 0.0, 0.0
        if eyes[TURNED] != 0.0:
            px, py = eyes[PLACE], eyes[PLACE + 1]
            away = math.hypot(x - px, y - py)
            if away > 1e-9:
                cos, sin = (x - px) / away, (y - py) / away
            x, y = away, 0.0
        lx, ly, lz = _in_eye(eyes, x, y, z)
        aim = aimed(head, lx, ly, lz)
        ix, iy, iz = within_head(head, aim, EYE)
        ox, oy, oz = out_of_head(head, aim, ix, iy, iz)
        ex, ey, ez = _from_eye(eyes, ox, oy, oz)
        found[row, 0], found[row, 1], found[row, 2] = cos * ex - sin * ey + px, sin * ex + cos * ey + py, ez
    return found


@compiled
def hidden_from_box(
    centers: Array, cells: Indices, things: Array, hider: NDArray[np.int32], low: Array, high: Array
) -> NDArray[np.bool_]:
    """Whether what hid each cell last hides it from everywhere in a box.

    The shadow of a convex shape is convex: what lies in it with all its corners lies in it as a whole.
    """
    found = np.zeros(len(cells), dtype=np.bool_)
    for row in range(len(cells)):
        cell = cells[row]
        if hider[cell] == NONE:
            continue
        x, y, z = centers[cell, 0], centers[cell, 1], centers[cell, 2]
        hidden = True
        for corner in range(8):
            cx = high[0] if corner & 1 else low[0]
            cy = high[1] if corner & 2 else low[1]
            cz = high[2] if corner & 4 else low[2]
            if _hides(things, hider[cell], cx, cy, cz, x, y, z) != BETWEEN:
                hidden = False
                break
        found[row] = hidden
    return found


@compiled
def _gazing(head: Array, gaze: Array, eyes: Array, x: float, y: float, z: float) -> tuple[float, float, float, bool]:
    """Where the eye is when the head aims at a point, and whether the point lies in cone and field of view then."""
    lx, ly, lz = _in_eye(eyes, x, y, z)
    if _far_off(head, gaze, lx, math.sqrt(lx * lx + ly * ly + lz * lz)):
        return 0.0, 0.0, 0.0, False
    aim = aimed(head, lx, ly, lz)
    ix, iy, iz = within_head(head, aim, EYE)
    fx, fy, fz = within_head(head, aim, AHEAD)
    sx, sy, sz = within_head(head, aim, ASIDE)
    px, py, pz = into_head(head, aim, lx, ly, lz)
    dx, dy, dz = px - ix, py - iy, pz - iz
    ahead, aside = dx * fx + dy * fy + dz * fz, dx * sx + dy * sy + dz * sz
    squared = dx * dx + dy * dy + dz * dz
    up = math.sqrt(max(squared - ahead * ahead - aside * aside, 0.0))
    inside = ahead > 0.0 and ahead >= gaze[CONE_COS] * math.sqrt(squared)
    inside = inside and abs(aside) <= gaze[ACROSS_TAN] * ahead and up <= gaze[UP_TAN] * ahead
    ox, oy, oz = out_of_head(head, aim, ix, iy, iz)
    wx, wy, wz = _from_eye(eyes, ox, oy, oz)
    return wx, wy, wz, inside


@compiled
def _far_off(head: Array, gaze: Array, ahead: float, away: float) -> bool:
    """Whether a point is plainly out of the gaze however the head turns, wherever that brings the eye."""
    if away <= head[SWING] or gaze[OFF_COS] <= -1.0:
        return False
    sin = head[SWING] / away
    cos = math.sqrt(1.0 - sin * sin)
    if gaze[OFF_COS] * sin + gaze[OFF_SIN] * cos <= 0.0:  # the two angles make more than half a circle
        return False
    return bool(ahead < away * (gaze[OFF_COS] * cos - gaze[OFF_SIN] * sin))


@compiled
def _in_eye(eyes: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    dx, dy, dz = x - eyes[0], y - eyes[1], z - eyes[2]
    return (
        dx * eyes[3] + dy * eyes[6] + dz * eyes[9],
        dx * eyes[4] + dy * eyes[7] + dz * eyes[10],
        dx * eyes[5] + dy * eyes[8] + dz * eyes[11],
    )


@compiled
def _from_eye(eyes: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    return (
        x * eyes[3] + y * eyes[4] + z * eyes[5] + eyes[0],
        x * eyes[6] + y * eyes[7] + z * eyes[8] + eyes[1],
        x * eyes[9] + y * eyes[10] + z * eyes[11] + eyes[2],
    )


@compiled
def _first_hiding(shapes: Array, ex: float, ey: float, ez: float, x: float, y: float, z: float) -> tuple[int, bool]:
    """A shape between two points, −1 for none; and whether a mesh may be, too."""
    dx, dy, dz = x - ex, y - ey, z - ez
    inverse = 1.0 / (dx * dx + dy * dy + dz * dz)
    mesh = False
    for shape in range(len(shapes)):
        gx, gy, gz = shapes[shape, POSITION] - ex, shapes[shape, POSITION + 1] - ey, shapes[shape, POSITION + 2] - ez
        share = min(1.0, max(0.0, (gx * dx + gy * dy + gz * dz) * inverse))
        gx, gy, gz = gx - share * dx, gy - share * dy, gz - share * dz
        if gx * gx + gy * gy + gz * gz > shapes[shape, RADIUS] ** 2:
            continue
        met = _hides(shapes, shape, ex, ey, ez, x, y, z)
        if met == BETWEEN:
            return shape, mesh
        mesh = mesh or met == MAY_BE
    return NONE, mesh


@compiled
def _hides(shapes: Array, shape: int, ex: float, ey: float, ez: float, x: float, y: float, z: float) -> int:
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
