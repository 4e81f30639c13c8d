"""Confirmation: facts that must last before they count.

A raw fact flickers: a tracked hand trembles at the edge of a contact, an object wobbles when it is put down. A
``Confirmation`` takes one raw value per frame, as they come, and lets a change count only after the new value has
lasted for a minimum duration. The change is then backdated to its onset. Until that moment the new value is
*provisional*: the old one still stands.

Example, with a minimum of 0.2 s and frames every 0.1 s::

    raw        A A A B A A A B B B B
    confirmed  A A A A A A A B B B B      the lone B never counted, the last B counts from its first frame on

Live and offline are the same code fed the same frames, so what was confirmed live stands offline.

Only the key of a value must last. What else belongs to it, such as the support that an object rests on, is not
confirmed: it is told as of the last frame that had the key.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Generic, TypeVar

V = TypeVar("V", bound=Hashable)
ROUNDING_S = 1e-9


def lasts(onset_s: float, time_s: float, minimum_s: float) -> bool:
    """Whether a value has lasted long enough to be confirmed."""
    return time_s - onset_s >= minimum_s - ROUNDING_S


@dataclass(frozen=True)
class Interval(Generic[V]):
    """A value that holds from ``start_s`` until ``end_s``, in seconds; the last one's end is the last frame seen."""

    value: V
    start_s: float
    end_s: float


class Confirmation(Generic[V]):
    """Confirms the values of one fact over time.

    Args:
        minimum_s: How long a value must last to be confirmed, in seconds.
        key: What of a value must last.
    """

    def __init__(self, minimum_s: float, key: Callable[[V], Hashable] = lambda value: value) -> None:
        self._minimum_s = minimum_s
        self._key = key
        self._onsets: list[float] = []
        self._values: list[V] = []
        self._run: tuple[V, float] | None = None
        self._changes_s: list[float] = []
        self._changes: list[V] = []
        self._now_s = 0.0

    def update(self, time_s: float, value: V) -> None:
        """Take the raw value of the next frame."""
        if self._run is None or not self._same(self._run[0], value):
            self._run = (value, time_s)
        if not self._changes or self._changes[-1] != value:
            self._changes_s.append(time_s)
            self._changes.append(value)
        self._now_s = time_s
        first, onset = self._run
        if lasts(onset, time_s, self._minimum_s) and not (self._values and self._same(self._values[-1], first)):
            self._onsets.append(onset)
            self._values.append(first)

    def _same(self, one: V, other: V) -> bool:
        return self._key(one) == self._key(other)

    @property
    def provisional(self) -> V | None:
        """The raw value of the last frame, where it is not confirmed (yet)."""
        if self._run is None or (self._values and self._same(self._values[-1], self._run[0])):
            return None
        return self._run[0]

    @property
    def intervals(self) -> tuple[Interval[V], ...]:
        """The confirmed values in order, each as it was at its onset; it ends where the next begins."""
        ends = [*self._onsets[1:], self._now_s][: len(self._onsets)]
        return tuple(
            Interval(value, start, end) for value, start, end in zip(self._values, self._onsets, ends, strict=True)
        )

    def at(self, time_s: float) -> V | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""
        index = bisect.bisect_right(self._onsets, time_s + ROUNDING_S) - 1
        if index < 0:
            return None
        latest = bisect.bisect_right(self._changes_s, time_s + ROUNDING_S)
        back = (self._changes[change] for change in range(latest - 1, -1, -1))
        return next(raw for raw in back if self._same(raw, self._values[index]))
