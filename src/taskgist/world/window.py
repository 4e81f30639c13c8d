"""A window that slides over frames as they come, and the velocity within it.

Facts about motion need what came before a frame and what comes after. A ``SlidingWindow`` takes frames one by one and
gives each back, half a window later, with the frames around it: those within the width, and in any case the neighbours,
so that slow trackers (5 Hz) are served, too.
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
        self._half_s = width_s / 2 + ROUNDING_S
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
        while self._next > 1 and self._frames[0][0] < time_s - self._half_s:
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


def velocity(times_s: Sequence[float], places: ArrayLike) -> NDArray[np.float64] | None:
    """Velocity in metres per second (3,) of a straight line fitted to places (n, 3); None for a single time."""
    moments = np.asarray(times_s) - np.mean(times_s)
    spread = float(moments @ moments)
    return None if spread <= 0.0 else np.asarray(moments @ np.asarray(places) / spread)
