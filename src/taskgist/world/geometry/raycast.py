"""Rays against shapes, by formula.

MuJoCo casts rays into a whole scene; most of its time goes into bodies that a small bundle of rays cannot meet.
Whoever knows which few shapes count asks here instead. Meshes and height fields are left to MuJoCo (``Rays``).

Origin and direction are in the frame of the shape, its half sizes as MuJoCo keeps them. Each formula gives the
distance to the first surface ahead, infinite where there is none; a ray that starts inside of a shape meets its
surface from within, as MuJoCo's does.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)
SPHERE = int(mujoco.mjtGeom.mjGEOM_SPHERE)
CAPSULE = int(mujoco.mjtGeom.mjGEOM_CAPSULE)
ELLIPSOID = int(mujoco.mjtGeom.mjGEOM_ELLIPSOID)
CYLINDER = int(mujoco.mjtGeom.mjGEOM_CYLINDER)
BOX = int(mujoco.mjtGeom.mjGEOM_BOX)
FORMULAS = (PLANE, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX)
"""Types of shapes that have a formula."""
LEVEL = 1e-15
"""Rays less inclined than this never meet a plane (MuJoCo's)."""
INF = math.inf
NO_GEOM = -1
"""Stands for no shape."""


@compiled
def cast_at(
    kinds: NDArray[np.int64],
    sizes: Array,
    positions: Array,
    matrices: Array,
    shapes: Indices,
    origin: Array,
    directions: Array,
) -> tuple[Indices, Array]:
    """The first of some shapes that each ray meets, and how far it is.

    Args:
        kinds: MuJoCo's type of every shape of the model, (ngeom,).
        sizes: Half sizes in metres, (ngeom, 3).
        positions: Where they are in the world, metres, (ngeom, 3).
        matrices: How they are turned, (ngeom, 9).
        shapes: Which of them count, (k,).
        origin: Where all rays start, metres, (3,).
        directions: Unit vectors in the world, (n, 3).

    Returns:
        Shapes, −1 for none, (n,), and distances in metres, infinite for none, (n,).
    """
    count = directions.shape[0]
    first = np.full(count, NO_GEOM, dtype=np.intp)
    nearest = np.full(count, INF)
    for shape in shapes:
        kind, (sx, sy, sz) = kinds[shape], (sizes[shape, 0], sizes[shape, 1], sizes[shape, 2])
        m = matrices[shape]
        px, py, pz = local(m, origin - positions[shape])
        for ray in range(count):
            dx, dy, dz = local(m, directions[ray])
            t = surface(kind, sx, sy, sz, px, py, pz, dx, dy, dz)
            if t < nearest[ray]:
                nearest[ray], first[ray] = t, shape
    return first, nearest


@compiled
def local(matrix: Array, vector: Array) -> tuple[float, float, float]:
    """A vector (3,) of the world, in a frame whose axes are the columns of a matrix, (9,) row by row."""
    x, y, z = vector[0], vector[1], vector[2]
    return (
        x * matrix[0] + y * matrix[3] + z * matrix[6],
        x * matrix[1] + y * matrix[4] + z * matrix[7],
        x * matrix[2] + y * matrix[5] + z * matrix[8],
    )


@compiled
def surface(
    kind: int, sx: float, sy: float, sz: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float
) -> float:
    """Distance to the surface of a shape, by its type; infinite for types without a formula."""
    if kind == BOX:
        return box(sx, sy, sz, px, py, pz, dx, dy, dz)
    if kind == CAPSULE:
        return capsule(sx, sy, px, py, pz, dx, dy, dz)
    if kind == ELLIPSOID:
        return ellipsoid(sx, sy, sz, px, py, pz, dx, dy, dz)
    if kind == CYLINDER:
        return cylinder(sx, sy, px, py, pz, dx, dy, dz)
    if kind == SPHERE:
        return ball(sx, px, py, pz, dx, dy, dz)
    if kind == PLANE:
        return plane(sx, sy, px, py, pz, dx, dy, dz)
    return INF


@compiled
def box(sx: float, sy: float, sz: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a box: the last entry between a pair of faces, unless an exit comes first."""
    enter, leave = -INF, INF
    for size, at, way in ((sx, px, dx), (sy, py, dy), (sz, pz, dz)):
        if way == 0.0:
            if abs(at) > size:
                return INF
            continue
        near, far = (-size - at) / way, (size - at) / way
        if near > far:
            near, far = far, near
        enter, leave = max(enter, near), min(leave, far)
    if enter > leave or leave < 0.0:
        return INF
    return enter if enter >= 0.0 else leave


@compiled
def ball(radius: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a sphere."""
    near, far = roots(dx * dx + dy * dy + dz * dz, dx * px + dy * py + dz * pz, px * px + py * py + pz * pz - radius**2)
    return near if near >= 0.0 else far if far >= 0.0 else INF


@compiled
def ellipsoid(
    sx: float, sy: float, sz: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float
) -> float:
    """Distance to an ellipsoid: a sphere of radius one, once scaled."""
    return ball(1.0, px / sx, py / sy, pz / sz, dx / sx, dy / sy, dz / sz)


@compiled
def cylinder(radius: float, half: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a cylinder along z: wall and two discs."""
    best = INF
    for t in roots(dx * dx + dy * dy, dx * px + dy * py, px * px + py * py - radius**2):
        if 0.0 <= t < best and abs(pz + t * dz) <= half:
            best = t
    if dz != 0.0:
        for end in (-half, half):
            t = (end - pz) / dz
            x, y = px + t * dx, py + t * dy
            if 0.0 <= t < best and x * x + y * y <= radius**2:
                best = t
    return best


@compiled
def capsule(radius: float, half: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a capsule along z: wall, and the outer halves of two spheres."""
    best = INF
    for t in roots(dx * dx + dy * dy, dx * px + dy * py, px * px + py * py - radius**2):
        if 0.0 <= t < best and abs(pz + t * dz) <= half:
            best = t
    for sign in (-1.0, 1.0):
        z = pz - sign * half
        for t in roots(dx * dx + dy * dy + dz * dz, dx * px + dy * py + dz * z, px * px + py * py + z * z - radius**2):
            if 0.0 <= t < best and sign * (z + t * dz) >= 0.0:
                best = t
    return best


@compiled
def plane(sx: float, sy: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to the front of a plane, within its half sizes where these are not zero."""
    if dz > -LEVEL:
        return INF
    t = -pz / dz
    beside = (sx > 0.0 and abs(px + t * dx) > sx) or (sy > 0.0 and abs(py + t * dy) > sy)
    return INF if t < 0.0 or beside else t


@compiled
def roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Both solutions of a t² + 2 b t + c = 0, infinite where there is none."""
    square = b * b - a * c
    if square < 0.0 or a < LEVEL:
        return INF, INF
    root = math.sqrt(square)
    return (-b - root) / a, (-b + root) / a


@compiled
def normal_at(kind: int, sx: float, sy: float, sz: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Outward unit normal of a shape at a point of its surface."""
    if kind == BOX:
        across = (abs(x) / sx, abs(y) / sy, abs(z) / sz)
        if across[0] >= across[1] and across[0] >= across[2]:
            return math.copysign(1.0, x), 0.0, 0.0
        if across[1] >= across[2]:
            return 0.0, math.copysign(1.0, y), 0.0
        return 0.0, 0.0, math.copysign(1.0, z)
    if kind == CYLINDER and abs(z) - sy > math.hypot(x, y) - sx:
        return 0.0, 0.0, math.copysign(1.0, z)
    if kind == CYLINDER:
        z = 0.0
    elif kind == CAPSULE:
        z -= max(-sy, min(sy, z))
    elif kind == ELLIPSOID:
        x, y, z = x / sx**2, y / sy**2, z / sz**2
    elif kind == PLANE:
        x, y, z = 0.0, 0.0, 1.0
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length
