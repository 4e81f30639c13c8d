"""Regions: boxes along the world's axes, in which something was looked at or felt for.

An answer of perspective keeps to the region in which it was found: what moves elsewhere does not change it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]


class Region:
    """A box that grows, along the world's axes; empty at first.

    ``bounds`` are its lowest and highest corners in metres, (2, 3).
    """

    def __init__(self) -> None:
        self.bounds: Array = np.array(((np.inf,) * 3, (-np.inf,) * 3))

    def add_balls(self, centers: Array, radii_m: Array) -> None:
        """Let it hold balls: centres in metres, (n, 3), and radii, (n,)."""
        _add_balls(self.bounds, centers, radii_m)

    def add_points(self, points: Array, margin_m: float = 0.0) -> None:
        """Let it hold points, metres, (n, 3), and what is within a margin of them."""
        _add_balls(self.bounds, points, np.full(len(points), margin_m))

    def add(self, other: Region) -> None:
        """Let it hold another region."""
        np.minimum(self.bounds[0], other.bounds[0], out=self.bounds[0])
        np.maximum(self.bounds[1], other.bounds[1], out=self.bounds[1])

    def grow(self, by_m: ArrayLike) -> None:
        """Let it reach farther on all sides."""
        self.bounds[0] -= by_m
        self.bounds[1] += by_m


@compiled
def _add_balls(bounds: Array, centers: Array, radii_m: Array) -> None:
    for i in range(len(centers)):
        for axis in range(3):
            bounds[0, axis] = min(bounds[0, axis], centers[i, axis] - radii_m[i])
            bounds[1, axis] = max(bounds[1, axis], centers[i, axis] + radii_m[i])


@compiled
def touched(regions: Array, boxes: Array) -> NDArray[np.bool_]:
    """Whether each region, (n, 2, 3), touches any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(regions), dtype=np.bool_)
    for i in range(len(regions)):
        for k in range(len(boxes)):
            apart = False
            for axis in range(3):
                apart |= regions[i, 0, axis] > boxes[k, 1, axis] or boxes[k, 0, axis] > regions[i, 1, axis]
            if not apart:
                found[i] = True
                break
    return found
