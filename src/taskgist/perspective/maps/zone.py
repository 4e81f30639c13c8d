"""Zones of space: sets of cells of one grid, with the algebra of sets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.errors import InputError
from taskgist.perspective.maps.grid import Cell, Grid

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Zone:
    """Some cells of a grid.

    Zones of one grid are combined with ``&`` (and), ``|`` (or), ``-`` (without) and ``~`` (all other cells).

    Attributes:
        grid: The grid.
        cells: Whether each cell belongs to it, the grid's shape, read-only.
    """

    grid: Grid
    cells: NDArray[np.bool_]

    def __post_init__(self) -> None:
        cells = np.array(self.cells, dtype=bool)
        if cells.shape != self.grid.shape:
            raise InputError("cells do not fit their grid", field="cells", value=cells.shape, hint=f"{self.grid.shape}")
        cells.flags.writeable = False
        object.__setattr__(self, "cells", cells)

    def __reduce__(self) -> tuple[object, ...]:
        return Zone, (self.grid, np.array(self.cells))

    def __and__(self, other: Zone) -> Zone:
        return Zone(self._same(other), self.cells & other.cells)

    def __or__(self, other: Zone) -> Zone:
        return Zone(self._same(other), self.cells | other.cells)

    def __sub__(self, other: Zone) -> Zone:
        return Zone(self._same(other), self.cells & ~other.cells)

    def __invert__(self) -> Zone:
        return Zone(self.grid, ~self.cells)

    @property
    def count(self) -> int:
        """How many cells."""
        return int(self.cells.sum())

    @property
    def volume_m3(self) -> float:
        """Their volume in cubic metres."""
        return self.count * self.grid.cell_m**3

    @property
    def points_m(self) -> Array:
        """Their centres in the world, metres, (n, 3)."""
        return np.asarray(self.grid.centers()[self.cells.ravel()])

    def contains(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether points of the world, metres, (n, 3), lie in the zone, (n,); outside of the grid none does."""
        cells = self.grid.cells_at(points)
        inside = self.grid.holds(cells)
        inside[inside] = self.cells[tuple(cells[inside].T)]
        return inside

    def nearest(self, point: ArrayLike) -> Cell | None:
        """The cell whose centre is nearest to a point of the world, metres, (3,); None if there are none."""
        indices = np.flatnonzero(self.cells)
        if not len(indices):
            return None
        away = self.grid.centers()[indices] - np.asarray(point, dtype=float)
        best = int(indices[np.argmin(np.round(np.einsum("ij,ij->i", away, away), 9))])
        first, second, third = (int(index) for index in np.unravel_index(best, self.grid.shape))
        return first, second, third

    def _same(self, other: Zone) -> Grid:
        if other.grid != self.grid:
            hint = "make both maps with one grid, as Grid.around(stage, *agents)"
            raise InputError("zones of different grids cannot be combined", field="grid", hint=hint)
        return self.grid
