"""Pairs of opposite points of an object's surface, between which a hand could close (5.1.3).

From each of many points of the surface, a ray goes through the object along the inward normal. Where it leaves the
object by a face that is opposed to the first, the two points make a pair: those of a wall, and, as far as the hand
opens, those of what is hollow behind it, as the two sides of a mug. All of it happens in the object's own frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.grasping.grasps import Array, Indices
from taskgist.settings import Grasp
from taskgist.world import Stage, inner_points

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
