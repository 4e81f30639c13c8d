"""Against jitter: each sample gives way to a straight line through its neighbours.

The line is fitted to the samples within half a window on either side, those nearby weighing most, and read where the
sample was. So steady motion stays as it is, also at the ends, and what shakes about it goes. Samples on the other side
of a gap have no say.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.recording.tables.track import Array, Track


def smoothed(track: Track, window_s: float, *, max_gap_s: float) -> Track:
    """The track with local lines in place of its positions and orientations.

    Args:
        track: Samples.
        window_s: Length of the window in seconds; 0 leaves the track as it is.
        max_gap_s: Longest time between two samples that still belong together.
    """
    if window_s <= 0.0 or len(track.times_s) < 3:
        return track
    position_m = _lines(track.times_s, track.position_m, window_s / 2, max_gap_s)
    if track.wxyz is None:
        return replace(track, position_m=position_m)
    wxyz = _lines(track.times_s, track.wxyz, window_s / 2, max_gap_s, either_sign=True)
    return replace(track, position_m=position_m, wxyz=wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True))


def _lines(times_s: Array, values: Array, half_s: float, max_gap_s: float, *, either_sign: bool = False) -> Array:
    """Local lines through those rows that are known, (n, k)."""
    known = np.isfinite(values).all(axis=1)
    result = values.copy()
    if not known.any():
        return result
    times_s, values = times_s[known], values[known]
    near, weights, apart_s = _neighbours(times_s, half_s, max_gap_s)
    around = values[near]
    if either_sign:  # a quaternion and its opposite are the same orientation
        cosines = np.einsum("nmk,nk->nm", around, values)
        around = around * np.where(cosines < 0.0, -1.0, 1.0)[:, :, None]
    result[known] = _line_at_zero(apart_s, weights, around)
    return result


def _neighbours(times_s: Array, half_s: float, max_gap_s: float) -> tuple[NDArray[np.intp], Array, Array]:
    """Indices of each sample's neighbours, their weights (tricube) and how much later they are, (n, m) each."""
    reach = int(np.max(np.searchsorted(times_s, times_s + half_s) - np.arange(len(times_s))))
    offsets = np.arange(-reach, reach + 1)
    wanted = np.arange(len(times_s))[:, None] + offsets
    near = wanted.clip(0, len(times_s) - 1)
    apart_s = times_s[near] - times_s[:, None]
    stretch = np.concatenate([[0], np.cumsum(np.diff(times_s) > max_gap_s)])
    together = (near == wanted) & (stretch[near] == stretch[:, None])
    weights = np.where(together, (1.0 - np.minimum(np.abs(apart_s) / half_s, 1.0) ** 3) ** 3, 0.0)
    return near, weights, apart_s


def _line_at_zero(x: Array, weights: Array, y: Array) -> Array:
    """Value at x = 0 of the weighted least-squares line through the points of each row, (n, k)."""
    total, first, second = weights.sum(axis=1), (weights * x).sum(axis=1), (weights * x * x).sum(axis=1)
    heights, moments = np.einsum("nm,nmk->nk", weights, y), np.einsum("nm,nmk->nk", weights * x, y)
    spread = total * second - first**2
    sloped = spread > 1e-9 * total * second.max(initial=1e-12)
    line = (second[:, None] * heights - first[:, None] * moments) / np.where(sloped, spread, 1.0)[:, None]
    return np.asarray(np.where(sloped[:, None], line, heights / total[:, None]))
