"""Which cells an agent reaches from its configurations: the point-like twin of ``perspective.reach`` (5.1.2).

Of what is in an arm's way only this is asked for so many cells: whether they are shut in. One flood of the free space
comes from the agent, and from the border of the map; what it does not get to is closed.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_for_threads, compiled_part
from taskgist.common.workers import on_threads
from taskgist.maps.configurations import Base, Configuration, straight_ahead
from taskgist.maps.grid import Cells, Undecided
from taskgist.perspective.arms import ROUNDING, Arms, distance_m, in_reach
from taskgist.perspective.occlusion import CLEAR, HIDDEN
from taskgist.perspective.reach import usable_arms
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.geometry.rays import BOX
from taskgist.world.geometry.solids import AT, BALL, KIND, SIZE, TURNED, outside_m


@compiled_for_threads
def reach_cells(shoulders: Array, arms: Arms, base: Base, cells: Undecided, found: NDArray[np.uint8]) -> None:
    """Find out which cells are reached from a configuration, at some of its places; those are undecided no longer.

    Args:
        shoulders: Of the arms that may be stretched out, and the frames of what carries them, (a, 12); or twice, then
            thrust forward.
        arms: These arms.
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
                near |= distance_m(shoulders[arm], at) - radii_m[block] <= arms.sectors[arm, 0] + ROUNDING
            if not near:
                continue
            kept = 0
            for lane in range(first, first + counts[block]):
                row, reached = rows[lane], False
                straight_ahead(start, chest, places, turns, place, points[row], at)
                for arm in range(len(shoulders)):
                    reached = reached or in_reach(shoulders[arm], arms, arm, at)
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
        arms, self._reaches = usable_arms(here)
        self._shut = _shut(here, cells.points)
        self.found = np.full(len(cells.points), HIDDEN, dtype=np.uint8)
        thrusts = here.settings.reach.model != "sector"
        self._arms = (*arms, *(arm + len(here.agent.arms) for arm in arms)) if thrusts else arms

    def find(self, configuration: Configuration, places: Indices, cells: Undecided) -> None:
        """What a configuration reaches at some of its places: see ``reach_cells``."""
        count = len(configuration.shoulders)
        shoulders = configuration.shoulders[[arm for arm in self._arms if arm < count]]
        base = configuration.at(places)
        on_threads(lambda part: reach_cells(shoulders, self._reaches, base, part, self.found), cells.parts(len(places)))
        self.found[self._shut] = HIDDEN

    def past_meshes(self, configuration: Configuration, rows: Indices) -> Mask:  # noqa: ARG002 - as those that see
        """Nothing is in the way of an arm, (n,)."""
        return np.ones(len(rows), dtype=bool)


# --- Cells that are shut in.

VOXEL_M = 0.025
BALL_M = 0.013
"""A ball of more than half a voxel's radius passes no wall between two voxels, however thin."""
SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))
FILLED, FLOODED = 1, 2


def _shut(here: Viewpoint, points: Array) -> Indices:
    """Which cells, by their middles in metres, (k, 3), no way leads to; none by the paper's rough reach."""
    if here.settings.reach.model == "sector" or not len(points):
        return np.empty(0, dtype=np.intp)
    stage = here.stage.show(here.state)
    low = points.min(axis=0) - 2 * VOXEL_M
    shape = np.ceil((points.max(axis=0) - low) / VOXEL_M).astype(np.intp) + 2
    starts = np.array([stage.eye(here.agent).position, *(stage.shoulder(arm).position for arm in here.agent.arms)])
    return np.flatnonzero(_shut_in(points, low, shape, here.collisions.solids, starts))


@compiled
def _shut_in(points: Array, low: Array, shape: Indices, solids: Array, starts: Array) -> Mask:
    """Whether the free space around each of some points is closed, (k,); a flood fills the voxels of a box.

    Args:
        points: Metres, (k, 3).
        low: Lowest corner of the box, metres, (3,).
        shape: Voxels along its edges, (3,).
        solids: What is in the way, (n, 17); see ``geometry.solids``.
        starts: Where the flood begins, besides the border of the box, metres, (s, 3).
    """
    voxels = np.zeros((shape[0], shape[1], shape[2]), dtype=np.uint8)
    for row in range(len(solids)):
        if solids[row, BALL] > 0.0:
            _fill(voxels, low, solids, row)
    _flood(voxels, low, starts)
    found = np.ones(len(points), dtype=np.bool_)
    for k in range(len(points)):
        for corner in range(8):
            i = math.floor((points[k, 0] - low[0]) / VOXEL_M + (corner & 1) - 0.5)
            j = math.floor((points[k, 1] - low[1]) / VOXEL_M + (corner >> 1 & 1) - 0.5)
            n = math.floor((points[k, 2] - low[2]) / VOXEL_M + (corner >> 2 & 1) - 0.5)
            found[k] &= voxels[i, j, n] != FLOODED
    return found


@compiled_part
def _fill(voxels: NDArray[np.uint8], low: Array, solids: Array, row: int) -> None:
    """Mark the voxels about whose middles a ball would meet a shape."""
    first, last = np.zeros(3, dtype=np.intp), np.zeros(3, dtype=np.intp)
    for axis in range(3):
        half = solids[row, BALL]
        if int(solids[row, KIND]) == BOX:
            half = 0.0
            for k in range(3):
                half += abs(solids[row, TURNED + 3 * axis + k]) * solids[row, SIZE + k]
        at, most = solids[row, AT + axis] - low[axis], float(voxels.shape[axis])
        first[axis] = int(min(max((at - half - BALL_M) / VOXEL_M - 1.0, 0.0), most))
        last[axis] = int(min(max((at + half + BALL_M) / VOXEL_M + 1.0, 0.0), most))
    for i in range(first[0], last[0]):
        x = low[0] + (i + 0.5) * VOXEL_M - solids[row, AT]
        for j in range(first[1], last[1]):
            y = low[1] + (j + 0.5) * VOXEL_M - solids[row, AT + 1]
            for k in range(first[2], last[2]):
                z = low[2] + (k + 0.5) * VOXEL_M - solids[row, AT + 2]
                lx = x * solids[row, TURNED] + y * solids[row, TURNED + 3] + z * solids[row, TURNED + 6]
                ly = x * solids[row, TURNED + 1] + y * solids[row, TURNED + 4] + z * solids[row, TURNED + 7]
                lz = x * solids[row, TURNED + 2] + y * solids[row, TURNED + 5] + z * solids[row, TURNED + 8]
                if outside_m(solids, row, lx, ly, lz) < BALL_M:
                    voxels[i, j, k] = FILLED


@compiled_part
def _flood(voxels: NDArray[np.uint8], low: Array, starts: Array) -> None:
    """Flood the free voxels from the border, and from some points."""
    a, b, c = voxels.shape
    stack, count = np.empty((a * b * c, 3), dtype=np.int16), 0
    for i in range(a):
        for j in range(b):
            whole = i in (0, a - 1) or j in (0, b - 1)
            for k in range(0, c, 1 if whole else max(c - 1, 1)):
                if voxels[i, j, k] == 0:
                    voxels[i, j, k] = FLOODED
                    stack[count, 0], stack[count, 1], stack[count, 2] = i, j, k
                    count += 1
    for s in range(len(starts)):
        i = math.floor((starts[s, 0] - low[0]) / VOXEL_M)
        j = math.floor((starts[s, 1] - low[1]) / VOXEL_M)
        k = math.floor((starts[s, 2] - low[2]) / VOXEL_M)
        if min(i, j, k) >= 0 and i < a and j < b and k < c and voxels[i, j, k] == 0:
            voxels[i, j, k] = FLOODED
            stack[count, 0], stack[count, 1], stack[count, 2] = i, j, k
            count += 1
    while count:
        count -= 1
        x, y, z = int(stack[count, 0]), int(stack[count, 1]), int(stack[count, 2])
        for dx, dy, dz in SIDES:
            i, j, k = x + dx, y + dy, z + dz
            if min(i, j, k) >= 0 and i < a and j < b and k < c and voxels[i, j, k] == 0:
                voxels[i, j, k] = FLOODED
                stack[count, 0], stack[count, 1], stack[count, 2] = i, j, k
                count += 1
