"""The grid of an ability map: cubes of the workspace, anchored to an agent."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.errors import InputError
from taskgist.settings import DEFAULT, Maps
from taskgist.world.geometry.shapes import distances_outside_m
from taskgist.world.geometry.transforms import yaw_of
from taskgist.world.stage import Stage

Cell = tuple[int, int, int]
MOST_CELLS = 20_000_000
"""Cells of the largest grid: beyond, a mistaken unit is more likely than a hall."""


@dataclass(frozen=True)
class Grid:
    """Cubes in rows along the axes of a frame that stands upright on the floor.

    Attributes:
        origin_m: The corner with the least coordinates, metres in the world.
        yaw_rad: Direction of the first axis, about the vertical.
        cell_m: Edge of a cell.
        shape: Cells along each axis, the third upwards.
    """

    origin_m: tuple[float, float, float]
    yaw_rad: float
    cell_m: float
    shape: Cell

    def __post_init__(self) -> None:
        if not (self.cell_m > 0 and min(self.shape) >= 1 and math.prod(self.shape) <= MOST_CELLS):
            size = {"cell_m": self.cell_m, "shape": self.shape}
            raise InputError(
                "no such grid can be made",
                field="grid",
                value=size,
                hint=f"cells have an edge above zero, and there are 1 to {MOST_CELLS:,} of them",
            )

    @classmethod
    def around(cls, stage: Stage, *agents: str, settings: Maps = DEFAULT.maps) -> Grid:
        """The workspace of an agent: its axes lie along its heading, and it stands in the middle.

        Args:
            stage: The scene in a state.
            agents: With several of them, the axes are the first one's, and the grid holds the workspaces of all.
            settings: Size of cells and workspace.

        Raises:
            UnknownNameError: There is no such agent.
        """
        bases = np.array([stage.state.qpos[stage.scene.base_slice(agent)] for agent in agents])
        yaw = yaw_of(bases[0, 3:])
        axes = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
        offsets = (bases[:, :2] - bases[0, :2]) @ axes.T
        half = round(settings.half_width_m / settings.cell_m)
        low = np.floor(np.round(offsets.min(axis=0) / settings.cell_m, 6)).astype(int) - half
        high = np.ceil(np.round(offsets.max(axis=0) / settings.cell_m, 6)).astype(int) + half
        corner = bases[0, :2] + settings.cell_m * low @ axes
        sides = [int(side) for side in high - low]
        upwards = round(settings.height_m / settings.cell_m)
        return cls((float(corner[0]), float(corner[1]), 0.0), yaw, settings.cell_m, (sides[0], sides[1], upwards))

    @property
    def axes(self) -> Array:
        """The frame's axes in the world, the columns of (3, 3)."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])

    def centers(self) -> Array:
        """Centres of all cells in the world, metres, (cells, 3), the last axis running fastest."""
        first, second, third = (self.cell_m * (np.arange(count) + 0.5) for count in self.shape)
        columns = np.stack(np.broadcast_arrays(first[:, None], second, 0.0), axis=-1).reshape(-1, 3)
        centers = np.empty((*self.shape, 3))
        centers[..., :2] = (columns @ self.axes.T + self.origin_m).reshape(*self.shape[:2], 1, 3)[..., :2]
        centers[..., 2] = third + self.origin_m[2]
        return centers.reshape(-1, 3)

    def center(self, cell: Cell) -> Array:
        """Centre of a cell in the world, metres, (3,)."""
        return np.asarray(self.cell_m * (np.array(cell) + 0.5) @ self.axes.T + self.origin_m)

    def cells_at(self, points: ArrayLike) -> Indices:
        """Cells in which points lie, (n, 3); such indices may lie outside of the grid.

        Args:
            points: Metres in the world, (n, 3).
        """
        local = (np.asarray(points, dtype=float) - self.origin_m) @ self.axes
        return np.asarray(np.floor(local / self.cell_m), dtype=np.intp)

    def holds(self, cells: Indices) -> Mask:
        """Whether cells (n, 3) lie in the grid, (n,)."""
        return np.asarray(((cells >= 0) & (cells < self.shape)).all(axis=1))


# --- The cells of a grid in blocks: what is plain of a whole block need not be found for each of its cells.

EDGE = 4
"""Cells along the edge of a block."""
BLOCK_CELLS = EDGE**3
"""Cells of a block."""
PARTS = 4
"""Into how many parts blocks are dealt out like cards, so that each takes about as long as the others."""
FEW = 20_000
"""Looks at a cell from a place: so few are done sooner than a thread is started."""
OUTSIDE = -1
ROUNDING_M = 1e-9


class Undecided(NamedTuple):
    """Cells that are asked for, block by block, as compiled functions take them, which drop those that they decide.

    Attributes:
        points: Centres of all cells, metres in the world, (cells, 3).
        rows: Which cells are asked for; those of each block stand together, (n,).
        starts: Where the cells of each block begin, (blocks,).
        counts: How many of these are undecided still: its first ones, (blocks,).
        middles: Centres of balls around the cells of each block, metres, (blocks, 3).
        radii_m: Radii of these, (blocks,).
    """

    points: Array
    rows: Indices
    starts: Indices
    counts: Indices
    middles: Array
    radii_m: Array

    def parts(self, places: int) -> list[Undecided]:
        """The same in parts, which may be decided at the same time: each has its own cells and counts.

        Args:
            places: From how many each cell is looked at.
        """
        if len(self.starts) < PARTS or self.counts.sum() * places < FEW:
            return [self]
        points, rows, *blocks = self
        cut = [np.array_split(each, PARTS) for each in blocks]
        return [Undecided(points, rows, *part) for part in zip(*cut, strict=True)]


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
        return cls(grid.centers()[index], index, rows // BLOCK_CELLS)

    def undecided(self, rows: Indices) -> Undecided:
        """Some cells, one or more, in ascending order, (n,)."""
        starts = np.concatenate(([0], np.flatnonzero(np.diff(self.block[rows])) + 1))
        counts, points = np.diff(starts, append=len(rows)), self.points[rows]
        low, high = np.minimum.reduceat(points, starts), np.maximum.reduceat(points, starts)
        middles, radii_m = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2 + ROUNDING_M
        order = np.argsort(np.arange(len(starts)) % PARTS, kind="stable")
        return Undecided(self.points, rows.copy(), starts[order], counts[order], middles[order], radii_m[order])


# --- Which cells lie in something solid.


def solid_cells(stage: Stage, grid: Grid, *, but: str | None = None) -> Mask:
    """Cells whose centres lie in something solid, the grid's shape; meshes count as their collision shapes.

    Args:
        stage: The scene in a state.
        grid: The grid.
        but: An agent, object or piece of furniture that does not count.
    """
    centers = grid.centers()
    found = np.zeros(len(centers), dtype=bool)
    model = stage.scene.model
    for geom in stage.solid_geoms():
        if stage.scene.owners[geom] == but or stage.is_plane(int(geom)):
            continue
        pose = stage.geom(int(geom))
        near = _around(grid, pose.to_world(model.geom_aabb[geom, :3]), pose.matrix, model.geom_aabb[geom, 3:])
        near = near[~found[near]]
        outside = distances_outside_m(model, int(geom), pose.to_local(centers[near]))
        found[near[outside <= 0.0]] = True
    return found.reshape(grid.shape)


def _around(grid: Grid, middle: Array, matrix: Array, half_m: Array) -> Indices:
    """Indices of the cells of the box along the grid's axes around a box that is turned, (n,)."""
    at = (middle - grid.origin_m) @ grid.axes / grid.cell_m
    reach = np.abs(grid.axes.T @ matrix) @ half_m / grid.cell_m
    low = np.maximum(np.floor(at - reach), 0).astype(int)
    high = np.minimum(np.ceil(at + reach).astype(int) + 1, grid.shape)
    first, second, third = (np.arange(*ends) for ends in zip(low, high, strict=True))
    _, across, up = grid.shape
    return ((first[:, None, None] * across + second[:, None]) * up + third).ravel()


# --- Zones of space: sets of cells of one grid, with the algebra of sets.


@dataclass(frozen=True, eq=False)
class Zone:
    """Some cells of a grid.

    Zones of one grid are combined with ``&`` (and), ``|`` (or), ``-`` (without) and ``~`` (all other cells).

    Attributes:
        grid: The grid.
        cells: Whether each cell belongs to it, the grid's shape, read-only.
    """

    grid: Grid
    cells: Mask

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

    def contains(self, points: ArrayLike) -> Mask:
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
