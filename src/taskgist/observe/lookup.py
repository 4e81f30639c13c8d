"""Lookup: the confirmed value of a fact at one time, found from the frames around it.

A ``Confirmation`` takes all frames as they come. Who asks for one time of a whole sequence needs few of them: the run
of equal raw values around that frame, as far as it takes to see that it lasts. Where it does not last, the run before
it decides, and so on.

Example, with a minimum of 0.2 s and frames every 0.1 s; asked for the frame under the caret::

    raw    A A A B A A A B B B B
                 ^                  this B does not last, the A before it does: 5 frames were looked at
                         ^          this B lasts: 4 frames were looked at
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Hashable, Sequence
from functools import cache
from typing import Generic, TypeVar

from taskgist.observe.confirmation import ROUNDING_S, lasts

V = TypeVar("V", bound=Hashable)


class Lookup(Generic[V]):
    """Looks up confirmed values, the same as a ``Confirmation`` has that was fed all frames.

    Args:
        times_s: Times of all frames in seconds, strictly increasing.
        raw: Gives the raw value of a frame, by its index.
        minimum_s: How long a value must last to be confirmed, in seconds.
        key: What of a value must last.
    """

    def __init__(
        self,
        times_s: Sequence[float],
        raw: Callable[[int], V],
        minimum_s: float,
        key: Callable[[V], Hashable] = lambda value: value,
    ) -> None:
        self._times_s, self._minimum_s = times_s, minimum_s
        self._raw = cache(raw)
        self._key = cache(lambda index: key(self._raw(index)))

    def at(self, time_s: float) -> V | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""
        here = bisect.bisect_right(self._times_s, time_s + ROUNDING_S) - 1
        last = here
        while last >= 0:
            first = self._beginning(last)
            if self._lasts(first, self._ending(first, last) if last == here else last):
                return next(self._raw(index) for index in range(here, -1, -1) if self._key(index) == self._key(last))
            last = first - 1
        return None

    def _beginning(self, last: int) -> int:
        """Where the run that a frame belongs to begins, or where it has lasted long enough by that frame."""
        first = last
        while first > 0 and not self._lasts(first, last) and self._key(first - 1) == self._key(last):
            first -= 1
        return first

    def _ending(self, first: int, last: int) -> int:
        """Where that run ends, or where it has lasted long enough."""
        while (
            last + 1 < len(self._times_s) and not self._lasts(first, last) and self._key(last + 1) == self._key(first)
        ):
            last += 1
        return last

    def _lasts(self, first: int, last: int) -> bool:
        return lasts(self._times_s[first], self._times_s[last], self._minimum_s)
