"""From the times at which sources sampled to the frames of a recording; and things that stay where nobody looks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.importing.table_values import Track
from taskgist.world.geometry.transforms import slerp

Mix = Callable[[Array, Array, Array], Array]


@dataclass(frozen=True, eq=False)
class Frames:
    """A track at the frames of the recording.

    Attributes:
        position_m: (N, 3); NaN where unknown.
        wxyz: (N, 4) or ``None``; NaN where unknown.
        signs: As of the track.
    """

    position_m: Array
    wxyz: Array | None
    signs: Array


def resample(track: Track, times_s: Array, *, max_gap_s: float) -> Frames:
    """Positions between samples by straight lines, orientations along great circles.

    Between two known samples more than ``max_gap_s`` apart nothing is known, and nothing before the first or after the
    last one, except within half a frame of the source around a sample.

    Args:
        track: Samples.
        times_s: Frames wanted, (N,), in the time of the sources.
        max_gap_s: Longest stretch that is interpolated over.
    """
    hold_s = _half_frame_s(track.times_s)
    known = np.isfinite(track.position_m).all(axis=1)
    spans = _spans(track.times_s[known], times_s, max_gap_s, hold_s)
    position_m = spans.mixed(track.position_m[known], _line)
    if track.wxyz is None:
        return Frames(position_m, None, track.signs)
    known &= np.isfinite(track.wxyz).all(axis=1)
    spans = _spans(track.times_s[known], times_s, max_gap_s, hold_s)
    return Frames(position_m, spans.mixed(track.wxyz[known], slerp), track.signs)


def series_at(times_s: Array, values: Array, wanted_s: Array, *, max_gap_s: float) -> Array:
    """Numbers at frames, (N,), along straight lines between samples (n,); NaN where ``resample`` leaves it unknown."""
    known = np.isfinite(values)
    spans = _spans(times_s[known], wanted_s, max_gap_s, _half_frame_s(times_s))
    return spans.mixed(values[known, None], _line)[:, 0]


def percent(frames: Mask) -> str:
    """The share of some frames, in percent, as notes tell it."""
    return f"{100 * float(np.mean(frames)):.2g}"


@dataclass(frozen=True, eq=False)
class _Spans:
    """Between which two samples each frame lies, (N,): their indices, the share of the way, whether it is known."""

    before: Indices
    after: Indices
    share: Array
    known: Mask

    def mixed(self, samples: Array, mix: Mix) -> Array:
        result = np.full((len(self.known), samples.shape[1]), np.nan)
        k = self.known
        result[k] = mix(samples[self.before[k]], samples[self.after[k]], self.share[k])
        return result


def _spans(sampled_s: Array, wanted_s: Array, max_gap_s: float, hold_s: float) -> _Spans:
    if len(sampled_s) == 0:
        nothing = np.zeros(len(wanted_s), dtype=np.intp)
        return _Spans(nothing, nothing, nothing.astype(np.float64), nothing.astype(np.bool_))
    after = np.searchsorted(sampled_s, wanted_s).clip(0, len(sampled_s) - 1)
    before = np.where(sampled_s[after] > wanted_s, after - 1, after).clip(0)
    gap_s = sampled_s[after] - sampled_s[before]
    share = np.where(gap_s > 0.0, (wanted_s - sampled_s[before]) / np.where(gap_s > 0.0, gap_s, 1.0), 0.0)
    nearest_s = np.minimum(np.abs(wanted_s - sampled_s[before]), np.abs(wanted_s - sampled_s[after]))
    held = nearest_s <= hold_s
    bridged = (gap_s > 0.0) & (gap_s <= max_gap_s)
    share = np.where(bridged, share, np.round(share))  # a sample is held, not mixed across a gap
    return _Spans(before, after, share, held | bridged)


def _half_frame_s(times_s: Array) -> float:
    return float(np.median(np.diff(times_s))) / 2 if len(times_s) > 1 else 0.0


def _line(start: Array, end: Array, share: Array) -> Array:
    return np.asarray(start + share[:, None] * (end - start))


# --- Things that are tracked only while they are handled, and stay where they were left in between.

STAYED_M = 0.05
"""A thing that is seen again within this distance of where it was last seen has stayed (ours)."""


def stayed(frames: Frames) -> tuple[Frames, Mask]:
    """Frames in which a thing stays where it was last seen, until it is seen again; at first, where it is first seen.

    Where it is next seen elsewhere, somebody moved it unseen, and it stays unknown.

    Args:
        frames: Those of the thing.

    Returns:
        The frames with what follows filled in, and which frames were filled, (N,).
    """
    parts = [frames.position_m] if frames.wxyz is None else [frames.position_m, frames.wxyz]
    pose = np.hstack(parts)
    seen = np.flatnonzero(np.isfinite(pose).all(axis=1))
    filled = np.zeros(len(pose), dtype=np.bool_)
    if not len(seen):
        return frames, filled
    pose[: seen[0]], pose[seen[-1] + 1 :] = pose[seen[0]], pose[seen[-1]]
    filled[: seen[0]], filled[seen[-1] + 1 :] = True, True
    for before, after in pairwise(seen):
        if after > before + 1 and np.linalg.norm(pose[after, :3] - pose[before, :3]) < STAYED_M:
            pose[before + 1 : after], filled[before + 1 : after] = pose[before], True
    wxyz = None if frames.wxyz is None else pose[:, 3:]
    return Frames(pose[:, :3], wxyz, frames.signs), filled
