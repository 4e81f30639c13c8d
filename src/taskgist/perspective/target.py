"""The object that an ability is asked about, as it is in one state, and where it was looked or felt for.

An answer of perspective keeps to the regions in which it was found: what moves elsewhere does not change it. They are
noted where things are looked at and collisions are tested, for all abilities alike.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.effort import Vector
from taskgist.settings import Settings
from taskgist.world.contacts import object_points, seat_m
from taskgist.world.stage import Stage


def vector(values: Array) -> Vector:
    """A point or a direction, (3,), as plain numbers for evidence."""
    x, y, z = values.tolist()
    return (x, y, z)


SQUARE_ARCMIN_SR = math.radians(1 / 60) ** 2
"""A square minute of arc in steradians."""
SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


class Sought(NamedTuple):
    """An object that is looked for, as compiled functions take it.

    Attributes:
        shapes: Its seen shapes, (n,).
        centers: Their centres, metres, (n, 3).
        radii_m: Radii of balls about these that hold the shapes, (n,).
        corners: Corners of the boxes around them, metres, (8 n, 3).
        middle: Mean of the centres, (3,).
    """

    shapes: Indices
    centers: Array
    radii_m: Array
    corners: Array
    middle: Array


def box_corners(stage: Stage, shapes: Indices) -> Array:
    """Corners of the boxes around some shapes, each in its own frame, metres in the world, (8 n, 3)."""
    bounds = stage.scene.model.geom_aabb[shapes]
    local = bounds[:, None, :3] + SIGNS * bounds[:, None, 3:]
    positions, matrices = stage.geoms(shapes)
    turned = local @ matrices.reshape(-1, 3, 3).transpose(0, 2, 1)
    return np.asarray((turned + positions[:, None]).reshape(-1, 3))


class Target:
    """An object where it is. It may be asked while the stage shows other states of some agent: objects stay.

    Args:
        stage: The scene.
        name: The object.
        settings: Size of the cells.
    """

    def __init__(self, stage: Stage, name: str, settings: Settings) -> None:
        self._stage, self.name, self._settings = stage, name, settings
        self.shapes = stage.scene.seen_geoms(name)

    @cached_property
    def centers(self) -> Array:
        """Centres of its seen shapes, metres, (n, 3)."""
        return self._stage.geom_centers(self.shapes)

    @cached_property
    def radii_m(self) -> Array:
        """Radii of balls about these that hold the shapes, (n,)."""
        return np.asarray(self._stage.scene.model.geom_rbound[self.shapes])

    @cached_property
    def middle(self) -> Array:
        """Mean of the centres, metres, (3,)."""
        return np.asarray(self.centers.mean(axis=0))

    @cached_property
    def points(self) -> Array:
        """Points of its cells, metres, (k, 3)."""
        return object_points(self._stage, self.name, self._settings.reach.cell_m)

    @cached_property
    def seat_m(self) -> float | None:
        """How far up it must be moved to lie on what carries it, metres; None if nothing does."""
        return seat_m(self._stage, self.name, self._settings.contact)

    @cached_property
    def corners(self) -> Array:
        """Corners of the boxes around its seen shapes, metres, (8 n, 3)."""
        return box_corners(self._stage, self.shapes)

    @property
    def least_sr(self) -> float:
        """The least solid angle of it that is made out, steradians."""
        return self._settings.vision.least_visible_arcmin2 * SQUARE_ARCMIN_SR

    @cached_property
    def sought(self) -> Sought:
        """For those who look for it."""
        return Sought(self.shapes, self.centers, self.radii_m, self.corners, self.middle)

    @cached_property
    def others(self) -> Indices:
        """All other seen shapes of the scene that are not looked through, (m,)."""
        counted = self._stage.seen & self._stage.scene.hiding(self._settings.vision.transparent_alpha)
        counted[self.shapes] = False
        return np.flatnonzero(counted)


@compiled
def ball_around(points: Array) -> tuple[Array, float]:
    """Middle of the box around some points, and how far the farthest is from it."""
    low, high, squared = np.full(3, np.inf), np.full(3, -np.inf), 0.0
    if not len(points):
        return np.zeros(3), 0.0
    for k in range(len(points)):
        for axis in range(3):
            low[axis], high[axis] = min(low[axis], points[k, axis]), max(high[axis], points[k, axis])
    middle = (low + high) / 2
    for k in range(len(points)):
        x, y, z = points[k, 0] - middle[0], points[k, 1] - middle[1], points[k, 2] - middle[2]
        squared = max(squared, x * x + y * y + z * z)
    return middle, math.sqrt(squared)


# --- Regions: boxes along the world's axes, in which something was looked at or felt for.

BODIES = 12
"""How many places of an agent are kept apart; further ones are taken together."""
ROUNDED_M = 1e-5
"""More than ways are rounded by where they are compared."""
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
        _add_balls(self.bounds, np.ascontiguousarray(centers), radii_m)

    def add_points(self, points: Array, margin_m: float = 0.0) -> None:
        """Let it hold points, metres, (n, 3), and what is within a margin of them."""
        self.add_balls(points, np.full(len(points), margin_m))

    def add(self, other: Region) -> None:
        """Let it hold another region."""
        np.minimum(self.bounds[0], other.bounds[0], out=self.bounds[0])
        np.maximum(self.bounds[1], other.bounds[1], out=self.bounds[1])

    def grow(self, by_m: ArrayLike) -> None:
        """Let it reach farther on all sides."""
        self.bounds[0] -= by_m
        self.bounds[1] += by_m


class Recorder:
    """Where all was looked or felt for, to find an answer. What the agent touches and holds now is not noted.

    Attributes:
        target: Where the object is, and what is near to it.
        eyes: From where it was looked at: all lines from there to the object were.
        arms: Where arms were on their way to it.
        postures: Whether it mattered which postures the agent can take.
    """

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Forget all for a new answer."""
        self.target, self.eyes, self.arms = Region(), Region(), Region()
        self.postures = False
        self._ways_m: list[float] = []
        self._bodies: list[Region] = []

    @contextmanager
    def apart(self) -> Iterator[Region]:
        """Note bodies in a region of its own, for a while, instead of for the present answer."""
        before, self._bodies, together = self._bodies, [], Region()
        try:
            yield together
        finally:
            for region in self._bodies:
                together.add(region)
            self._bodies = before

    def add_ways(self, longest_m: float) -> None:
        """Note that places were tried at the end of ways up to some length, metres."""
        self._ways_m.append(longest_m)

    def found_after(self, way_m: float) -> None:
        """Note that of those ways that were added at last none mattered that is longer than that."""
        if self._ways_m:
            self._ways_m[-1] = min(self._ways_m[-1], way_m + ROUNDED_M)

    @property
    def floor_m(self) -> float:
        """How long the ways are at most over which places mattered that the agent can get to, metres."""
        return max(self._ways_m, default=0.0)

    def add_body(self, region: Region) -> None:
        """Note where the agent might have been, and what is near to it there."""
        if len(self._bodies) == BODIES:
            region.add(self._bodies.pop())
        self._bodies.append(region)

    @property
    def bounds(self) -> Array:
        """Lowest and highest corners of object, eyes, arms and bodies, metres, (3 + BODIES, 2, 3); empty ones last."""
        regions = [self.target, self.eyes, self.arms, *self._bodies]
        return np.stack([region.bounds for region in regions] + [NOWHERE] * (3 + BODIES - len(regions)))


@compiled
def _add_balls(bounds: Array, centers: Array, radii_m: Array) -> None:
    for i in range(len(centers)):
        for axis in range(3):
            bounds[0, axis] = min(bounds[0, axis], centers[i, axis] - radii_m[i])
            bounds[1, axis] = max(bounds[1, axis], centers[i, axis] + radii_m[i])


@compiled
def touched(regions: Array, boxes: Array) -> Mask:
    """Whether each region, (n, 2, 3), touches any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(regions), dtype=np.bool_)
    for i in range(len(regions)):
        for k in range(len(boxes)):
            found[i] |= not _apart(regions[i], boxes[k])
    return found


@compiled
def crossed(recorded: Array, boxes: Array) -> Mask:
    """Whether the regions of each answer, (n, 3 + BODIES, 2, 3), touch any of some boxes, (k, 2, 3); (n,)."""
    found = np.zeros(len(recorded), dtype=np.bool_)
    for i in range(len(recorded)):
        target, eyes, bodies = recorded[i, 0], recorded[i, 1], recorded[i, 2:]
        start = target if _empty(eyes) else eyes
        for k in range(len(boxes)):
            found[i] |= not _empty(target) and _between(start, target, boxes[k])
            for body in range(len(bodies)):
                found[i] |= not (_empty(bodies[body]) or _apart(bodies[body], boxes[k]))
            if found[i]:
                break
    return found


@compiled_part
def _empty(box: Array) -> bool:
    return bool(box[0, 0] > box[1, 0])


@compiled_part
def _apart(one: Array, other: Array) -> bool:
    """Whether two boxes, (2, 3), do not touch."""
    apart = False
    for axis in range(3):
        apart |= one[0, axis] > other[1, axis] or other[0, axis] > one[1, axis]
    return apart


@compiled_part
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
