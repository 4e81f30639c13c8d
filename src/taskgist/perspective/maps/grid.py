"""The grid of an ability map: cubes of the workspace, anchored to an agent."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.errors import InputError
from taskgist.settings import DEFAULT, Maps
from taskgist.world import Stage
from taskgist.world.geometry.rotations import yaw_of

Array = NDArray[np.float64]
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

    def cells_at(self, points: ArrayLike) -> NDArray[np.intp]:
        """Cells in which points lie, (n, 3); such indices may lie outside of the grid.

        Args:
            points: Metres in the world, (n, 3).
        """
        local = (np.asarray(points, dtype=float) - self.origin_m) @ self.axes
        return np.asarray(np.floor(local / self.cell_m), dtype=np.intp)

    def holds(self, cells: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Whether cells (n, 3) lie in the grid, (n,)."""
        return np.asarray(((cells >= 0) & (cells < self.shape)).all(axis=1))
