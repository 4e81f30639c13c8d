"""Boxes around shapes: two shapes are no nearer, and overlap no deeper, than their boxes.

Boxes are rows of one table, (n, 18), so that compiled functions pass two numbers instead of many arrays:

======= ==============================================================================================
columns what
======= ==============================================================================================
0-2     middle, metres
3-11    how the box is turned, a matrix row by row: its columns are the box's axes
12-14   half sizes, metres
15      radius of a ball about the middle that holds the shape, metres
16      radius of a ball about the middle that lies within the shape, metres; 0 where none is known
17      1 if the shape is a box itself: then what is said of the box is said of the shape
======= ==============================================================================================

An endless plane is a block of ``ENDLESS_M`` beneath it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.raycast import BOX, SPHERE

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
COLUMNS = 18
TURNED, HALF, RADIUS, INNER, EXACT = 3, 12, 15, 16, 17
ENDLESS_M = 1e5


@compiled
def boxes_of(
    geoms: Indices, kinds: NDArray[np.int64], radii: Array, bounds: Array, positions: Array, matrices: Array
) -> Array:
    """Boxes around shapes, (n, 18).

    Args:
        geoms: Indices of the shapes, (n,).
        kinds: MuJoCo's type of every shape of the model, (ngeom,).
        radii: Radii of balls that hold the shapes, metres, infinite for planes, (ngeom,).
        bounds: Middles and half sizes of their boxes, in their own frames, (ngeom, 6).
        positions: Where they are, metres, (ngeom, 3).
        matrices: How they are turned, (ngeom, 9).
    """
    table = np.empty((len(geoms), COLUMNS))
    for row in range(len(geoms)):
        geom = geoms[row]
        endless = np.isinf(radii[geom])
        centred = SPHERE <= kinds[geom] <= BOX  # MuJoCo's order: neither plane, height field nor mesh
        off, across, inner = 0.0, 0.0, math.inf if centred else 0.0
        for axis in range(3):
            half = ENDLESS_M if endless else bounds[geom, 3 + axis]
            table[row, HALF + axis] = half
            across, inner = across + half * half, min(inner, half)
            table[row, axis] = positions[geom, axis]
        for k in range(3):
            middle = (-ENDLESS_M if k == 2 else 0.0) if endless else bounds[geom, k]
            off += middle * middle
            for axis in range(3):
                table[row, TURNED + 3 * axis + k] = matrices[geom, 3 * axis + k]
                table[row, axis] += matrices[geom, 3 * axis + k] * middle
        table[row, RADIUS] = min(math.sqrt(across), radii[geom] + math.sqrt(off))
        table[row, INNER], table[row, EXACT] = inner, 1.0 if kinds[geom] == BOX else 0.0
    return table


@compiled
def seen_from(table: Array, position: Array, matrix: Array) -> Array:
    """The same boxes in a frame that is at a position (3,), turned by a matrix (3, 3)."""
    seen = table.copy()
    for row in range(len(table)):
        for axis in range(3):
            seen[row, axis] = 0.0
            for k in range(3):
                seen[row, axis] += matrix[k, axis] * (table[row, k] - position[k])
                turned = 0.0
                for j in range(3):
                    turned += matrix[j, axis] * table[row, TURNED + 3 * j + k]
                seen[row, TURNED + 3 * axis + k] = turned
    return seen


@compiled
def ball_around(table: Array) -> tuple[float, float, float, float]:
    """Middle and radius of a ball that holds the shapes in some boxes, at least one, metres."""
    cx, cy, cz, radius_m = 0.0, 0.0, 0.0, 0.0
    for row in range(len(table)):
        cx, cy, cz = cx + table[row, 0], cy + table[row, 1], cz + table[row, 2]
    cx, cy, cz = cx / len(table), cy / len(table), cz / len(table)
    for row in range(len(table)):
        x, y, z = table[row, 0] - cx, table[row, 1] - cy, table[row, 2] - cz
        radius_m = max(radius_m, math.sqrt(x * x + y * y + z * z) + table[row, RADIUS])
    return cx, cy, cz, radius_m


@compiled
def near_ball(table: Array, cx: float, cy: float, cz: float, radius_m: float) -> Indices:
    """Rows of those boxes whose balls come nearer than a radius to a point, (n,)."""
    found, count = np.empty(len(table), dtype=np.intp), 0
    for row in range(len(table)):
        x, y, z = table[row, 0] - cx, table[row, 1] - cy, table[row, 2] - cz
        reach = radius_m + table[row, RADIUS]
        if x * x + y * y + z * z < reach * reach:
            found[count] = row
            count += 1
    return found[:count]
