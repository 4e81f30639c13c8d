"""Which cells lie in something solid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.grid import Grid
from taskgist.world import Stage
from taskgist.world.geometry.solids import distances_outside_m


def solid_cells(stage: Stage, grid: Grid, *, but: str | None = None) -> NDArray[np.bool_]:
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


def _around(
    grid: Grid, middle: NDArray[np.float64], matrix: NDArray[np.float64], half_m: NDArray[np.float64]
) -> NDArray[np.intp]:
    """Indices of the cells of the box along the grid's axes around a box that is turned, (n,)."""
    at = (middle - grid.origin_m) @ grid.axes / grid.cell_m
    reach = np.abs(grid.axes.T @ matrix) @ half_m / grid.cell_m
    low = np.maximum(np.floor(at - reach), 0).astype(int)
    high = np.minimum(np.ceil(at + reach).astype(int) + 1, grid.shape)
    first, second, third = (np.arange(*ends) for ends in zip(low, high, strict=True))
    _, across, up = grid.shape
    return ((first[:, None, None] * across + second[:, None]) * up + third).ravel()
