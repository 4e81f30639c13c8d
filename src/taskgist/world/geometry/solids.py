"""Solid shapes as rows of a table: how far points are outside of them, and whether a thick line meets them. Compiled.

Rows are (n, 17):

======= ========================================================================
columns what
======= ========================================================================
0       MuJoCo's type; a mesh counts as the box around it (concave ones were cut into convex parts)
1-3     half sizes as MuJoCo keeps them, metres
4-6     middle, metres
7-15    how it is turned, a matrix row by row: its columns are the shape's axes
16      radius of a ball about the middle that holds it, infinite for planes, metres
======= ========================================================================

A plane is solid beneath, without end, as MuJoCo's is. Height fields meet nothing.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled_part

KIND, SIZE, AT, TURNED, BALL = 0, 1, 4, 7, 16
COLUMNS = 17
PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
FIELD = int(mujoco.mjtGeom.mjGEOM_HFIELD)
SPHERE = int(mujoco.mjtGeom.mjGEOM_SPHERE)
CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
ELLIPSOID = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)
CYLINDER = int(mujoco.mjtGeom.mjGEOM_CYLINDER)
BOX = int(mujoco.mjtGeom.mjGEOM_BOX)
STEP_M = 0.002
"""Least step along a line that is held against a shape: what it grazes by less may be missed."""
TINY = 1e-12


def solids_of(model: mujoco.MjModel, geoms: Indices, positions: Array, matrices: Array) -> Array:
    """A table of shapes, (n, 17).

    Args:
        model: The model.
        geoms: Indices of the shapes, (n,).
        positions: Where they are, metres, (n, 3).
        matrices: How they are turned, (n, 9).
    """
    table = np.empty((len(geoms), COLUMNS))
    kinds, bounds = np.array(model.geom_type[geoms]), model.geom_aabb[geoms]
    boxed = kinds > BOX
    table[:, KIND] = np.where(boxed, BOX, kinds)
    table[:, SIZE : SIZE + 3] = np.where(boxed[:, None], bounds[:, 3:], model.geom_size[geoms])
    off = np.where(boxed[:, None], bounds[:, :3], 0.0)
    table[:, AT : AT + 3] = positions + np.einsum("nij,nj->ni", matrices.reshape(-1, 3, 3), off)
    table[:, TURNED : TURNED + 9] = matrices
    table[:, BALL] = np.linalg.norm(bounds[:, 3:], axis=1)
    table[kinds == PLANE, BALL], table[kinds == FIELD, BALL] = np.inf, -np.inf
    return table


@compiled_part
def outside_m(table: Array, row: int, x: float, y: float, z: float) -> float:
    """How far a point in a shape's own frame is outside of it, metres; negative inside. Ellipsoids roughly."""
    kind = int(table[row, KIND])
    sx, sy, sz = float(table[row, SIZE]), float(table[row, SIZE + 1]), float(table[row, SIZE + 2])
    if kind == PLANE:
        return z
    if kind == BOX:
        qx, qy, qz = abs(x) - sx, abs(y) - sy, abs(z) - sz
        ox, oy, oz = max(qx, 0.0), max(qy, 0.0), max(qz, 0.0)
        return math.sqrt(ox * ox + oy * oy + oz * oz) + min(max(qx, qy, qz), 0.0)
    if kind == CYLINDER:
        qx, qz = math.sqrt(x * x + y * y) - sx, abs(z) - sy
        ox, oz = max(qx, 0.0), max(qz, 0.0)
        return math.sqrt(ox * ox + oz * oz) + min(max(qx, qz), 0.0)
    if kind == ELLIPSOID:
        near = math.sqrt((x / sx) ** 2 + (y / sy) ** 2 + (z / sz) ** 2)
        slope = math.sqrt((x / sx**2) ** 2 + (y / sy**2) ** 2 + (z / sz**2) ** 2)
        return near * (near - 1.0) / max(slope, TINY) if near > TINY else -min(sx, sy, sz)
    if kind == CAPSULE:
        z -= max(-sy, min(sy, z))
    return math.sqrt(x * x + y * y + z * z) - sx


@compiled_part
def line_meets(
    table: Array, row: int, ax: float, ay: float, az: float, bx: float, by: float, bz: float, radius_m: float
) -> bool:
    """Whether a line from a to b, with all that is within a radius of it, meets a shape.

    The line is walked from one end to the other: what is so far outside of a shape can go as far without meeting it.
    """
    mx, my, mz = (ax + bx) / 2 - table[row, AT], (ay + by) / 2 - table[row, AT + 1], (az + bz) / 2 - table[row, AT + 2]
    dx, dy, dz = bx - ax, by - ay, bz - az
    length = math.sqrt(dx * dx + dy * dy + dz * dz)
    most = max(table[row, BALL] + length / 2 + radius_m, 0.0)
    if mx * mx + my * my + mz * mz > most * most:
        return False
    ax, ay, az = ax - table[row, AT], ay - table[row, AT + 1], az - table[row, AT + 2]
    px = ax * table[row, TURNED] + ay * table[row, TURNED + 3] + az * table[row, TURNED + 6]
    py = ax * table[row, TURNED + 1] + ay * table[row, TURNED + 4] + az * table[row, TURNED + 7]
    pz = ax * table[row, TURNED + 2] + ay * table[row, TURNED + 5] + az * table[row, TURNED + 8]
    share = 1.0 / max(length, TINY)
    wx = share * (dx * table[row, TURNED] + dy * table[row, TURNED + 3] + dz * table[row, TURNED + 6])
    wy = share * (dx * table[row, TURNED + 1] + dy * table[row, TURNED + 4] + dz * table[row, TURNED + 7])
    wz = share * (dx * table[row, TURNED + 2] + dy * table[row, TURNED + 5] + dz * table[row, TURNED + 8])
    t = 0.0
    while True:
        gap = outside_m(table, row, px + t * wx, py + t * wy, pz + t * wz) - radius_m
        if gap < 0.0:
            return True
        if t >= length:
            return False
        t = min(length, t + max(gap, STEP_M))
