"""What rows of numbers mean, whatever file they stand in: parts, times, orientations, names, tracks, smoothing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing.mapping import Clock, Columns, Name, Rotation, Source
from taskgist.world.geometry.transforms import matrix_from_euler, wxyz_from_matrix, wxyz_from_rotation_vector

# --- Orientations in the notations of different trackers, brought to quaternions.

_TOLERANCE = 0.05  # quaternions with two decimals must pass, wrong columns must not


def wxyz_from_numbers(numbers: Array, rotation: Rotation) -> tuple[Array, Mask]:
    """Unit quaternions in the source's axes, and which rows hold no rotation.

    Args:
        numbers: As they stand in the table, (n, 3, 4 or 9), by row; NaN where unknown.
        rotation: Their notation.

    Returns:
        Quaternions, (n, 4), NaN where unknown or bad; bad rows, (n,).
    """
    wxyz = np.full((len(numbers), 4), np.nan)
    bad = np.zeros(len(numbers), dtype=np.bool_)
    known = np.isfinite(numbers).all(axis=1)
    if rotation.kind == "matrix":
        wxyz[known], bad[known] = _from_matrices(numbers[known].reshape(-1, 3, 3))
    elif rotation.kind in ("xyzw", "wxyz"):
        wxyz[known], bad[known] = _from_quaternions(numbers[known], rotation.kind)
    elif rotation.kind == "rotation_vector":
        wxyz[known] = wxyz_from_rotation_vector(numbers[known] * rotation.unit_rad)
    else:
        intrinsic = rotation.kind == "euler_intrinsic"
        angles_rad = numbers[known] * rotation.unit_rad
        wxyz[known] = wxyz_from_matrix(matrix_from_euler(angles_rad, rotation.order, intrinsic=intrinsic))
    return wxyz, bad


def _from_quaternions(numbers: Array, kind: str) -> tuple[Array, Mask]:
    wxyz = np.roll(numbers, 1, axis=1) if kind == "xyzw" else numbers
    length = np.linalg.norm(wxyz, axis=1, keepdims=True)
    bad = np.abs(length[:, 0] - 1.0) > _TOLERANCE
    return wxyz / np.where(bad[:, None], np.nan, length), bad


def _from_matrices(matrices: Array) -> tuple[Array, Mask]:
    departure = np.abs(matrices @ np.swapaxes(matrices, -1, -2) - np.eye(3)).max(axis=(-1, -2), initial=0.0)
    bad = (departure > _TOLERANCE) | (np.linalg.det(matrices) < 0.0)
    wxyz = np.full((len(matrices), 4), np.nan)
    wxyz[~bad] = wxyz_from_matrix(matrices[~bad])
    return wxyz, bad


# --- What text and arrays have in common: the part of a table that belongs to one point.


class Part(Protocol):
    """Rows of one point, whatever they are stored in."""

    @property
    def where(self) -> str:
        """Mapping, source and file, for messages."""

    @property
    def oriented(self) -> bool:
        """Whether the point has orientations, where its source has."""

    def numbers(self, columns: Sequence[Name]) -> Array:
        """Numbers in these columns, (rows, columns); NaN where there are none."""

    def place(self, row: int) -> str:
        """Where a row stands, for messages."""


# --- Times of the rows of a table.

_FASTEST_S, _SLOWEST_S = 1e-4, 10.0  # between frames; beyond these, the unit of time is wrong


def read_times(part: Part, clock: Clock, length: int) -> tuple[Array, Mask]:
    """Times of the rows of one point that count, (k,), strictly increasing; and which rows these are, (n,).

    Args:
        part: The rows.
        clock: Where their times come from, and which of several rows with the same time counts.
        length: Number of rows.

    Raises:
        MappingError: Times run backwards, repeat or are missing, or their unit cannot be right.
    """
    kept = np.ones(length, dtype=np.bool_)
    if clock.column is None:
        assert clock.rate_hz is not None
        return np.arange(length) / clock.rate_hz + clock.offset_s, kept
    times_s = part.numbers((clock.column,))[:, 0] * clock.unit_s
    if len(times_s) != length:
        problem = f"there are {length} positions, but {len(times_s)} times"
        raise MappingError(problem, where=part.where, field=f"time: {clock.column}", hint="check array and layout")
    if clock.repeated == "first":
        kept[1:] = np.diff(times_s) != 0.0
    elif clock.repeated == "last":
        kept[:-1] = np.diff(times_s) != 0.0
    _check(part, clock, times_s, kept)
    return np.asarray(times_s[kept] + clock.offset_s), kept


def _check(part: Part, clock: Clock, times_s: Array, kept: Mask) -> None:
    field = f"time: {clock.column}"
    rows = np.flatnonzero(kept)
    steps_s = np.diff(times_s[rows])
    wrong = ~(steps_s > 0.0)  # NaN included
    if wrong.any():
        at = int(np.argmax(wrong))
        before, after = times_s[rows[at]], times_s[rows[at + 1]]
        problem = "times run backwards" if after < before else "times repeat or are missing"
        keep = (
            'time.repeated = "first" (or "last") keeps one of those that repeat' if after == before else "sort the rows"
        )
        raise MappingError(
            f"{problem}: {before:.9g} s, then {after:.9g} s",
            where=f"{part.where}, {part.place(int(rows[at + 1]))}",
            field=field,
            hint=f"{keep}; rows of several bodies are told apart by where",
        )
    if len(steps_s) and not _FASTEST_S <= np.median(steps_s) <= _SLOWEST_S:
        problem = f"frames are {np.median(steps_s):.3g} s apart"
        hint = "change time.unit (known: s, ms, us, ns)"
        raise MappingError(problem, where=part.where, field=field, value=f"unit of {clock.unit_s:g} s", hint=hint)


# --- The placeholders ``{person}`` and ``{point}``, filled for one point.


@dataclass(frozen=True)
class Tokens:
    """What the placeholders of a source stand for.

    Attributes:
        source: The source.
        person: What ``{person}`` stands for.
        point: What ``{point}`` stands for.
        where: Mapping and source, for messages.
    """

    source: Source
    person: Name
    point: Name
    where: str

    def filled(self, template: str) -> str:
        """A text with its placeholders filled."""
        return template.replace("{person}", str(self.person)).replace("{point}", self._point_name())

    def columns(self, columns: Columns) -> tuple[Name, ...]:
        """The columns of this point."""
        shift = columns.step * self.index_of("{point}") if columns.step else 0
        return tuple(self.filled(item) if isinstance(item, str) else item + shift for item in columns.items)

    def index_of(self, placeholder: str) -> int:
        """The index that "{person}" or "{point}" stands for.

        Raises:
            MappingError: A person is given by name; names have no index.
            UnknownNameError: The source does not list such a point.
        """
        token = self.person if placeholder == "{person}" else self.point
        if isinstance(token, int):
            return token
        if placeholder == "{person}":
            hint = "give person = 0, 1, ... of the array's axis"
            raise MappingError("must be an index here", where=self.where, field="person", value=token, hint=hint)
        if token not in self.source.names:
            raise UnknownNameError("point in names", token, self.source.names, where=self.where)
        return self.source.names.index(token)

    def _point_name(self) -> str:
        names = self.source.names
        known = isinstance(self.point, int) and self.point < len(names)
        return names[int(self.point)] if known else str(self.point)


# --- One tracked point or body over time, as its source sampled it.


@dataclass(frozen=True, eq=False)
class Track:
    """Samples of one point, in the room's axes and metres.

    Attributes:
        times_s: Times of the samples in the time of the sources, (n,), strictly increasing.
        position_m: Positions, (n, 3); NaN where the tracker lost the point.
        wxyz: Orientations, (n, 4), or ``None`` for a bare point; NaN where lost.
        signs: What turns a vector in the source's naming of the body's own axes into the frame of ``wxyz``, (3,):
            (1, 1, 1), or (1, 1, -1) for a left-handed source.
        where: File that it comes from, for messages.
    """

    times_s: Array
    position_m: Array
    wxyz: Array | None
    signs: Array
    where: str


# --- Against jitter: each sample gives way to a straight line through its neighbours.
#
# The line is fitted to the samples within half a window on either side, those nearby weighing most, and read where the
# sample was. So steady motion stays as it is, also at the ends, and what shakes about it goes. Samples beyond a gap
# have no say.


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


def _neighbours(times_s: Array, half_s: float, max_gap_s: float) -> tuple[Indices, Array, Array]:
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


# --- Orientations that a tracker writes for what it does not see, and that nobody declared.

LARGEST_TURN_RAD = np.radians(20.0)
"""Nothing turns by more from one sample to the next, and from or to no turn at all (ours: a turn and a half in a second
at 30 samples)."""


def is_identity(wxyz: Array) -> Mask:
    """Which orientations, (n, 4), are no turn at all, to the last digit, (n,)."""
    return np.asarray((np.abs(wxyz) == (1.0, 0.0, 0.0, 0.0)).all(axis=1))


def _beside(marked: Mask) -> Mask:
    """Which samples are not marked themselves, but that before or after is, (n,)."""
    beside = np.zeros(len(marked), dtype=np.bool_)
    beside[1:] |= marked[:-1]
    beside[:-1] |= marked[1:]
    return np.asarray(beside & ~marked)


def check_identities(part: Part, tokens: Tokens, wxyz: Array) -> None:
    """Refuse a body that is not turned at all in some samples and far turned in the next, where nobody said why.

    Args:
        part: Where the numbers come from.
        tokens: Source and body.
        wxyz: Orientations in the axes of the source, (n, 4).

    Raises:
        MappingError: It jumps to no turn at all, or from there.
    """
    identity, turned = is_identity(wxyz), 2.0 * np.arccos(np.abs(wxyz[:, 0]).clip(0.0, 1.0))
    jumps_rad = turned[_beside(identity)]
    if np.any(jumps_rad > LARGEST_TURN_RAD):
        raise MappingError(
            f"is no turn at all in {int(identity.sum())} of {len(identity)} samples, and turned by "
            f"{np.degrees(np.nanmax(jumps_rad)):.0f}° in the next",
            where=f"{part.where}, {part.place(int(np.argmax(identity)))}",
            field="rotation",
            hint=f"add identity_is_lost = true to the rotation of [sources.{tokens.source.name}] if it stands for not "
            "tracked, else identity_is_lost = false",
        )


# --- Zeros that a tracker writes for what it does not see, and that nobody declared.

FARTHEST_JUMP_M = 0.3
"""Nothing gets from the origin to farther than this, or back, from one sample to the next (ours)."""


def check_zeros(part: Part, tokens: Tokens, position: Array) -> None:
    """Refuse a point that jumps to 0, 0, 0 and back, where the mapping does not say what that means.

    Args:
        part: Where the numbers come from.
        tokens: Source and point.
        position: Positions in the units of the source, (n, 3).

    Raises:
        MappingError: The point jumps there.
    """
    zero = (position == 0.0).all(axis=1)
    jumps_m = np.linalg.norm(position[_beside(zero)], axis=1) * tokens.source.frame.scale_m
    if np.any(jumps_m > FARTHEST_JUMP_M):
        raise MappingError(
            f"is 0, 0, 0 in {int(zero.sum())} of {len(zero)} samples, and far away in the next one",
            where=f"{part.where}, {part.place(int(np.argmax(zero)))}",
            field="position",
            hint=f"add missing = 0 to [sources.{tokens.source.name}] if it stands for not tracked, else missing = []",
        )
