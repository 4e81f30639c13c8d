"""Rays through a scene in a state: MuJoCo's own, and quicker ones for those who know which few shapes count."""

from __future__ import annotations

import copy
import math
from collections.abc import Collection
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.body.agent import SEEN_MASK
from taskgist.world.geometry import raycast
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
UNSEEN_GROUP = 3
NO_GEOM = -1
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

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, visible: NDArray[np.bool_]) -> None:
        self._model, self._data, self._visible = model, data, visible
        self._known = model
        self._alone: tuple[tuple[int, ...], mujoco.MjModel] | None = None
        kinds = model.geom_type.astype(np.int64)
        self.shapes = Shapes(
            kinds,
            ~np.isin(kinds, raycast.FORMULAS),
            np.array(model.geom_size),
            np.array(model.geom_aabb),
            np.where(kinds == raycast.PLANE, np.inf, _around(model.geom_aabb)),
            np.array(model.geom_bodyid),
            data.geom_xpos,
            data.geom_xmat,
        )
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
        return geoms, distances

    def cast_at(self, shapes: Indices, origin: Array, directions: Array) -> tuple[Indices, Array]:
        """Cast rays at a few shapes; see ``Stage.cast_at``."""
        count = len(directions)
        if not len(shapes) or not count:
            return np.full(count, NO_GEOM, dtype=np.intp), np.full(count, np.inf)
        self.cast_count += count
        of = self.shapes
        first, nearest = raycast.cast_at(of.kinds, of.sizes, of.positions, of.matrices, shapes, origin, directions)
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

    def between(self, origin: Array, centers: Array, radii_m: Array, without: Indices, but_body: int) -> Indices:
        """Shapes that may stand between a point and some balls; see ``Stage.between``."""
        counted = self.seen.copy()
        counted[without] = False
        return stand_between(self.shapes, np.flatnonzero(counted), but_body, origin, centers, radii_m)

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
    first, nearest, normals = np.full(count, NO_GEOM), np.full(count, raycast.INF), np.zeros((count, 3))
    for ray in range(count):
        for shape in shapes:
            m, size, kind = of.matrices[shape], of.sizes[shape], of.kinds[shape]
            x, y, z = raycast.local(m, origins[ray] - of.positions[shape])
            dx, dy, dz = raycast.local(m, directions[ray])
            t = raycast.surface(kind, size[0], size[1], size[2], x, y, z, dx, dy, dz)
            if t < nearest[ray]:
                first[ray], nearest[ray] = shape, t
                n = raycast.normal_at(kind, size[0], size[1], size[2], x + t * dx, y + t * dy, z + t * dz)
                for axis in range(3):
                    normals[ray, axis] = m[3 * axis] * n[0] + m[3 * axis + 1] * n[1] + m[3 * axis + 2] * n[2]
    return first, nearest, normals


@compiled
def meets_boxes(of: Shapes, shapes: Indices, origin: Array, directions: Array) -> NDArray[np.bool_]:
    """Whether each ray meets the box around any of some shapes, (n,)."""
    met = np.zeros(directions.shape[0], dtype=np.bool_)
    for shape in shapes:
        m, b = of.matrices[shape], of.bounds[shape]
        x, y, z = raycast.local(m, origin - of.positions[shape])
        for ray in range(directions.shape[0]):
            dx, dy, dz = raycast.local(m, directions[ray])
            met[ray] |= raycast.box(b[3], b[4], b[5], x - b[0], y - b[1], z - b[2], dx, dy, dz) < raycast.INF
    return met


@compiled
def stand_between(
    of: Shapes, candidates: Indices, but_body: int, origin: Array, centers: Array, radii_m: Array
) -> Indices:
    """Those of some shapes in whose box, grown by a ball's radius, the line from a point to the ball's centre runs.

    All rays to the ball lie that near to the line. A plane counts unless point and balls are above it.
    """
    found, count = np.empty(len(candidates), dtype=np.intp), 0
    positions, reaches, bodies = of.positions, of.radii, of.bodies
    ox, oy, oz = origin[0], origin[1], origin[2]
    middle, radius_m = one_ball(centers, radii_m)
    wx, wy, wz = middle[0] - ox, middle[1] - oy, middle[2] - oz
    squared = max(wx * wx + wy * wy + wz * wz, TINY)
    for shape in candidates:
        if bodies[shape] == but_body:
            continue
        x, y, z = positions[shape, 0] - ox, positions[shape, 1] - oy, positions[shape, 2] - oz
        share = min(max((x * wx + y * wy + z * wz) / squared, 0.0), 1.0)
        x, y, z = x - share * wx, y - share * wy, z - share * wz
        reach = reaches[shape] + radius_m
        if x * x + y * y + z * z <= reach * reach and _near_line(of, shape, origin, centers, radii_m):
            found[count] = shape
            count += 1
    return found[:count]


@compiled
def one_ball(centers: Array, radii_m: Array) -> tuple[Array, float]:
    """A ball that holds some balls."""
    middle, radius_m = np.zeros(3), 0.0
    for axis in range(3):
        middle[axis] = centers[:, axis].mean()
    for k in range(len(radii_m)):
        x, y, z = centers[k, 0] - middle[0], centers[k, 1] - middle[1], centers[k, 2] - middle[2]
        radius_m = max(radius_m, math.sqrt(x * x + y * y + z * z) + radii_m[k])
    return middle, radius_m


@compiled
def _near_line(of: Shapes, shape: int, origin: Array, ends: Array, radii_m: Array) -> bool:
    """Whether a shape's box, grown by a radius, meets the line from a point to any of the ends that have it."""
    m, b = of.matrices[shape], of.bounds[shape]
    x, y, z = raycast.local(m, origin - of.positions[shape])
    for ball in range(len(radii_m)):
        radius_m = radii_m[ball]
        dx, dy, dz = raycast.local(m, ends[ball] - origin)
        if of.kinds[shape] == raycast.PLANE:
            if min(z, z + dz - radius_m) <= 0.0:
                return True
            continue
        px, py, pz = x - b[0], y - b[1], z - b[2]
        sx, sy, sz = b[3] + radius_m, b[4] + radius_m, b[5] + radius_m
        inside = abs(px) <= sx and abs(py) <= sy and abs(pz) <= sz
        if inside or raycast.box(sx, sy, sz, px, py, pz, dx, dy, dz) <= 1.0:
            return True
    return False


def _around(bounds: Array) -> Array:
    """Radii of balls about the origin that hold boxes, (n,)."""
    return np.asarray(np.linalg.norm(np.abs(bounds[:, :3]) + bounds[:, 3:], axis=1))


def visible_geoms(model: mujoco.MjModel, groups: Collection[int]) -> NDArray[np.bool_]:
    """Whether each shape can be seen: its group is one of these, and it is not wholly transparent, (ngeom,)."""
    return np.isin(model.geom_group, list(groups)) & opaque(model, np.arange(model.ngeom))


def opaque(model: mujoco.MjModel, geoms: NDArray[np.intp]) -> NDArray[np.bool_]:
    """Whether rays meet shapes at all: they pass what has no colour, (n,)."""
    materials = model.geom_matid[geoms]
    own = model.geom_rgba[geoms, 3] > 0
    return np.asarray(own if not model.nmat else np.where(materials < 0, own, model.mat_rgba[materials, 3] > 0))
