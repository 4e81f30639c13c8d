"""A skull is rigid: where a tracker loses some of its points for a moment, the others say where they are.

Bare keypoints come and go one by one. Without this, a lost ear would leave the face without a direction, and the person
without sight, although nose, eyes and the other ear are there.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_POINTS = 3
"""Fewer do not fix a pose."""
LEAST_WIDTH_M = 0.02
"""Points that lie along a line, but for this, do not fix it either (ours)."""
LEAST_FRAMES = 5
"""Frames with all points that it takes to know how they lie to each other (ours)."""


def completed(points: Mapping[str, Array], rigid: Collection[str]) -> dict[str, Array]:
    """The points, those of a rigid group completed in frames where three or more others of it are known.

    Args:
        points: Positions by landmark, metres, (N, 3) each; NaN where unknown.
        rigid: Names of the landmarks that keep their distances; those that are not there, or never seen, are left out.
    """
    names = sorted(name for name in points if name in rigid and np.isfinite(points[name]).all(axis=1).any())
    if len(names) <= LEAST_POINTS:
        return dict(points)
    group = np.stack([points[name] for name in names], axis=1)
    known: NDArray[np.bool_] = np.isfinite(group.sum(axis=2))
    whole = known.sum(axis=1) == len(names)
    if whole.sum() < LEAST_FRAMES:
        return dict(points)
    template = _template(group[whole])
    for frame in np.flatnonzero(~whole & (known.sum(axis=1) >= LEAST_POINTS)):
        seen = known[frame]
        if _width_m(template[seen]) > LEAST_WIDTH_M:
            group[frame, ~seen] = _moved(template, template[seen], group[frame, seen])[~seen]
    return {**points, **{name: group[:, index] for index, name in enumerate(names)}}


def _template(frames: Array) -> Array:
    """How the points lie to each other: the mean of all frames, laid over the first one and then over that mean."""
    template = frames[0]
    for _ in range(2):
        template = np.mean([_moved(frame, frame, template) for frame in frames], axis=0)
    return np.asarray(template)


def _moved(points: Array, start: Array, end: Array) -> Array:
    """Points (m, 3) moved as the rigid motion that takes ``start`` (k, 3) closest to ``end`` [Kabsch 1976]."""
    start_middle, end_middle = start.mean(axis=0), end.mean(axis=0)
    left, _, right = np.linalg.svd((start - start_middle).T @ (end - end_middle))
    mirror = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    return np.asarray((points - start_middle) @ (left * mirror) @ right + end_middle)


def _width_m(points: Array) -> float:
    """How far points reach to the sides of the line that fits them best (root of the sum of squares)."""
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1])
