"""Times of the rows of a table."""

from __future__ import annotations

import numpy as np

from taskgist.errors import MappingError
from taskgist.recording.mapping.source_model import Clock
from taskgist.recording.rotations import Array
from taskgist.recording.tables.part import Part

_FASTEST_S, _SLOWEST_S = 1e-4, 10.0  # between frames; beyond these, the unit of time is wrong


def read_times(part: Part, clock: Clock, length: int) -> Array:
    """Times of the rows of one point, (n,), strictly increasing.

    Args:
        part: The rows.
        clock: Where their times come from.
        length: Number of rows.

    Raises:
        MappingError: Times run backwards, repeat or are missing, or their unit cannot be right.
    """
    if clock.column is None:
        assert clock.rate_hz is not None
        return np.arange(length) / clock.rate_hz + clock.offset_s
    times_s = part.numbers((clock.column,))[:, 0] * clock.unit_s
    if len(times_s) != length:
        problem = f"there are {length} positions, but {len(times_s)} times"
        raise MappingError(problem, where=part.where, field=f"time: {clock.column}", hint="check array and layout")
    _check(part, clock, times_s)
    return np.asarray(times_s + clock.offset_s)


def _check(part: Part, clock: Clock, times_s: Array) -> None:
    field = f"time: {clock.column}"
    steps_s = np.diff(times_s)
    wrong = ~(steps_s > 0.0)  # NaN included
    if wrong.any():
        row = int(np.argmax(wrong)) + 1
        before, after = times_s[row - 1], times_s[row]
        problem = "times run backwards" if after < before else "times repeat or are missing"
        raise MappingError(
            f"{problem}: {before:.9g} s, then {after:.9g} s",
            where=f"{part.where}, {part.place(row)}",
            field=field,
            hint="sort the rows and drop repeated ones; rows of several bodies are told apart by where",
        )
    if len(steps_s) and not _FASTEST_S <= np.median(steps_s) <= _SLOWEST_S:
        problem = f"frames are {np.median(steps_s):.3g} s apart"
        hint = "change time.unit (known: s, ms, us, ns)"
        raise MappingError(problem, where=part.where, field=field, value=f"unit of {clock.unit_s:g} s", hint=hint)
