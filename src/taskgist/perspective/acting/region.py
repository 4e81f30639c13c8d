"""Regions: boxes along the world's axes, in which something was looked at or felt for.

An answer of perspective keeps to the regions in which it was found: what moves elsewhere does not change it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
BODIES = 8
"""How many places of an agent are kept apart; further ones are taken together."""
NOWHERE: Array = np.array(((np.inf,) * 3, (-np.inf,) * 3))
SLACK = 1e-9
"""For rounding: rather asked once too often."""


class Region:
    """A box that grows, along the world's axes; empty at first.

    ``bounds`` are its lowest and highest corners in metres, (2, 3).
    """

    def __init__(self) -> None:
        self.bounds: Array = NOWHERE.copy()

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


class Consulted:
    """All that was looked at or felt for, to find an answer.

    Attributes:
        target: Where the object is, and what is near to it.
        eyes: From where it was looked at: all lines from there to the object were.

    Args:
        own: Where the agent is, and what is near to it.
    """

    def __init__(self, own: Region) -> None:
        self.target, self.eyes = Region(), Region()
        self._bodies = [own]

    def add_body(self, region: Region) -> None:
        """Note where the agent might have been, and what is near to it there."""
        if len(self._bodies) == BODIES:
            region.add(self._bodies.pop())
        self._bodies.append(region)

    @property
    def bounds(self) -> Array:
        """Lowest and highest corners of object, eyes and bodies, metres, (2 + BODIES, 2, 3); empty ones at last."""
        regions = [self.target, self.eyes, *self._bodies]
        return np.stack([region.bounds for region in regions] + [NOWHERE] * (2 + BODIES - len(regions)))


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
            found[i] |= not _apart(regions[i], boxes[k])
    return found


@compiled
def crossed(consulted: Array, boxes: Array) -> NDArray[np.bool_]:
    """Whether what was consulted for each answer, (n, 2 + BODIES, 2, 3), touches any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(consulted), dtype=np.bool_)
    for i in range(len(consulted)):
        target, eyes, bodies = consulted[i, 0], consulted[i, 1], consulted[i, 2:]
        start = target if _empty(eyes) else eyes
        for k in range(len(boxes)):
            found[i] |= not _empty(target) and _between(start, target, boxes[k])
            for body in range(len(bodies)):
                if found[i] or _empty(bodies[body]):
                    break
                found[i] = not _apart(bodies[body], boxes[k])
    return found


@compiled
def _empty(box: Array) -> bool:
    return bool(box[0, 0] > box[1, 0])


@compiled
def _apart(one: Array, other: Array) -> bool:
    """Whether two boxes, (2, 3), do not touch."""
    apart = False
    for axis in range(3):
        apart |= one[0, axis] > other[1, axis] or other[0, axis] > one[1, axis]
    return apart


@compiled
def _between(start: Array, end: Array, box: Array) -> bool:
    """Whether a box touches the convex hull of two others, all (2, 3): a box on the way from one to the other.

    Each face of those moves evenly with the share of the way, which bounds the shares at which they may touch.
    """
    least, most = 0.0, 1.0
    for axis in range(3):
        for side, bound in ((0, box[1, axis]), (1, box[0, axis])):
            sign = 1.0 - 2.0 * side  # the lower face must not be above the box, nor the upper one below it
            at, by = sign * (start[side, axis] - bound), sign * (end[side, axis] - start[side, axis])
            if by == 0.0:
                if at > 0.0:
                    return False
            elif by > 0.0:
                most = min(most, -at / by)
            else:
                least = max(least, -at / by)
    return least <= most + SLACK
