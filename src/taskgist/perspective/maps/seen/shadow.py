"""Shadows: whether shapes stand between an eye and a point. Compiled.

Shapes are rows of a table, all in one frame.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry import raycast
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
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
