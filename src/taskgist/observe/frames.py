"""Frames in order of time, and what lasts in them: windows, speeds, hysteresis, confirmation.

A raw fact of one frame flickers: a tracked hand trembles at the edge of a contact, an object wobbles when it is put
down. Three things make it a fact that can be relied on. Speeds are measured within a *window* around a frame. Between
two thresholds *hysteresis* lets all stay as it was. And a value counts only when it has lasted for a minimum duration;
then it is *confirmed*, from its onset on. Until then it is provisional, and the old one still stands. An example, with
a minimum of 0.2 s and frames every 0.1 s::

    raw        A A A B A A A B B B B
    confirmed  A A A A A A A B B B B      the lone B never counted, the last B counts from its first frame on

Nobody asks for the raw values of all frames. An explanation asks for two times of a recording, so each value is looked
up where it is asked for, in the frames that it hangs on, and kept for a while::

    raw        A A A B A A A B B B B
                     ^                    this B does not last, the A before it does: 5 frames were looked at
                             ^            this B lasts: 4 frames were looked at

Live input appends frames. A frame is *settled* once its windows are complete, and only settled frames are looked at:
what was confirmed live therefore stands when the whole recording is asked.
"""

from __future__ import annotations

import bisect
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.errors import RecordingError
from taskgist.world.state import Frames, State

ROUNDING_S = 1e-6
"""Unix times have no finer: what is said of them must not hang on when it was."""
KEPT_STATES = 128
"""As many states at hand as the windows around a frame hold, of the fastest trackers."""
KEPT_FRAMES = 4096
"""Of as many frames what was found is kept, some 6 kB each; what is asked again later is looked up again."""


class FrameSequence:
    """States of one scene in order of time: a whole recording, or as many as have come so far.

    Args:
        window_s: Width of the widest window that will be asked for, in seconds.
        frames: The whole sequence; where it is left out, frames are appended one by one.

    Attributes:
        times_s: Times of the frames in seconds.
        state: Gives the state in a frame, by its index.
        settled: How many frames, from the first one on, have complete windows: all, if no more will come.
        whole: Whether all frames were there from the beginning.
    """

    def __init__(self, window_s: float, frames: Frames | None = None) -> None:
        self._window_s = window_s
        self._appended: list[State] = []
        self.whole = self._complete = frames is not None
        self.times_s: list[float] = [] if frames is None else frames.times_s.tolist()
        self.state: Callable[[int], State] = (
            self._appended.__getitem__ if frames is None else lru_cache(KEPT_STATES)(frames.state)
        )
        self.settled = len(self.times_s)

    def append(self, state: State) -> None:
        """Take the next frame.

        Raises:
            RecordingError: It is not later than the last one, or no more frames were to come.
        """
        if self._complete:
            raise RecordingError("no more frames were to come", hint="make another observer for other frames")
        if self.times_s and state.time_s <= self.times_s[-1]:
            hint = f"append frames in order of time; the last was at {self.times_s[-1]:g} s"
            raise RecordingError("times run backwards", field="time_s", value=state.time_s, hint=hint)
        self._appended.append(state)
        self.times_s.append(state.time_s)
        while self.settled < len(self.times_s) - 1 and self._is_late(-1, self.settled, self._window_s):
            self.settled += 1

    def finish(self) -> None:
        """Say that no more frames will come."""
        self._complete = True
        self.settled = len(self.times_s)

    def index_at(self, time_s: float) -> int:
        """The last settled frame that is not later than a time; -1 if there is none."""
        return bisect.bisect_right(self.times_s, time_s + ROUNDING_S, hi=self.settled) - 1

    def window(self, index: int, width_s: float) -> range:
        """The frames within half a width before and behind a frame, and in any case its neighbours.

        So slow trackers (5 Hz) are served, too. The first frame that is half a width late completes the window.
        """
        now_s, within_s, end = self.times_s[index], width_s / 2 + ROUNDING_S, len(self.times_s) - 1
        first, last = max(index - 1, 0), min(index + 1, end)
        while first > 0 and now_s - self.times_s[first - 1] <= within_s:
            first -= 1
        while last < end and not self._is_late(last, index, width_s) and self.times_s[last + 1] - now_s <= within_s:
            last += 1
        return range(first, last + 1)

    def _is_late(self, later: int, index: int, width_s: float) -> bool:
        return self.times_s[later] - self.times_s[index] >= width_s / 2 - ROUNDING_S


def velocity(times_s: Sequence[float], places: ArrayLike) -> Array | None:
    """Velocity of a straight line fitted to places: per second, (…); None for a single time.

    Args:
        times_s: Times in seconds, (n,).
        places: What is where at each of them, or turned how, (n, …).
    """
    since_s = np.asarray(times_s) - times_s[0]
    moments = since_s - since_s.mean()
    spread = float(moments @ moments)
    return None if spread <= 0.0 else np.asarray(np.tensordot(moments, np.asarray(places), axes=1) / spread)


def speed_m_s(times_s: Sequence[float], places: Sequence[Array]) -> float | None:
    """Speed of a straight line fitted to places (3,) in metres; None for a single time."""
    fitted = velocity(times_s, places)
    return None if fitted is None else float(np.linalg.norm(fitted))


class Hysteresis:
    """A condition of frames that may go on because it held in the frame before.

    One frame out of a long sequence is answered by going back to the nearest frame whose answer is the same whatever
    came before it, and following the frames from there.

    Args:
        holds: Says whether the condition holds in a frame, by its index and whether it held in the frame before. Before
            the first frame it did not.
    """

    def __init__(self, holds: Callable[[int, bool], bool]) -> None:
        self._holds = holds
        self._found: dict[int, bool] = {}

    def at(self, index: int) -> bool:
        """Whether it holds in a frame."""
        start = index
        while start > 0 and start not in self._found and self._holds(start, True) != self._holds(start, False):
            start -= 1
        held = False
        for each in range(start, index + 1):
            held = self._found[each] if each in self._found else self._keep(each, self._holds(each, held))
        return held

    def _keep(self, index: int, held: bool) -> bool:
        if len(self._found) >= KEPT_FRAMES:
            del self._found[next(iter(self._found))]
        self._found[index] = held
        return held


V = TypeVar("V", bound=Hashable)


@dataclass(frozen=True)
class Interval(Generic[V]):
    """A value that holds from ``start_s`` until ``end_s``, in seconds; the last one ends with the last frame."""

    value: V
    start_s: float
    end_s: float


class Confirmed(Generic[V]):
    """The confirmed values of one fact over a sequence of frames.

    Only the key of a value must last. What else belongs to it, such as the support that an object rests on, is told as
    of the last frame that had the key.

    Args:
        frames: The frames; more may be appended.
        raw: Gives the raw value of a settled frame, by its index.
        minimum_s: How long a value must last to be confirmed, in seconds.
        key: What of a value must last.
        together: Facts that look at the same things in a frame: their intervals are found together.
    """

    def __init__(
        self,
        frames: FrameSequence,
        raw: Callable[[int], V],
        minimum_s: float,
        key: Callable[[V], Hashable] = lambda value: value,
        together: list[Confirmed[V]] | None = None,
    ) -> None:
        self._frames, self._minimum_s = frames, minimum_s
        self._raw, self._key_of = lru_cache(KEPT_FRAMES)(raw), key
        self._key = lru_cache(KEPT_FRAMES)(lambda index: key(self._raw(index)))
        # Onsets of the confirmed values, in the frames that were followed so far, and where their last run began:
        self._onsets: list[tuple[int, V]] = []
        self._followed = self._run = 0
        self._lasting = (0, -2)  # first and last frame known of the run that lasted and was asked for last
        self._together = [] if together is None else together
        self._together.append(self)

    def at(self, time_s: float) -> V | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""
        here = self._frames.index_at(time_s)
        deciding = self._deciding(here)
        if deciding is None:
            return None
        if deciding == here:
            return self._raw(here)
        return next(self._raw(index) for index in range(here, -1, -1) if self._key(index) == self._key(deciding))

    @property
    def provisional(self) -> V | None:
        """The raw value of the last settled frame, where it is not confirmed (yet)."""
        last = self._frames.settled - 1
        deciding = self._deciding(last)
        if last < 0 or (deciding is not None and self._key(deciding) == self._key(last)):
            return None
        return self._raw(last)

    @property
    def intervals(self) -> tuple[Interval[V], ...]:
        """The confirmed values in order, each as it was at its onset; it ends where the next begins."""
        for end in (*range(self._followed, self._frames.settled, KEPT_FRAMES // 2), self._frames.settled):
            for each in self._together:
                each._follow(end)
        times_s = self._frames.times_s
        return _spans(
            [(times_s[onset], value) for onset, value in self._onsets],
            times_s[self._followed - 1] if self._followed else 0.0,
        )

    def _follow(self, end: int) -> None:
        """Find the onsets in the frames before this one."""
        for index in range(self._followed, end):
            if self._key(index) != self._key(self._run):
                self._run = index
            is_news = not self._onsets or self._key_of(self._onsets[-1][1]) != self._key(index)
            if is_news and self._lasts(self._run, index):
                self._onsets.append((self._run, self._raw(self._run)))
        self._followed = max(self._followed, end)

    def _deciding(self, here: int) -> int | None:
        """A frame of the run that is confirmed as of one frame: its own run, or the last before that lasted."""
        last = here
        while last >= 0:
            first, known = self._lasting
            if first <= last <= known:
                return last
            if last == known + 1 and self._key(last) == self._key(known):
                self._lasting = first, last  # frames asked for one after the other: the run goes on
                return last
            first = self._beginning(last)
            if self._lasts(first, self._ending(first, last)):
                self._lasting = first, last
                return last
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
        end = self._frames.settled - 1
        while last < end and not self._lasts(first, last) and self._key(last + 1) == self._key(first):
            last += 1
        return last

    def _lasts(self, first: int, last: int) -> bool:
        return self._frames.times_s[last] - self._frames.times_s[first] >= self._minimum_s - ROUNDING_S


class Refined(Generic[V]):
    """Confirmed values whose kind counts as soon as it has lasted, and their particulars once these have lasted, too.

    A thing that passes from hand to hand is held all the time; whose hand it is changes. Particulars that do not last
    long enough are told as of the last frame of that kind.

    Args:
        frames: The frames; more may be appended.
        raw: Gives the raw value of a settled frame, by its index.
        minimum_s: How long each must last to be confirmed, in seconds.
        kind: What of a value must last first.
        together: Facts that look at the same things in a frame: their intervals are found together.
    """

    def __init__(
        self,
        frames: FrameSequence,
        raw: Callable[[int], V],
        minimum_s: float,
        kind: Callable[[V], Hashable],
        together: list[Confirmed[V]] | None = None,
    ) -> None:
        self._frames, self._kind_of = frames, kind
        remembered = lru_cache(KEPT_FRAMES)(raw)
        self._kind = Confirmed(frames, remembered, minimum_s, kind, together)
        self._whole = Confirmed(frames, remembered, minimum_s, together=together)

    def at(self, time_s: float) -> V | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""
        kind, whole = self._kind.at(time_s), self._whole.at(time_s)
        if kind is None or whole is None:
            return kind
        return whole if self._kind_of(whole) == self._kind_of(kind) else kind

    @property
    def intervals(self) -> tuple[Interval[V], ...]:
        """The confirmed values in order, each as it was at its onset; it ends where the next begins."""
        kinds, wholes = self._kind.intervals, self._whole.intervals
        spans, found = (*kinds, *wholes), list[tuple[float, V]]()
        for start_s in sorted({span.start_s for span in spans}):
            kind, whole = _covering(kinds, start_s), _covering(wholes, start_s)
            if kind and whole and self._kind_of(whole.value) == self._kind_of(kind.value):
                value: V | None = whole.value  # as ``at`` says; a long recording is not looked at again for it
            else:
                value = self.at(start_s)
            if value is not None and (not found or found[-1][1] != value):
                found.append((start_s, value))
        return _spans(found, max((span.end_s for span in spans), default=0.0))


def _covering(intervals: Sequence[Interval[V]], time_s: float) -> Interval[V] | None:
    """The last interval that begins no later than a time; they are in order."""
    number = bisect.bisect_right(intervals, time_s, key=lambda interval: interval.start_s)
    return intervals[number - 1] if number else None


def _spans(onsets: Sequence[tuple[float, V]], end_s: float) -> tuple[Interval[V], ...]:
    """Intervals of values by the times from which on they hold, in order; the last one ends at a time."""
    times_s = pairwise([*(start_s for start_s, _ in onsets), end_s])
    return tuple(Interval(value, *span) for (_, value), span in zip(onsets, times_s, strict=True))
