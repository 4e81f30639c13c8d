"""Rays through a scene in a state: MuJoCo's own, and quicker ones for those who know which few shapes count."""

from __future__ import annotations

import copy
import math
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.bodies.agent import SEEN_MASK

# --- Rays against shapes, by formula.
#
# MuJoCo casts rays into a whole scene; most of its time goes into bodies that a small bundle of rays cannot meet.
# Whoever knows which few shapes count asks here instead. Meshes and height fields are left to MuJoCo (``Rays``).
#
# Origin and direction are in the frame of the shape, its half sizes as MuJoCo keeps them. Each formula gives the
# distance to the first surface ahead, infinite where there is none; a ray that starts inside of a shape meets its
# surface from within, as MuJoCo's does. A plane has two sides here; MuJoCo's rays meet its front alone.

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


@compiled_part
def local(matrix: Array, vector: Array) -> tuple[float, float, float]:
    """A vector (3,) of the world, in a frame whose axes are the columns of a matrix, (9,) row by row."""
    x, y, z = vector[0], vector[1], vector[2]
    return (
        x * matrix[0] + y * matrix[3] + z * matrix[6],
        x * matrix[1] + y * matrix[4] + z * matrix[7],
        x * matrix[2] + y * matrix[5] + z * matrix[8],
    )


@compiled_part
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


@compiled_part
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


@compiled_part
def ball(radius: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a sphere."""
    near, far = roots(dx * dx + dy * dy + dz * dz, dx * px + dy * py + dz * pz, px * px + py * py + pz * pz - radius**2)
    return near if near >= 0.0 else far if far >= 0.0 else INF


@compiled_part
def ellipsoid(
    sx: float, sy: float, sz: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float
) -> float:
    """Distance to an ellipsoid: a sphere of radius one, once scaled."""
    return ball(1.0, px / sx, py / sy, pz / sz, dx / sx, dy / sy, dz / sz)


@compiled_part
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


@compiled_part
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


@compiled_part
def plane(sx: float, sy: float, px: float, py: float, pz: float, dx: float, dy: float, dz: float) -> float:
    """Distance to a plane from either side, within its half sizes where these are not zero."""
    if (dz if pz < 0.0 else -dz) < LEVEL:
        return INF
    t = -pz / dz
    beside = (sx > 0.0 and abs(px + t * dx) > sx) or (sy > 0.0 and abs(py + t * dy) > sy)
    return INF if t < 0.0 or beside else t


@compiled_part
def roots(a: float, b: float, c: float) -> tuple[float, float]:
    """Both solutions of a t² + 2 b t + c = 0, infinite where there is none."""
    square = b * b - a * c
    if square < 0.0 or a < LEVEL:
        return INF, INF
    root = math.sqrt(square)
    return (-b - root) / a, (-b + root) / a


@compiled_part
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


# --- What stands between a point and some balls, never too little; and all shapes as compiled functions take them.

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
    formless: Mask
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

    All rays to the ball lie that near to the line. A plane counts unless point and balls are on one side of it.
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
            if kinds[shape] == PLANE:
                near = min(pz, pz + dz - radius) <= 0.0 <= max(pz, pz + dz + radius)
            else:
                bx, by, bz = px - bounds[shape, 0], py - bounds[shape, 1], pz - bounds[shape, 2]
                sx, sy, sz = bounds[shape, 3] + radius, bounds[shape, 4] + radius, bounds[shape, 5] + radius
                near = abs(bx) <= sx and abs(by) <= sy and abs(bz) <= sz
                near = near or box(sx, sy, sz, bx, by, bz, dx, dy, dz) <= 1.0
            if near:
                found[count] = shape
                count += 1
                break
    return found[:count]


@compiled_part
def into_shape(matrices: Array, shape: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A vector of the world in the frame of a shape, turned as its matrix, (9,) row by row, says."""
    return (
        x * matrices[shape, 0] + y * matrices[shape, 3] + z * matrices[shape, 6],
        x * matrices[shape, 1] + y * matrices[shape, 4] + z * matrices[shape, 7],
        x * matrices[shape, 2] + y * matrices[shape, 5] + z * matrices[shape, 8],
    )


@compiled_part
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


UNSEEN_GROUP = 3


class Rays:
    """Casts rays into a model whose shapes are where some data says.

    Attributes:
        seen: Whether rays meet each shape: its group is seen, it is not wholly transparent and not hidden, (ngeom,).
        shapes: All shapes, for compiled functions.
        cast_count: Rays cast so far.

    Args:
        model: The model.
        data: Where its shapes are; read anew with every question.
        visible: Whether each shape can be seen at all, (ngeom,).
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, visible: Mask) -> None:
        self._model, self._data, self._visible = model, data, visible
        self._known = model
        self._alone: tuple[tuple[int, ...], mujoco.MjModel] | None = None
        kinds = model.geom_type.astype(np.int64)
        self.shapes = Shapes(
            kinds,
            ~np.isin(kinds, FORMULAS),
            np.array(model.geom_size),
            np.array(model.geom_aabb),
            np.where(kinds == PLANE, np.inf, _around(model.geom_aabb)),
            np.array(model.geom_bodyid),
            data.geom_xpos,
            data.geom_xmat,
        )
        self._planes = np.flatnonzero(kinds == PLANE)
        self.seen = visible
        self.cast_count = 0

    def hide(self, geoms: Indices) -> None:
        """Let rays pass some shapes, and no others, from now on."""
        self._known, self.seen = self._model, self._visible
        if len(geoms):
            self._known = copy.copy(self._model)
            self._known.geom_group[geoms] = UNSEEN_GROUP
            self.seen = self._visible.copy()
            self.seen[geoms] = False

    def cast(
        self,
        origin: ArrayLike,
        directions: ArrayLike,
        *,
        exclude_body: int = -1,
        only: ArrayLike | None = None,
        normals: Array | None = None,
    ) -> tuple[NDArray[np.int32], Array]:
        """Cast rays through MuJoCo; see ``Stage.cast``."""
        rays = np.ascontiguousarray(directions, dtype=float)
        geoms = np.full(len(rays), NO_GEOM, dtype=np.int32)
        distances = np.full(len(rays), -1.0)
        self.cast_count += len(rays)
        if len(rays):
            mujoco.mj_multiRay(
                self._known if only is None else self._model_of(only),
                self._data,
                np.asarray(origin, dtype=float),
                rays.ravel(),
                SEEN_MASK,
                True,
                exclude_body,
                geoms,
                distances,
                None if normals is None else normals.reshape(-1),
                len(rays),
                mujoco.mjMAXVAL,
            )
            of = self.shapes
            for plane in self._planes_from_behind(np.asarray(origin, dtype=float), exclude_body, only):
                met, away_m = cast_at(of.kinds, of.sizes, of.positions, of.matrices, plane, np.asarray(origin), rays)
                nearer = (met >= 0) & ((geoms < 0) | (away_m < distances))
                geoms[nearer], distances[nearer] = plane, away_m[nearer]
                if normals is not None:
                    normals[nearer] = -of.matrices[plane, 2::3]
        return geoms, distances

    def _planes_from_behind(self, origin: Array, exclude_body: int, only: ArrayLike | None) -> Indices:
        """Planes behind which rays start, and which MuJoCo lets them pass, (k, 1)."""
        of, planes = self.shapes, self._planes if only is None else np.intersect1d(self._planes, only)
        planes = planes[self.seen[planes] & (of.bodies[planes] != exclude_body)]
        in_front_m = np.sum(of.matrices[planes, 2::3] * (origin - of.positions[planes]), axis=1)
        return np.asarray(planes[in_front_m < 0.0][:, None])

    def cast_at(self, shapes: Indices, origin: Array, directions: Array) -> tuple[Indices, Array]:
        """Cast rays at a few shapes; see ``Stage.cast_at``."""
        count = len(directions)
        if not len(shapes) or not count:
            return np.full(count, NO_GEOM, dtype=np.intp), np.full(count, np.inf)
        self.cast_count += count
        of = self.shapes
        first, nearest = cast_at(of.kinds, of.sizes, of.positions, of.matrices, shapes, origin, directions)
        meshes = shapes[of.formless[shapes]]
        if len(meshes):
            self._cast_at_meshes(meshes, origin, directions, first, nearest)
        return first, nearest

    def _cast_at_meshes(
        self, meshes: Indices, origin: Array, directions: Array, first: Indices, nearest: Array
    ) -> None:
        """Asks MuJoCo for shapes without a formula, with those rays that meet the boxes around them."""
        near = meets_boxes(self.shapes, meshes, origin, directions)
        rays = np.flatnonzero(near)
        geoms, distances = self.cast(origin, directions[rays], only=meshes)
        nearer = (geoms >= 0) & (distances < nearest[rays])
        first[rays[nearer]], nearest[rays[nearer]] = geoms[nearer], distances[nearer]

    def cast_each(self, shapes: Indices, origins: Array, directions: Array) -> tuple[Indices, Array, Array]:
        """Cast rays from a point each; see ``Stage.cast_each``."""
        self.cast_count += len(origins)
        if not self.shapes.formless[shapes].any():
            return cast_each(self.shapes, shapes, origins, directions)
        together = len(origins) > 0 and not np.ptp(origins, axis=0).any()
        rows = [slice(None)] if together else [slice(row, row + 1) for row in range(len(origins))]
        geoms, distances, normals = np.full(len(origins), NO_GEOM), np.zeros(len(origins)), np.zeros_like(origins)
        for row in rows:
            geoms[row], distances[row] = self.cast(origins[row][0], directions[row], only=shapes, normals=normals[row])
        distances[geoms < 0] = np.inf
        return geoms, distances, normals

    def between(self, origin: Array, centers: Array, radii_m: Array, but_body: int) -> Indices:
        """Shapes that may stand between a point and some balls; see ``Stage.between``."""
        return stand_between(self.shapes, np.flatnonzero(self.seen), but_body, origin, centers, radii_m)

    def _model_of(self, only: ArrayLike) -> mujoco.MjModel:
        """A copy of the model in which no other shape is seen."""
        shapes = tuple(int(geom) for geom in np.asarray(only))
        if self._alone is None or self._alone[0] != shapes:
            model = copy.copy(self._model) if self._alone is None else self._alone[1]
            groups = np.full(model.ngeom, UNSEEN_GROUP)
            groups[list(shapes)] = self._model.geom_group[list(shapes)]
            model.geom_group[:] = groups
            self._alone = (shapes, model)
        return self._alone[1]


@compiled
def cast_each(of: Shapes, shapes: Indices, origins: Array, directions: Array) -> tuple[Indices, Array, Array]:
    """The first of some shapes that each ray meets, how far it is, and its outward normal there."""
    count = len(origins)
    first, nearest, normals = np.empty(count, dtype=np.intp), np.empty(count), np.empty((count, 3))
    for ray in range(count):
        first[ray], nearest[ray] = NO_GEOM, INF
        normals[ray, 0], normals[ray, 1], normals[ray, 2] = 0.0, 0.0, 0.0
        for shape in shapes:
            m, size, kind = of.matrices[shape], of.sizes[shape], of.kinds[shape]
            x, y, z = local(m, origins[ray] - of.positions[shape])
            dx, dy, dz = local(m, directions[ray])
            t = surface(kind, size[0], size[1], size[2], x, y, z, dx, dy, dz)
            if t < nearest[ray]:
                first[ray], nearest[ray] = shape, t
                n = normal_at(kind, size[0], size[1], size[2], x + t * dx, y + t * dy, z + t * dz)
                if kind == PLANE and dz > 0.0:
                    n = (0.0, 0.0, -1.0)
                for axis in range(3):
                    normals[ray, axis] = m[3 * axis] * n[0] + m[3 * axis + 1] * n[1] + m[3 * axis + 2] * n[2]
    return first, nearest, normals


@compiled
def meets_boxes(of: Shapes, shapes: Indices, origin: Array, directions: Array) -> Mask:
    """Whether each ray meets the box around any of some shapes, (n,)."""
    met = np.zeros(directions.shape[0], dtype=np.bool_)
    for shape in shapes:
        m, b = of.matrices[shape], of.bounds[shape]
        x, y, z = local(m, origin - of.positions[shape])
        for ray in range(directions.shape[0]):
            dx, dy, dz = local(m, directions[ray])
            met[ray] |= box(b[3], b[4], b[5], x - b[0], y - b[1], z - b[2], dx, dy, dz) < INF
    return met


def _around(bounds: Array) -> Array:
    """Radii of balls about the origin that hold boxes, (n,)."""
    return np.asarray(np.linalg.norm(np.abs(bounds[:, :3]) + bounds[:, 3:], axis=1))
