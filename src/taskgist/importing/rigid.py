"""Points that keep their distances: where some are lost for a moment, and how all are turned, the others say.

A skull is rigid. Bare keypoints come and go one by one: without this, a lost ear would leave the face without a
direction, and the person without sight, although nose, eyes and the other ear are there. So is a thing with markers on
it: three of them that are not in a line fix its pose.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.errors import MappingError
from taskgist.importing.table_values import Track
from taskgist.world.geometry.transforms import wxyz_from_matrix

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
    known: Mask = np.isfinite(group.sum(axis=2))
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
        template = np.mean(_moved(frames, frames, template), axis=0)
    return np.asarray(template)


def _moved(points: Array, start: Array, end: Array) -> Array:
    """Points (m, 3) moved as the rigid motion that takes ``start`` (k, 3) closest to ``end``.

    Of n motions at once, where they are (n, m, 3) and (n, k, 3).
    """
    start_middle, end_middle = start.mean(axis=-2, keepdims=True), end.mean(axis=-2, keepdims=True)
    return np.asarray((points - start_middle) @ _turned(start - start_middle, end - end_middle) + end_middle)


def _turned(start: Array, end: Array) -> Array:
    """The turn that takes points about the origin closest to others, on their right, (3, 3) [Kabsch 1976]."""
    left, _, right = np.linalg.svd(np.swapaxes(start, -2, -1) @ end)
    left[..., 2] *= np.sign(np.linalg.det(left @ right))[..., None]  # a turn, no mirror
    return np.asarray(left @ right)


def _width_m(points: Array) -> float:
    """How far points reach to the sides of the line that fits them best (root of the sum of squares)."""
    return float(np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1])


def body_of_markers(markers: Sequence[Track], where: str, field: str) -> Track:
    """A thing by the markers on it: its origin is in their middle, its axes are the room's where all are first seen.

    Args:
        markers: Samples of each.
        where: The mapping, for messages.
        field: The thing's, for messages.

    Raises:
        MappingError: The markers were not sampled together, are never all seen at once, or lie in a line.
    """
    times_s = markers[0].times_s
    if any(len(each.times_s) != len(times_s) or (each.times_s != times_s).any() for each in markers):
        hint = "take them from one source, which has all of them in each row"
        raise MappingError("its markers were not sampled together", where=where, field=field, hint=hint)
    group = np.stack([each.position_m for each in markers], axis=1)
    known: Mask = np.isfinite(group.sum(axis=2))
    whole = known.all(axis=1)
    if not whole.any():
        hint = "leave out the markers that are seldom seen"
        raise MappingError("its markers are never all seen at once", where=where, field=field, hint=hint)
    template = _template(group[whole])
    if _width_m(template) < LEAST_WIDTH_M:
        hint = "name three that are not, or give one of them as its point"
        raise MappingError("its markers lie in a line", where=where, field=field, hint=hint)
    position_m, wxyz = np.full((len(group), 3), np.nan), np.full((len(group), 4), np.nan)
    for seen in np.unique(known, axis=0):
        rows = np.flatnonzero((known == seen).all(axis=1))
        if seen.sum() >= LEAST_POINTS and _width_m(template[seen]) > LEAST_WIDTH_M:
            position_m[rows], wxyz[rows] = _poses(template, seen, group[rows])
    return Track(times_s, position_m, wxyz, np.ones(3), markers[0].where)


def _poses(template: Array, seen: Mask, group: Array) -> tuple[Array, Array]:
    """Where the middle of a template is, (n, 3), and how it is turned, (n, 4), by those of its points that are seen."""
    start, end = template[seen], group[:, seen]
    middle = end.mean(axis=1, keepdims=True)
    turned = _turned(np.broadcast_to(start - start.mean(axis=0), end.shape), end - middle)
    offset = (template.mean(axis=0) - start.mean(axis=0)) @ turned
    return middle[:, 0] + offset, wxyz_from_matrix(np.swapaxes(turned, 1, 2))
