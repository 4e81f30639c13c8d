"""Sliding a thing over what it lies on: whether it is free all the way, and how far it is to an edge."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.perspective.grasp_sampling import TOUCH_M
from taskgist.settings import Grasp
from taskgist.world.stage import Stage

LEVEL_M = 0.015
"""Support this far beneath a sliding thing still carries it."""
EDGE_STEP_M, FINE_STEP_M = 0.025, 0.0025
"""Spacings of the points at which the edge of a support is looked for: at first, and where it was found."""
LEAST_OUT_M = 0.01
"""What sticks out less than this cannot be taken from beneath (ours)."""
MOST_OUT = 0.4
"""Share of a thing that sticks out at most, so that it does not tip (ours)."""
LEAST_STEP_M = 0.005
"""Steps of a way at which a small thing is tried; thinner walls than that are none (ours)."""
CLEAR_M = 0.002
"""Height over its support at which a thing is slid, so that it does not meet the support itself."""
DOWN = np.array((0.0, 0.0, -1.0))


class OverEdge(NamedTuple):
    """How far a thing is slid until enough of it sticks out over an edge, and how much that is: metres."""

    by_m: float
    out_m: float


class Sliding:
    """An object that lies on something, and may be slid over it.

    Args:
        stage: The scene; what it shows stays the same.
        solids: The object's solid shapes, (k,).
        points: Points of its surface, in the world, metres, (n, 3).
        obstacles: Solid shapes that may be in its way, or carry it, (m,).
        settings: How far things are slid, and how much sticks out then.
        offset: Where it is against what the stage shows, metres, (3,).
    """

    def __init__(
        self,
        stage: Stage,
        solids: Indices,
        points: Array,
        obstacles: Indices,
        settings: Grasp,
        *,
        offset: Array | tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self._stage, self._solids, self._obstacles, self._settings = stage, solids, obstacles, settings
        positions, matrices = stage.geoms(solids)
        self.positions, self.matrices = positions + offset, matrices.reshape(-1, 3, 3).copy()
        self.points = points

    def over_edge(self, way: Array) -> OverEdge | None:
        """How far it is slid along a level direction (3,) to stick out; None if no edge is near, or it is not free."""
        along = self.points @ way
        depth_m = float(np.ptp(along))
        out_m = min(self._settings.overhang_m, MOST_OUT * depth_m)
        edge_m = self._edge_m(way, float(along.max()), depth_m)
        if edge_m is None or edge_m + out_m <= 0.0 or out_m < LEAST_OUT_M:
            return None
        return OverEdge(edge_m + out_m, out_m) if self.is_free_along(way, edge_m + out_m) else None

    def is_free_along(self, way: Array, by_m: float) -> bool:
        """Whether it can be moved so far along a level direction (3,); it may touch others at first."""
        step_m = min(max(float(np.ptp(self.points @ way)) / 2, LEAST_STEP_M), 2 * EDGE_STEP_M)
        steps_m = np.append(np.arange(step_m, by_m, step_m), by_m)
        moves = [way * step_m + (0.0, 0.0, CLEAR_M) for step_m in steps_m]
        return all(self.is_free(self.positions + move, self.matrices) for move in moves)

    def is_free(self, positions: Array, matrices: Array) -> bool:
        """Whether it meets nothing with its solid shapes at positions (k, 3), turned by matrices (k, 3, 3)."""
        stage = self._stage
        stage.place(self._solids, positions, matrices.reshape(-1, 9))
        free = not any(stage.overlaps(self._solids, self._obstacles, deeper_than_m=TOUCH_M))
        stage.show(stage.state)
        return free

    def _edge_m(self, way: Array, front_m: float, depth_m: float) -> float | None:
        """How far before its front its support ends, metres; None if that does not end near enough."""
        coarse_m = np.arange(-depth_m / 2, self._settings.slide_m, EDGE_STEP_M)
        ends = np.flatnonzero(self._is_beyond(way, front_m, coarse_m))
        if not len(ends):
            return None
        fine_m = coarse_m[ends[0]] - np.arange(0.0, EDGE_STEP_M, FINE_STEP_M)[::-1]
        return float(fine_m[np.argmax(self._is_beyond(way, front_m, fine_m))])

    def _is_beyond(self, way: Array, front_m: float, ahead_m: Array) -> Mask:
        """Whether nothing carries it so far before its front, (n,)."""
        middle = self.points.mean(axis=0)
        starts = middle + way * (front_m - middle @ way + ahead_m)[:, None]
        starts[:, 2] = self.points[:, 2].min() + CLEAR_M
        _, distances_m, _ = self._stage.cast_each(self._obstacles, starts, np.tile(DOWN, (len(starts), 1)))
        return np.asarray(distances_m > LEVEL_M)
