"""What stands between a point and some balls, never too little; and all shapes as compiled functions take them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry import raycast
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
TINY = 1e-30


class Shapes(NamedTuple):
    """All shapes of a model, as compiled functions take them; the arrays follow the data they came from.

    Attributes:
        kinds: MuJoCo's types, (ngeom,).
        formless: Whether there is no formula for a ray that meets it: meshes, (ngeom,).
        sizes: Half sizes as MuJoCo keeps them, metres, (ngeom, 3).
        bounds: Middles and half sizes of the boxes around them, in their own frames, metres, (ngeom, 6).
        radii: Radii of balls about their positions that hold these boxes, infinite for planes, metres, (ngeom,).
        bodies: To which body each belongs, (ngeom,).
        positions: Where they are in the world, metres, (ngeom, 3).
        matrices: How they are turned, (ngeom, 9).
    """

    kinds: NDArray[np.int64]
    formless: NDArray[np.bool_]
    sizes: Array
    bounds: Array
    radii: Array
    bodies: NDArray[np.int32]
    positions: Array
    matrices: Array


@compiled
def stand_between(
    of: Shapes, candidates: Indices, but_body: int, origin: Array, centers: Array, radii_m: Array
) -> Indices:
    """Those of some shapes in whose box, grown by a ball's radius, the line from a point to the ball's centre runs.

    All rays to the ball lie that near to the line. A plane counts unless point and balls are above it.
    """
    found, count = np.empty(len(candidates), dtype=np.intp), 0
    kinds, bounds, positions, matrices = of.kinds, of.bounds, of.positions, of.matrices
    reaches, bodies = of.radii, of.bodies
    ox, oy, oz = origin[0], origin[1], origin[2]
    cx, cy, cz, radius_m = one_ball(centers, radii_m)
    wx, wy, wz = cx - ox, cy - oy, cz - oz
    squared = max(wx * wx + wy * wy + wz * wz, TINY)
    for shape in candidates:
        if bodies[shape] == but_body:
            continue
        x, y, z = positions[shape, 0] - ox, positions[shape, 1] - oy, positions[shape, 2] - oz
        share = min(max((x * wx + y * wy + z * wz) / squared, 0.0), 1.0)
        ax, ay, az = x - share * wx, y - share * wy, z - share * wz
        reach = reaches[shape] + radius_m
        if ax * ax + ay * ay + az * az > reach * reach:
            continue
        px, py, pz = into_shape(matrices, shape, -x, -y, -z)
        for ball in range(len(radii_m)):
            radius = radii_m[ball]
            dx, dy, dz = centers[ball, 0] - ox, centers[ball, 1] - oy, centers[ball, 2] - oz
            dx, dy, dz = into_shape(matrices, shape, dx, dy, dz)
            if kinds[shape] == raycast.PLANE:
                near = min(pz, pz + dz - radius) <= 0.0
            else:
                bx, by, bz = px - bounds[shape, 0], py - bounds[shape, 1], pz - bounds[shape, 2]
                sx, sy, sz = bounds[shape, 3] + radius, bounds[shape, 4] + radius, bounds[shape, 5] + radius
                near = abs(bx) <= sx and abs(by) <= sy and abs(bz) <= sz
                near = near or raycast.box(sx, sy, sz, bx, by, bz, dx, dy, dz) <= 1.0
            if near:
                found[count] = shape
                count += 1
                break
    return found[:count]


@compiled
def into_shape(matrices: Array, shape: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of the world in the frame of a shape, turned as its matrix, (9,) row by row, says."""
    return (
        x * matrices[shape, 0] + y * matrices[shape, 3] + z * matrices[shape, 6],
        x * matrices[shape, 1] + y * matrices[shape, 4] + z * matrices[shape, 7],
        x * matrices[shape, 2] + y * matrices[shape, 5] + z * matrices[shape, 8],
    )


@compiled
def one_ball(centers: Array, radii_m: Array) -> tuple[float, float, float, float]:
    """Centre and radius of a ball that holds some balls."""
    cx, cy, cz, radius_m = 0.0, 0.0, 0.0, 0.0
    for k in range(len(radii_m)):
        cx, cy, cz = cx + centers[k, 0], cy + centers[k, 1], cz + centers[k, 2]
    cx, cy, cz = cx / len(radii_m), cy / len(radii_m), cz / len(radii_m)
    for k in range(len(radii_m)):
        x, y, z = centers[k, 0] - cx, centers[k, 1] - cy, centers[k, 2] - cz
        radius_m = max(radius_m, math.sqrt(x * x + y * y + z * z) + radii_m[k])
    return cx, cy, cz, radius_m
