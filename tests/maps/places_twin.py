"""The slow, obvious twin of the search for places: one column, one box and one ray at a time, and boxes as points."""

from __future__ import annotations

import itertools
import math

import numpy as np
from numpy.typing import NDArray

from taskgist.maps.grid import Zone
from taskgist.maps.places import Place
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist.world.geometry.shapes import distances_outside_m

Array = NDArray[np.float64]
Size = tuple[float, float, float]
DOWN = np.array([[0.0, 0.0, -1.0]])
EVEN_M, GAP_M, NEXT_M, MOST_SUPPORTS = 0.005, 0.002, 1e-4, 12
COARSE_M, FINE_M = 0.04, 0.008


class PlacesTwin:
    """Level ground, and boxes of a size that stand on it."""

    def __init__(self, stage: Stage, size_m: Size, where: Zone, *, fine_m: float = FINE_M) -> None:
        self._fine_m = fine_m
        self._stage, self._size, self._where, self._grid = stage, size_m, where, where.grid
        self._level = math.cos(DEFAULT.contact.support_slope_rad)
        scene = stage.scene
        self._things = [g for g, owner in enumerate(scene.owners) if owner not in scene.agents and stage.seen[g]]
        self._solid = [int(geom) for geom in stage.solid_geoms() if not stage.is_plane(int(geom))]
        self._centers = stage.geom_centers(self._solid)
        self._radii = np.array(scene.model.geom_rbound[self._solid])

    def places(self) -> list[Place]:
        """All of them, in the order of the grid."""
        grid, height_m = self._grid, self._size[2]
        columns = grid.centers().reshape(*grid.shape, 3)[:, :, 0, :2][self._where.cells.any(axis=2)]
        return [
            Place((float(x), float(y), float(height)), owner)
            for x, y in columns
            for height, owner in self._ground(x, y)
            if self._where.contains([(x, y, height + height_m / 2)])[0] and self.stands(x, y, height)
        ]

    def _ground(self, x: float, y: float) -> list[tuple[float, str]]:
        found, height = [], self._grid.origin_m[2] + self._grid.cell_m * self._grid.shape[2]
        normal = np.zeros((1, 3))
        for _ in range(MOST_SUPPORTS):
            geoms, distances = self._stage.cast((x, y, height), DOWN, only=self._things, normals=normal)
            if geoms[0] < 0:
                break
            height -= float(distances[0])
            if normal[0, 2] >= self._level:
                found.append((height, self._stage.scene.owners[int(geoms[0])]))
            height -= NEXT_M
        return found[::-1]

    def stands(self, x: float, y: float, height: float) -> bool:
        """Whether a box stands there, carried and free."""
        return self._free(x, y, height) and self._carried(x, y, height)

    def _carried(self, x: float, y: float, height: float) -> bool:
        halves = [(i, j) for i, j in itertools.product((-0.5, 0.0, 0.5), repeat=2) if (i, j) != (0.0, 0.0)]
        for i, j in halves:
            shift = self._grid.axes[:2, :2] @ (i * self._size[0], j * self._size[1])
            start = (x + shift[0], y + shift[1], height + EVEN_M + GAP_M)
            geoms, distances = self._stage.cast(start, DOWN, only=self._things)
            if geoms[0] < 0 or distances[0] > 2 * EVEN_M + GAP_M:
                return False
        return True

    def _free(self, x: float, y: float, height: float) -> bool:
        middle = np.array((x, y, height + GAP_M + self._size[2] / 2))
        reach_m = math.hypot(*self._size) / 2
        near = np.linalg.norm(self._centers - middle, axis=1) < self._radii + reach_m
        return not any(self._meets(self._solid[int(index)], middle) for index in np.flatnonzero(near))

    def _meets(self, geom: int, middle: Array) -> bool:
        points = filled(self._size, COARSE_M)
        away_m = self._away_m(geom, middle, points)
        if (away_m <= 0.0).any():
            return True
        near = points[away_m <= COARSE_M]
        finer = (near[:, None] + filled((COARSE_M,) * 3, self._fine_m)).reshape(-1, 3)
        half = np.array(self._size) / 2
        return bool((self._away_m(geom, middle, np.clip(finer, -half, half)) <= 0.0).any())

    def _away_m(self, geom: int, middle: Array, points: Array) -> Array:
        there = middle + points @ self._grid.axes.T
        return distances_outside_m(self._stage.scene.model, geom, self._stage.geom(geom).to_local(there))


def filled(size_m: Size, spacing_m: float) -> Array:
    """Points all over a box about the origin, its faces included, metres, (n, 3)."""
    steps = [np.linspace(-side / 2, side / 2, max(2, math.ceil(side / spacing_m) + 1)) for side in size_m]
    return np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)
