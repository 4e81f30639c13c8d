"""The cells of a grid in blocks: what is plain of a whole block need not be found for each of its cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.grid import Grid

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
EDGE = 4
"""Cells along the edge of a block."""
LANES = EDGE**3
"""Cells of a block: compiled loops take a block at a time, with a lane for each of its cells."""
OUTSIDE = -1


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells in the order of blocks; a cell's place in this order is its row.

    Attributes:
        points: Their centres, metres in the world, (cells, 3).
        index: Which cell of the grid each is, in the grid's own order, (cells,).
        block: The block of each, ascending, (cells,).
    """

    points: Array
    index: Indices
    block: Indices

    @classmethod
    def of(cls, grid: Grid) -> Cells:
        """All cells of a grid."""
        along = [-(-count // EDGE) for count in grid.shape]
        padded = np.full([EDGE * count for count in along], OUTSIDE, dtype=np.intp)
        padded[tuple(slice(count) for count in grid.shape)] = np.arange(np.prod(grid.shape)).reshape(grid.shape)
        first, second, third = along
        parted = padded.reshape(first, EDGE, second, EDGE, third, EDGE).transpose(0, 2, 4, 1, 3, 5).ravel()
        rows = np.flatnonzero(parted != OUTSIDE)
        index = parted[rows]
        return cls(grid.centers()[index], index, rows // LANES)

    def starts(self, rows: Indices) -> Indices:
        """Where the blocks of some rows begin among them, and where the last one ends, (blocks + 1,)."""
        changes = np.flatnonzero(np.diff(self.block[rows])) + 1
        return np.concatenate(([0], changes, [len(rows)]))
