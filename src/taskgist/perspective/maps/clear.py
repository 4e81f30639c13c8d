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
    stage, model = here.stage.show(state), here.stage.scene.model
    core = here.agent.core_geoms
    centers, radii = stage.geom_centers(core), np.asarray(model.geom_rbound[core])
    wide = np.linalg.norm(centers[:, :2] - base_m, axis=1) + radii
    clear = np.ones(len(places_m), dtype=bool)
    for geom in here.collisions.obstacles.tolist():
        pose = stage.geom(geom)
        if stage.is_plane(geom):
            if pose.matrix[2, 2] < LEVEL:
                clear[:] = False
            continue
        middle = pose.to_world(model.geom_aabb[geom, :3])
        half = np.abs(pose.matrix) @ model.geom_aabb[geom, 3:]
        beside = np.abs(centers[:, 2] - middle[2]) < radii + half[2]
        if beside.any():
            away = np.maximum(np.abs(places_m - middle[:2]) - half[:2], 0.0)
            clear &= np.hypot(away[:, 0], away[:, 1]) >= wide[beside].max()
    return clear
