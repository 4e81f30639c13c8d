"""Motion of objects: speed over a short window, with hysteresis between starting and coming to rest (5.3.2)."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import vocabulary as v
from taskgist.settings import Timing


class MotionWatch:
    """Follows one object's place and says for each frame whether it was moving.

    The speed at a frame is measured over the window around it, so an answer comes half a window late; ``update``
    yields the answers that have become possible. A frame at which the object was not tracked is unknown (None), and the
    watch starts anew behind it.

    Args:
        settings: Window in seconds, and the two speeds in metres per second.
    """

    def __init__(self, settings: Timing) -> None:
        self._settings = settings
        self._frames: deque[tuple[float, NDArray[np.float64]]] = deque()
        self._next = 0
        self._moving = False

    def update(self, time_s: float, position: NDArray[np.float64] | None) -> Iterator[tuple[float, str | None]]:
        """Take the next frame.

        Args:
            time_s: Its time in seconds.
            position: The object's place in metres (3,), or None where it was not tracked.

        Yields:
            (time in seconds, ``Moving`` | ``Static`` | None) of frames, in order.
        """
        if position is None:
            yield from self.finish()
            self._moving = False
            yield time_s, None
            return
        self._frames.append((time_s, position))
        half = self._settings.motion_window_s / 2
        while self._next < len(self._frames) and self._frames[self._next][0] + half <= time_s + 1e-9:
            yield self._answer(time_s)

    def finish(self) -> Iterator[tuple[float, str | None]]:
        """Answer for the frames that still wait, with what has been seen of their windows."""
        while self._next < len(self._frames):
            yield self._answer(self._frames[-1][0])
        self._frames.clear()
        self._next = 0

    def _answer(self, now_s: float) -> tuple[float, str | None]:
        half = self._settings.motion_window_s / 2
        middle = self._frames[self._next][0]
        while self._frames[0][0] < middle - half - 1e-9:
            self._frames.popleft()
            self._next -= 1
        start_s, start = self._frames[0]
        end_s, end = next((t, p) for t, p in reversed(self._frames) if t <= min(now_s, middle + half) + 1e-9)
        span = end_s - start_s
        speed = float(np.linalg.norm(end - start)) / span if span > 0 else 0.0
        limit = self._settings.static_m_s if self._moving else self._settings.moving_m_s
        self._moving = speed > limit
        self._next += 1
        return middle, v.MOVING if self._moving else v.STATIC
