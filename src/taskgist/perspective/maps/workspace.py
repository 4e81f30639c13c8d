"""A workspace: the cells of a grid around an agent, and which of them are solid. All maps of a standpoint share it."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.maps.cells import Cells
from taskgist.perspective.maps.grid import Grid
from taskgist.perspective.maps.solid import solid_cells


@dataclass(frozen=True, eq=False)
class Workspace:
    """Cells of a grid.

    Attributes:
        grid: The grid.
        cells: Its cells, block by block.
        solid: Whether each lies in something solid that is not the agent's own, the grid's shape.
    """

    grid: Grid
    cells: Cells
    solid: NDArray[np.bool_]


_LAST: WeakKeyDictionary[Standpoint, Workspace] = WeakKeyDictionary()


def workspace_of(here: Standpoint, grid: Grid) -> Workspace:
    """The workspace of an agent as the stage shows it, which is as it stands; the last one is kept."""
    last = _LAST.get(here)
    if last is None or last.grid != grid:
        last = _LAST[here] = Workspace(grid, Cells.of(grid), solid_cells(here.stage, grid, but=here.agent.name))
    return last
