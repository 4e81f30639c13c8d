"""Clearance: signed gaps between the shapes of a scene in a state.

Balls and boxes around shapes reject most pairs for many at once; MuJoCo measures the rest.
"""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.geometry.box_gaps import next_near
from taskgist.world.geometry.boxes import ball_around, boxes_of
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.gaps import gap_m

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Pair = tuple[int, int]


class Clearance:
    """Measures gaps in a model whose shapes are where some data says.

    Attributes:
        measured_count: Pairs measured so far.

    Args:
        model: The model.
        data: Where its shapes are; read anew with every question.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._kinds = np.array(model.geom_type, dtype=np.int64)
        self._radii = np.where(model.geom_rbound == 0.0, np.inf, model.geom_rbound)  # endless planes
        self._bounds = np.array(model.geom_aabb)
        self._positions, self._matrices = data.geom_xpos, data.geom_xmat
        self.measured_count = 0

    def gap_m(self, geom: int, other: int, *, limit_m: float) -> float:
        """Signed gap in metres between two shapes (negative: how deep they overlap), at most ``limit_m``."""
        self.measured_count += 1
        return gap_m(self._model, self._data, geom, other, limit_m=limit_m)

    def near_pairs(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> list[Pair]:
        """Pairs of shapes, one of each set, that may come closer than ``limit_m``; all others do not."""
        pairs = near_pairs(
            np.asarray(geoms, dtype=np.intp),
            np.asarray(others, dtype=np.intp),
            self._kinds,
            self._radii,
            self._bounds,
            self._positions,
            self._matrices,
            limit_m,
        )
        return [(first, second) for first, second in pairs.tolist()]

    def boxes(self, geoms: Indices) -> Array:
        """Boxes around shapes where they are now, (n, 18); see ``boxes_of``."""
        return boxes_of(geoms, self._kinds, self._radii, self._bounds, self._positions, self._matrices)

    def closest(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> tuple[float, int, int]:
        """The smallest signed gap in metres between two sets of shapes, at most ``limit_m``, and the pair or −1."""
        best = (limit_m, -1, -1)
        for geom, other in self.near_pairs(geoms, others, limit_m=limit_m):
            gap = self.gap_m(geom, other, limit_m=limit_m)
            if gap < best[0]:
                best = (gap, geom, other)
        return best

    def overlaps(
        self, geoms: ArrayLike, others: ArrayLike, *, deeper_than_m: float = 0.0
    ) -> Iterator[tuple[int, int, float]]:
        """Pairs of shapes, one of each set, that overlap deeper than that, and how deep in metres."""
        # Half as deep is looked at as well: MuJoCo measures round shapes by iteration, not to the last digit.
        for geom, other in self.near_pairs(geoms, others, limit_m=-deeper_than_m / 2):
            gap = self.gap_m(geom, other, limit_m=0.0)
            if gap < -deeper_than_m:
                yield geom, other, -gap


@compiled
def near_pairs(
    geoms: Indices,
    others: Indices,
    kinds: NDArray[np.int64],
    radii: Array,
    bounds: Array,
    positions: Array,
    matrices: Array,
    limit_m: float,
) -> Indices:
    """Pairs of shapes whose gap may be below a limit, (n, 2); see ``boxes_of``."""
    found, count = np.empty((len(geoms) * len(others), 2), dtype=np.intp), 0
    if not len(geoms) or not len(others):
        return found
    first = boxes_of(geoms, kinds, radii, bounds, positions, matrices)
    cx, cy, cz, radius_m = ball_around(first)
    near, kept = np.empty(len(others), dtype=np.intp), 0
    for other in others:
        x, y, z = positions[other, 0] - cx, positions[other, 1] - cy, positions[other, 2] - cz
        reach = max(radius_m + radii[other] + limit_m, 0.0)
        if x * x + y * y + z * z <= reach * reach:
            near[kept] = other
            kept += 1
    second = boxes_of(near[:kept], kinds, radii, bounds, positions, matrices)
    pair = next_near(first, second, limit_m, 0)
    while pair >= 0:
        found[count, 0], found[count, 1] = geoms[pair // kept], near[pair % kept]
        count += 1
        pair = next_near(first, second, limit_m, pair + 1)
    return found[:count]
