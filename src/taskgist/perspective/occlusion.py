"""Occlusion: shapes as one eye has them around it, and which of them hide something from it. Compiled.

Shapes are rows of one table, for compiled functions pass one array on for nothing.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.geometry.rays import BOX, NO_GEOM, Shapes, box, into_shape, surface

HERE = -1.0
"""Type of what stands for a mesh around the eye."""
KIND, SIZE, START, MATRIX, SHAPE, COLUMNS = 0, 1, 4, 7, 16, 17
"""Columns: type; half sizes; the eye in the shape's frame; how the shape is turned, row by row; its index."""
GRAZE_M = 1e-9
"""What hides a surface is nearer to the eye than the surface, by more than rounding."""


@compiled
def from_eye(shapes: Shapes, which: Indices, eye: Array, boxed: bool) -> Array:
    """Shapes seen from an eye, (k, COLUMNS).

    Args:
        shapes: All shapes.
        which: Indices of those that count.
        eye: Where it is, metres, at least (3,).
        boxed: Whether what has no formula counts as the box around it; it is left out otherwise.
    """
    rows, count = np.empty((len(which), COLUMNS)), 0
    kinds, formless, sizes, bounds = shapes.kinds, shapes.formless, shapes.sizes, shapes.bounds
    positions, matrices = shapes.positions, shapes.matrices
    for shape in which:
        if formless[shape] and not boxed:
            continue
        x, y, z = eye[0] - positions[shape, 0], eye[1] - positions[shape, 1], eye[2] - positions[shape, 2]
        start = into_shape(matrices, shape, x, y, z)
        for axis in range(3):
            rows[count, SIZE + axis] = bounds[shape, 3 + axis] if formless[shape] else sizes[shape, axis]
            rows[count, START + axis] = start[axis] - (bounds[shape, axis] if formless[shape] else 0.0)
        rows[count, KIND] = BOX if formless[shape] else kinds[shape]
        if formless[shape] and _inside(rows, count):
            rows[count, KIND] = HERE
        for entry in range(9):
            rows[count, MATRIX + entry] = matrices[shape, entry]
        rows[count, SHAPE] = shape
        count += 1
    return rows[:count]


@compiled_part
def _inside(rows: Array, k: int) -> bool:
    """Whether the eye is inside of a shape's box."""
    x, y, z = abs(rows[k, START]), abs(rows[k, START + 1]), abs(rows[k, START + 2])
    return bool(x <= rows[k, SIZE] and y <= rows[k, SIZE + 1] and z <= rows[k, SIZE + 2])


@compiled
def in_shadow(rows: Array, corners: Array, eye: Array) -> int:
    """A shape that alone hides all that lies between some corners, (n, 3), from the eye; −1 if no box does.

    The shadow that a convex thing throws from an eye outside of it is convex, too.
    """
    for k in range(len(rows)):
        x, y, z = rows[k, START], rows[k, START + 1], rows[k, START + 2]
        sx, sy, sz = rows[k, SIZE] - GRAZE_M, rows[k, SIZE + 1] - GRAZE_M, rows[k, SIZE + 2] - GRAZE_M
        hides = rows[k, KIND] == BOX and (abs(x) > sx or abs(y) > sy or abs(z) > sz)
        for c in range(len(corners)):
            if not hides:
                break
            dx, dy, dz = _turned(rows, k, corners[c, 0] - eye[0], corners[c, 1] - eye[1], corners[c, 2] - eye[2])
            hides = box(sx, sy, sz, x, y, z, dx, dy, dz) <= 1.0
        if hides:
            return int(rows[k, SHAPE])
    return NO_GEOM


@compiled
def away_m(rows: Array, k: int, x: float, y: float, z: float) -> float:
    """How far along a unit direction from the eye a shape is, metres; infinite if it is not there."""
    if rows[k, KIND] == HERE:
        return 0.0
    dx, dy, dz = _turned(rows, k, x, y, z)
    px, py, pz = rows[k, START], rows[k, START + 1], rows[k, START + 2]
    return surface(int(rows[k, KIND]), rows[k, SIZE], rows[k, SIZE + 1], rows[k, SIZE + 2], px, py, pz, dx, dy, dz)


@compiled_part
def _turned(rows: Array, k: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction of the world in the frame of a shape."""
    return (
        x * rows[k, MATRIX] + y * rows[k, MATRIX + 3] + z * rows[k, MATRIX + 6],
        x * rows[k, MATRIX + 1] + y * rows[k, MATRIX + 4] + z * rows[k, MATRIX + 7],
        x * rows[k, MATRIX + 2] + y * rows[k, MATRIX + 5] + z * rows[k, MATRIX + 8],
    )


CLEAR, BOXED, HIDDEN = 0, 1, 2
"""Whether something hides a point: nothing does, at most what counts as the box around it does, or something does."""


@compiled_part
def hidden_point(rows: Array, formless: Mask, seen_from: Array, eye: Array, point: Array) -> int:
    """Whether any of some shapes is met on the straight line from an eye to a point.

    Args:
        rows: The shapes, as an eye near by has them around it.
        formless: Of every shape of the scene, whether it counts as the box around it, (ngeom,).
        seen_from: Where that eye is, metres, at least (3,).
        eye: Where the eye is that looks at the point, metres, at least (3,).
        point: Metres, (3,).
    """
    dx, dy, dz = point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    ox, oy, oz = eye[0] - seen_from[0], eye[1] - seen_from[1], eye[2] - seen_from[2]
    found = CLEAR
    for k in range(len(rows)):
        px, py, pz = _turned(rows, k, ox, oy, oz)
        px, py, pz = px + rows[k, START], py + rows[k, START + 1], pz + rows[k, START + 2]
        sx, sy, sz = rows[k, SIZE], rows[k, SIZE + 1], rows[k, SIZE + 2]
        wx, wy, wz = _turned(rows, k, dx / distance, dy / distance, dz / distance)
        kind = BOX if rows[k, KIND] == HERE else int(rows[k, KIND])
        met = surface(kind, sx, sy, sz, px, py, pz, wx, wy, wz) < distance - GRAZE_M
        if formless[int(rows[k, SHAPE])]:
            found = BOXED if met or (abs(px) <= sx and abs(py) <= sy and abs(pz) <= sz) else found
        elif met:
            return HIDDEN
    return found
