"""The object that an ability is asked about, as it is in one state: what its judges need of it, found once."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Settings
from taskgist.world import Stage, object_points

Array = NDArray[np.float64]
SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


class Sought(NamedTuple):
    """An object that is looked for, as compiled functions take it.

    Attributes:
        shapes: Its seen shapes, (n,).
        centers: Their centres, metres, (n, 3).
        radii_m: Radii of balls about these that hold the shapes, (n,).
        corners: Corners of the boxes around them, metres, (8 n, 3).
        middle: Mean of the centres, (3,).
    """

    shapes: NDArray[np.intp]
    centers: Array
    radii_m: Array
    corners: Array
    middle: Array


class Target:
    """An object where it is. It may be asked while the stage shows other states of some agent: objects stay.

    Args:
        stage: The scene.
        name: The object.
        settings: Size of the cells.
    """

    def __init__(self, stage: Stage, name: str, settings: Settings) -> None:
        self._stage, self.name, self._settings = stage, name, settings
        self.shapes = stage.scene.seen_geoms(name)

    @cached_property
    def centers(self) -> Array:
        """Centres of its seen shapes, metres, (n, 3)."""
        return self._stage.geom_centers(self.shapes)

    @cached_property
    def radii_m(self) -> Array:
        """Radii of balls about these that hold the shapes, (n,)."""
        return np.asarray(self._stage.scene.model.geom_rbound[self.shapes])

    @cached_property
    def middle(self) -> Array:
        """Mean of the centres, metres, (3,)."""
        return np.asarray(self.centers.mean(axis=0))

    @cached_property
    def points(self) -> Array:
        """Points of its cells, metres, (k, 3)."""
        return object_points(self._stage, self.name, self._settings.reach.cell_m)

    @cached_property
    def corners(self) -> Array:
        """Corners of the boxes around its seen shapes, metres, (8 n, 3)."""
        bounds = self._stage.scene.model.geom_aabb[self.shapes]
        local = bounds[:, None, :3] + SIGNS * bounds[:, None, 3:]
        positions, matrices = self._stage.geoms(self.shapes)
        turned = local @ matrices.reshape(-1, 3, 3).transpose(0, 2, 1)
        return np.asarray((turned + positions[:, None]).reshape(-1, 3))

    @cached_property
    def sought(self) -> Sought:
        """For those who look for it."""
        return Sought(self.shapes, self.centers, self.radii_m, self.corners, self.middle)

    @cached_property
    def others(self) -> NDArray[np.intp]:
        """All other seen shapes of the scene, (m,)."""
        counted = self._stage.seen.copy()
        counted[self.shapes] = False
        return np.flatnonzero(counted)
