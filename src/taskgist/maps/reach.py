"""Which cells an agent reaches from its configurations: the point-like twin of ``perspective.reach`` (5.1.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled_for_threads
from taskgist.common.workers import on_threads
from taskgist.maps.configurations import Base, Configuration, straight_ahead
from taskgist.maps.grid import Cells, Undecided
from taskgist.perspective.occlusion import CLEAR, HIDDEN
from taskgist.perspective.reach import ROUNDING, distance_m, in_reach, usable_arms
from taskgist.perspective.viewpoint import Viewpoint


@compiled_for_threads
def reach_cells(shoulders: Array, sectors: Array, base: Base, cells: Undecided, found: NDArray[np.uint8]) -> None:
    """Find out which cells are reached from a configuration, at some of its places; those are undecided no longer.

    Args:
        shoulders: Of the arms that may be stretched out, and the frames of what carries them, (a, 12).
        sectors: Of these arms, (a, 6).
        base: Where the configuration is brought.
        cells: The cells.
        found: Of all cells, ``CLEAR`` where one is reached.
    """
    (points, rows, starts, counts, middles, radii_m), (start, chest, places, turns) = cells, base
    at = np.empty(3)
    for block in range(len(starts)):
        first = starts[block]
        for place in range(len(places)):
            if counts[block] == 0:
                break
            straight_ahead(start, chest, places, turns, place, middles[block], at)
            near = False
            for arm in range(len(shoulders)):
                near |= distance_m(shoulders[arm], at) - radii_m[block] <= sectors[arm, 0] + ROUNDING
            if not near:
                continue
            kept = 0
            for lane in range(first, first + counts[block]):
                row, reached = rows[lane], False
                straight_ahead(start, chest, places, turns, place, points[row], at)
                for arm in range(len(shoulders)):
                    reached = reached or in_reach(shoulders[arm], sectors[arm], at)
                if reached:
                    found[row] = CLEAR
                else:
                    rows[first + kept] = row
                    kept += 1
            counts[block] = kept


class CellsToReach:
    """What reaching asks for, whatever the effort level; nothing is held that is not there.

    Args:
        here: Whose ability, and from where.
        cells: What is to be reached.
    """

    first_level = 1

    def __init__(self, here: Viewpoint, cells: Cells) -> None:
        arms, self._sectors = usable_arms(here)
        self.found = np.full(len(cells.points), HIDDEN, dtype=np.uint8)
        self._arms = np.array(arms, dtype=np.intp)

    def find(self, configuration: Configuration, places: Indices, cells: Undecided) -> None:
        """What a configuration reaches at some of its places: see ``reach_cells``."""
        shoulders = configuration.shoulders[self._arms]
        base = configuration.at(places)
        on_threads(lambda part: reach_cells(shoulders, self._sectors, base, part, self.found), cells.parts())

    def past_meshes(self, configuration: Configuration, rows: Indices) -> Mask:  # noqa: ARG002 - as those that see
        """Nothing is in the way of an arm, (n,)."""
        return np.ones(len(rows), dtype=bool)
