"""A window that slides over frames as they come, and the velocity within it.

Facts about motion need what came before a frame and what comes after. A ``SlidingWindow`` takes frames one by one and
gives each back, half a window later, with the frames around it: those within the width, and in any case the neighbours,
so that slow trackers (5 Hz) are served, too. ``window_at`` finds the same window where all frames are there already.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

T = TypeVar("T")
ROUNDING_S = 1e-9


@dataclass(frozen=True)
class Around(Generic[T]):
    """A frame and those around it, in order of time.

    Attributes:
        time_s: Time of the frame.
        item: What it holds.
        times_s: Times of the window's frames, its own among them.
        items: What they hold.
    """

    time_s: float
    item: T
    times_s: tuple[float, ...]
    items: tuple[T, ...]


class SlidingWindow(Generic[T]):
    """Gives frames back with those around them.

    Args:
        width_s: Width of the window in seconds, half of it before and half behind a frame.
    """

    def __init__(self, width_s: float) -> None:
        self._half_s = half_s(width_s)
        self._frames: deque[tuple[float, T]] = deque()
        self._next = 0

    def push(self, time_s: float, item: T) -> Iterator[Around[T]]:
        """Take the next frame; gives those whose windows are complete."""
        self._frames.append((time_s, item))
        while (
            self._next < len(self._frames) - 1 and time_s - self._frames[self._next][0] >= self._half_s - 2 * ROUNDING_S
        ):
            yield self._around()

    def finish(self) -> Iterator[Around[T]]:
        """Give the frames that still wait, with what has been seen of their windows, and forget all."""
        while self._next < len(self._frames):
            yield self._around()
        self._frames.clear()
        self._next = 0

    def _around(self) -> Around[T]:
        time_s, item = self._frames[self._next]
        while self._next > 1 and time_s - self._frames[0][0] > self._half_s:
            self._frames.popleft()
            self._next -= 1
        window = [
            frame
            for index, frame in enumerate(self._frames)
            if abs(frame[0] - time_s) <= self._half_s or abs(index - self._next) == 1
        ]
        self._next += 1
        times, items = zip(*window, strict=True)
        return Around(time_s, item, times, items)


def half_s(width_s: float) -> float:
    """Half of a window in seconds, with room for the rounding of times."""
    return width_s / 2 + ROUNDING_S


def window_at(times_s: Sequence[float], index: int, width_s: float) -> range:
    """Indices of the frames that a ``SlidingWindow`` gives around one frame of a whole sequence.

    Args:
        times_s: Times of all frames in seconds, strictly increasing.
        index: Which frame.
        width_s: Width of the window in seconds.
    """
    half, now_s, end = half_s(width_s), times_s[index], len(times_s) - 1
    first, last = max(index - 1, 0), min(index + 1, end)
    while first > 0 and now_s - times_s[first - 1] <= half:
        first -= 1
    # As soon as it is half a window late, the sliding window gives a frame back, and takes no more for it.
    while last < end and times_s[last] - now_s < half - 2 * ROUNDING_S and times_s[last + 1] - now_s <= half:
        last += 1
    return range(first, last + 1)


def velocity(times_s: Sequence[float], places: ArrayLike) -> NDArray[np.float64] | None:
    """Velocity in metres per second (3,) of a straight line fitted to places (n, 3); None for a single time."""
    moments = np.asarray(times_s) - np.mean(times_s)
    spread = float(moments @ moments)
    return None if spread <= 0.0 else np.asarray(moments @ np.asarray(places) / spread)
