"""Places of the floor where an agent may turn as it likes: nothing solid comes near it, whichever way it faces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.world import State

Array = NDArray[np.float64]
LEVEL = 0.999
"""Cosine of the slope of what counts as a level floor."""


def clear_places(here: Standpoint, state: State, base_m: Array, places_m: Array) -> NDArray[np.bool_]:
    """Whether an agent, standing as in a state, plainly collides with nothing at each place, whatever its heading.

    Turning about the vertical through its base, each of its shapes stays in a cylinder. The boxes around solid shapes
    must keep away from these. The level floor is left out: it is met alike at all places.

    Args:
        here: The agent's standpoint.
        state: How it stands.
        base_m: Where its base is in that state, metres, (2,).
        places_m: Where it would be instead, metres in the world, (n, 2).

    Returns:
        False where it has to be tested, (n,).
    """
    stage, model, core = here.stage.show(state), here.stage.scene.model, here.agent.core_geoms
    obstacles = here.collisions.obstacles
    endless = model.geom_rbound[obstacles] == 0.0
    matrices = stage.geoms(obstacles)[1].reshape(-1, 3, 3)
    if (matrices[endless, 2, 2] < LEVEL).any():
        return np.zeros(len(places_m), dtype=bool)
    centers, radii = stage.geom_centers(core), np.asarray(model.geom_rbound[core])
    wide = np.linalg.norm(centers[:, :2] - base_m, axis=1) + radii
    middle, half = _extents(here, obstacles[~endless])
    beside = np.abs(centers[:, 2, None] - middle[:, 2]) < radii[:, None] + half[:, 2]
    widest = np.where(beside, wide[:, None], 0.0).max(axis=0)
    away = np.maximum(np.abs(places_m[:, None] - middle[:, :2]) - half[:, :2], 0.0)
    return np.asarray((np.hypot(away[..., 0], away[..., 1]) >= widest).all(axis=1))


def _extents(here: Standpoint, geoms: NDArray[np.intp]) -> tuple[Array, Array]:
    """How far shapes extend along the world's axes, as the stage shows them: middles and half sizes, metres, (n, 3)."""
    positions, matrices = here.stage.geoms(geoms)
    turns, bounds = matrices.reshape(-1, 3, 3), here.stage.scene.model.geom_aabb[geoms]
    middle = positions + np.einsum("nij,nj->ni", turns, bounds[:, :3])
    return middle, np.einsum("nij,nj->ni", np.abs(turns), bounds[:, 3:])
