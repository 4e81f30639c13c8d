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
        near = _in_ball(grid, pose.position, float(model.geom_rbound[geom]))
        near = near[~found[near]]
        outside = distances_outside_m(model, int(geom), pose.to_local(centers[near]))
        found[near[outside <= 0.0]] = True
    return found.reshape(grid.shape)


def _in_ball(grid: Grid, center: NDArray[np.float64], radius_m: float) -> NDArray[np.intp]:
    """Indices of the cells of the upright box around a ball, (n,)."""
    middle = (center - grid.origin_m) @ grid.axes / grid.cell_m
    reach = radius_m / grid.cell_m
    ranges = [
        np.arange(max(0, int(np.floor(at - reach))), min(count, int(np.ceil(at + reach)) + 1))
        for at, count in zip(middle, grid.shape, strict=True)
    ]
    return np.ravel_multi_index(np.meshgrid(*ranges, indexing="ij"), grid.shape).ravel()
