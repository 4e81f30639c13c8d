"""Pairs of opposite points of an object's surface, between which a hand could close (5.1.3).

From each of many points of the surface, a ray goes through the object along the inward normal, to where it leaves it.
The two points make a pair if their faces are opposed. All of it happens in the object's own frame.
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


def opposite_points(bench: Stage, name: str, settings: Grasp) -> Pairs:
    """Distinct pairs of opposite points of an object.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
        settings: How densely to sample, and how opposed the faces must be.
    """
    shapes = bench.scene.seen_geoms(name)
    points, normals, of_shape = _surface(bench, shapes, settings.cell_m)
    starts = points - INSIDE_M * normals
    exits, through_m, outward = bench.cast_each(shapes, starts, -normals)
    opposed = (exits >= 0) & (np.einsum("ij,ij->i", outward, -normals) >= math.cos(settings.opposed_rad))
    back_m = np.full(len(starts), np.inf)
    for shape in np.unique(of_shape):
        rows = opposed & (of_shape == shape)
        back_m[rows] = bench.cast_each([shape], starts[rows], normals[rows])[1]
    found = np.isfinite(back_m)
    through_m, back_m = np.where(found, through_m, 0.0), np.where(found, back_m, 0.0)
    pairs = Pairs(
        centers=starts + normals * ((back_m - through_m) / 2)[:, None],
        closings=-normals,
        widths_m=through_m + back_m,
        shapes=np.stack((of_shape, exits), axis=1),
    ).take(found)
    return pairs.take(_distinct(_keys(pairs)))


def _surface(bench: Stage, shapes: Indices, spacing_m: float) -> tuple[Array, Array, Indices]:
    """Points and outward normals of shapes, and the shape of each; a fine mesh is thinned."""
    points, normals, of_shape = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, dtype=np.intp)]
    for shape in shapes:
        inner, outward = inner_points(bench.scene.model, int(shape), spacing_m)
        if not len(inner):
            continue
        cell_m = spacing_m / THINNING
        kept = _distinct(np.concatenate((np.round(inner / cell_m), np.round(2 * outward)), axis=1))
        pose = bench.geom(int(shape))
        points.append(pose.to_world(inner[kept]))
        normals.append(outward[kept] @ pose.matrix.T)
        of_shape.append(np.full(len(kept), shape))
    return np.concatenate(points), np.concatenate(normals), np.concatenate(of_shape)


def _keys(pairs: Pairs) -> Array:
    """Centres and undirected closing lines, (n, 6): thumb and fingers may change places."""
    closing = np.round(pairs.closings, 4)
    leading = np.argmax(closing != 0.0, axis=1)
    signs = np.sign(closing[np.arange(len(closing)), leading])
    return np.concatenate((np.round(pairs.centers / SAME_M), closing * signs[:, None]), axis=1)


def _distinct(keys: Array) -> Indices:
    """Indices of the first row of each kind, in order."""
    return np.sort(np.unique(keys + 0.0, axis=0, return_index=True)[1])
