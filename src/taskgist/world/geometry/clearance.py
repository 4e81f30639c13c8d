"""Clearance: signed gaps between the shapes of a scene in a state.

Bounding spheres and boxes reject most pairs for many at once; MuJoCo measures the rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

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
        self._radius = np.where(model.geom_rbound == 0.0, np.inf, model.geom_rbound)  # endless planes
        self._bounds = np.array(model.geom_aabb)
        self.measured_count = 0

    def gap_m(self, geom: int, other: int, *, limit_m: float) -> float:
        """Signed gap in metres between two shapes (negative: how deep they overlap), at most ``limit_m``."""
        self.measured_count += 1
        return gap_m(self._model, self._data, geom, other, limit_m=limit_m)

    def near_pairs(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> list[Pair]:
        """Pairs of shapes, one of each set, that may come closer than ``limit_m``; all others do not."""
        data = self._data
        pairs = near_pairs(
            np.asarray(geoms, dtype=np.intp),
            np.asarray(others, dtype=np.intp),
            self._radius,
            self._bounds,
            data.geom_xpos,
            data.geom_xmat,
            limit_m,
        )
        return [(first, second) for first, second in pairs.tolist()]

    def closest(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> tuple[float, int, int]:
        """The smallest signed gap in metres between two sets of shapes, at most ``limit_m``, and the pair or −1."""
        best = (limit_m, -1, -1)
        for geom, other in self.near_pairs(geoms, others, limit_m=limit_m):
            gap = self.gap_m(geom, other, limit_m=limit_m)
            if gap < best[0]:
                best = (gap, geom, other)
        return best

    def overlaps(self, geoms: ArrayLike, others: ArrayLike) -> Iterator[tuple[int, int, float]]:
        """Pairs of shapes, one of each set, that overlap, and how deep in metres."""
        for geom, other in self.near_pairs(geoms, others, limit_m=0.0):
            gap = self.gap_m(geom, other, limit_m=0.0)
            if gap < 0.0:
                yield geom, other, -gap


@compiled
def near_pairs(
    geoms: Indices,
    others: Indices,
    radii: Array,
    bounds: Array,
    positions: Array,
    matrices: Array,
    limit_m: float,
) -> Indices:
    """Pairs of shapes whose gap may be below a limit, (n, 2).

    Neither sphere against sphere nor sphere against box (or plane) keeps them apart. Radii are infinite for planes;
    ``bounds`` are middles and half sizes, (ngeom, 6).
    """
    found = np.empty((len(geoms) * len(others), 2), dtype=np.intp)
    count = 0
    for a in geoms:
        for b in others:
            reach = radii[a] + radii[b] + limit_m
            x = positions[a, 0] - positions[b, 0]
            y = positions[a, 1] - positions[b, 1]
            z = positions[a, 2] - positions[b, 2]
            if x * x + y * y + z * z >= reach * reach:
                continue
            if box_gap_m(a, b, radii, bounds, positions, matrices) >= limit_m:
                continue
            if box_gap_m(b, a, radii, bounds, positions, matrices) >= limit_m:
                continue
            found[count, 0], found[count, 1] = a, b
            count += 1
    return found[:count]


@compiled
def box_gap_m(geom: int, other: int, radii: Array, bounds: Array, positions: Array, matrices: Array) -> float:
    """Gap in metres between the bounding sphere of a shape and the box around another, or the other plane."""
    x = positions[geom, 0] - positions[other, 0]
    y = positions[geom, 1] - positions[other, 1]
    z = positions[geom, 2] - positions[other, 2]
    m, b = matrices[other], bounds[other]
    if np.isinf(radii[other]):
        return float(x * m[2] + y * m[5] + z * m[8] - radii[geom])
    squared = 0.0
    for axis in range(3):
        at = x * m[axis] + y * m[3 + axis] + z * m[6 + axis]
        outside = max(abs(at - b[axis]) - b[3 + axis], 0.0)
        squared += outside * outside
    return float(math.sqrt(squared) - radii[geom])
