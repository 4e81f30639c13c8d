"""Grasps: values, by index, in an object's frame or in the world (5.1.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices
from taskgist.settings import Grasp
from taskgist.world.bodies.hands import Hand, hand_boxes
from taskgist.world.geometry.distances import COLUMNS, EXACT, HALF, RADIUS
from taskgist.world.geometry.shapes import inner_points
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

PER_GRASP = ("centers", "closings", "approaches", "widths_m", "gaps_m", "in_itself", "shapes", "touching")


@dataclass(frozen=True, eq=False)
class Grasps:
    """Sampled grasps, in the object's frame or, once placed, in the world.

    Attributes:
        centers: Half-way between the two points that the hand closes on, metres, (n, 3).
        closings: Unit directions from the thumb's point to the fingers', (n, 3).
        approaches: Unit directions in which the palm comes, (n, 3).
        widths_m: How far the two points are apart, (n,).
        gaps_m: How far fingers and thumb each stand off their point before they close, (n,).
        in_itself: Whether the hand would be in the object itself, other than where it closes on it, (n,).
        shapes: The seen shapes that the points lie on, (n, 2).
        solids: The object's solid shapes, (k,).
        touching: Whether a grasp's fingers touch each of these by design, (n, k).
        narrowest_m: Width of the object's narrowest opposite points, whether the hand opens that wide or not; None if
            it has no opposite faces.
    """

    centers: Array
    closings: Array
    approaches: Array
    widths_m: Array
    gaps_m: Array
    in_itself: NDArray[np.bool_]
    shapes: Indices
    solids: Indices
    touching: NDArray[np.bool_]
    narrowest_m: float | None

    def __len__(self) -> int:
        return len(self.centers)

    def placed(self, pose: Pose) -> Grasps:
        """The same grasps in the world, of an object that stands there."""
        turn = pose.matrix.T
        return replace(
            self,
            centers=pose.to_world(self.centers),
            closings=self.closings @ turn,
            approaches=self.approaches @ turn,
        )

    def only(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Grasps:
        """Some of them."""
        return replace(self, **{field: getattr(self, field)[rows] for field in PER_GRASP})


# --- Where the boxes of a hand are when it grasps (5.1.3).


@dataclass(frozen=True, eq=False)
class Hands:
    """The boxes of a hand in each of n grasps, before it closes.

    Attributes:
        frames: How the hand is turned, (n, 9).
        centers: Middles of its boxes, metres, (n, k, 3).
        boxes: The boxes as rows of a table, to be put there, (k, 18); see ``geometry.boxes``.
        middle: Middle of a ball that holds the hand in all of the grasps, metres, (3,).
        radius_m: Its radius.
    """

    frames: Array
    centers: Array
    boxes: Array
    middle: Array
    radius_m: float

    @classmethod
    def of(cls, grasps: Grasps, hand: Hand) -> Hands:
        """The hand in some grasps; found once for each set of grasps."""
        known = _KNOWN.setdefault(grasps, {})
        if hand not in known:
            half = np.array([box.half_m for box in hand_boxes(hand)])
            boxes = np.zeros((len(half), COLUMNS))
            boxes[:, HALF : HALF + 3], boxes[:, RADIUS], boxes[:, EXACT] = half, np.linalg.norm(half, axis=1), 1.0
            centers = hand_centers(grasps, hand)
            middle = centers.mean(axis=(0, 1))
            radius_m = float((np.linalg.norm(centers - middle, axis=2) + boxes[:, RADIUS]).max())
            known[hand] = cls(hand_frames(grasps).reshape(-1, 9), centers, boxes, middle, radius_m)
        return known[hand]


_KNOWN: WeakKeyDictionary[Grasps, dict[Hand, Hands]] = WeakKeyDictionary()


def hand_frames(grasps: Grasps) -> Array:
    """Axes of the hand in each grasp, (n, 3, 3): columns along the approach, the closing direction, and across."""
    a, c = grasps.approaches.T, grasps.closings.T
    across = (a[1] * c[2] - a[2] * c[1], a[2] * c[0] - a[0] * c[2], a[0] * c[1] - a[1] * c[0])
    return np.stack((grasps.approaches, grasps.closings, np.stack(across, axis=1)), axis=2)


def hand_centers(grasps: Grasps, hand: Hand) -> Array:
    """Middles of the boxes of ``hand_boxes`` in each grasp before the hand closes, metres, (n, k, 3).

    Fingers and thumb stand off the two points by the grasp's gap; their pads are beside them.
    """
    boxes = hand_boxes(hand)
    behind, side, across = (
        np.array(values) for values in zip(*((b.behind_m, b.side, b.across_m) for b in boxes), strict=True)
    )
    beside = side * (grasps.widths_m / 2 + grasps.gaps_m + hand.finger_thickness_m / 2)[:, None]
    local = np.stack((np.broadcast_to(-behind, beside.shape), beside, np.broadcast_to(across, beside.shape)), axis=2)
    return np.asarray(grasps.centers[:, None] + local @ hand_frames(grasps).transpose(0, 2, 1))


# --- Pairs of opposite points of an object's surface, between which a hand could close (5.1.3).
#
# From each of many points of the surface, a ray goes through the object along the inward normal. Where it leaves the
# object by a face that is opposed to the first, the two points make a pair: those of a wall, and, as far as the hand
# opens, those of what is hollow behind it, as the two sides of a mug. All of it happens in the object's own frame.

INSIDE_M = 1e-5
"""How deep beneath the surface a ray starts."""
SAME_M = 1e-4
THINNING = 4
"""Points that share a cell of this fraction of the spacing count once: small and fine shapes have more than needed."""
MOST = 800
"""A shape with more points is sampled in coarser cells, up to the whole spacing (ours)."""


@dataclass(frozen=True, eq=False)
class Pairs:
    """Opposite points of an object's surface, in the object's frame.

    Attributes:
        centers: Half-way between the two points of each pair, metres, (n, 3).
        closings: Unit directions from one point to the other, (n, 3).
        widths_m: How far they are apart, (n,).
        shapes: The seen shapes that they lie on, (n, 2).
    """

    centers: Array
    closings: Array
    widths_m: Array
    shapes: Indices

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Pairs:
        """Some of them."""
        return Pairs(self.centers[rows], self.closings[rows], self.widths_m[rows], self.shapes[rows])


def opposite_points(bench: Stage, name: str, settings: Grasp, within_m: float) -> Pairs:
    """Distinct pairs of opposite points of an object.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
        settings: How densely to sample, and how opposed the faces must be.
        within_m: Behind the first face that a ray leaves by, others count up to this far from where it began.
    """
    shapes = bench.scene.seen_geoms(name)
    points, normals, of_shape = _surface(bench, shapes, settings.cell_m)
    starts = points - INSIDE_M * normals
    back_m = np.full(len(starts), np.inf)
    for shape in np.unique(of_shape):
        rows = of_shape == shape
        back_m[rows] = bench.cast_each([shape], starts[rows], normals[rows])[1]
    found = np.isfinite(back_m)
    starts, normals, of_shape, back_m = starts[found], normals[found], of_shape[found], back_m[found]
    rows, exits, through_m = _exits(bench, shapes, starts, -normals, within_m, math.cos(settings.opposed_rad))
    pairs = Pairs(
        centers=starts[rows] + normals[rows] * ((back_m[rows] - through_m) / 2)[:, None],
        closings=-normals[rows],
        widths_m=through_m + back_m[rows],
        shapes=np.stack((of_shape[rows], exits), axis=1),
    )
    return pairs.take(_distinct(_keys(pairs)))


def _exits(
    bench: Stage, shapes: Indices, starts: Array, rays: Array, within_m: float, opposed: float
) -> tuple[Indices, Indices, Array]:
    """Where rays leave some shapes by a face opposed to the ray: which ray, the shape, and how far it is, (n,) each.

    Every ray has its first face looked at; from there it goes on while it is within the bound.
    """
    rows, passed_m = np.arange(len(starts)), np.zeros(len(starts))
    found = [(np.empty(0, np.intp), np.empty(0, np.intp), np.empty(0))]
    first = True
    while len(rows):
        met, on_m, outward = bench.cast_each(shapes, starts[rows] + rays[rows] * passed_m[:, None], rays[rows])
        through_m = passed_m + on_m
        counts = (met >= 0) & (first | (through_m <= within_m))
        leaves = counts & (np.einsum("ij,ij->i", outward, rays[rows]) >= opposed)
        found.append((rows[leaves], met[leaves].astype(np.intp), through_m[leaves]))
        goes_on = counts & (through_m < within_m)
        rows, passed_m, first = rows[goes_on], through_m[goes_on] + INSIDE_M, False
    each, exits, through = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return each, exits, through


def _surface(bench: Stage, shapes: Indices, spacing_m: float) -> tuple[Array, Array, Indices]:
    """Points and outward normals of shapes, and the shape of each; a fine mesh is thinned."""
    points, normals, of_shape = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, dtype=np.intp)]
    for shape in shapes:
        inner, outward = inner_points(bench.scene.model, int(shape), spacing_m)
        if not len(inner):
            continue
        kept = _thinned(inner, outward, spacing_m)
        pose = bench.geom(int(shape))
        points.append(pose.to_world(inner[kept]))
        normals.append(outward[kept] @ pose.matrix.T)
        of_shape.append(np.full(len(kept), shape))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(of_shape)


def _thinned(points: Array, normals: Array, spacing_m: float) -> Indices:
    """Points of which none share a cell and a side of the surface: in fine cells, or in coarser ones if they are many.

    Small parts of a large shape, as its handle, keep a point on each of their sides.
    """
    cell_m = spacing_m / THINNING
    while True:
        kept = _distinct(np.concatenate((np.round(points / cell_m), np.round(2 * normals)), axis=1))
        if len(kept) <= MOST or cell_m >= spacing_m:
            return kept
        cell_m *= 2


def _keys(pairs: Pairs) -> Array:
    """Centres and undirected closing lines, (n, 6): thumb and fingers may change places."""
    closing = np.round(pairs.closings, 4)
    leading = np.argmax(closing != 0.0, axis=1)
    signs = np.sign(closing[np.arange(len(closing)), leading])
    return np.concatenate((np.round(pairs.centers / SAME_M), closing * signs[:, None]), axis=1)


def _distinct(keys: Array) -> Indices:
    """Indices of the first row of each kind, in order."""
    return np.sort(np.unique(keys + 0.0, axis=0, return_index=True)[1])
