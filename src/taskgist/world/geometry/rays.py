"""Rays through a scene in a state: MuJoCo's own, and quicker ones for those who know which few shapes count."""

from __future__ import annotations

import copy
from collections.abc import Collection

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.body.agent import SEEN_MASK
from taskgist.world.geometry import raycast
from taskgist.world.geometry.between import Shapes, stand_between
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.raycast import NO_GEOM

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
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
