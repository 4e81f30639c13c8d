"""Motion of objects: speed over a short window, with hysteresis between starting and coming to rest (5.3.2)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import vocabulary as v
from taskgist.settings import Timing
from taskgist.world import Around, SlidingWindow, velocity


class MotionWatch:
    """Follows one object's place and says for each frame whether it was moving.

    The speed at a frame is that of a straight line through the window around it, so an answer comes half a window
    late; ``update`` yields the answers that have become possible. A frame at which the object was not tracked is
    unknown (None), and the watch starts anew behind it. So is a frame that stands alone.

    Args:
        settings: Window in seconds, and the two speeds in metres per second.
    """

    def __init__(self, settings: Timing) -> None:
        self._settings = settings
        self._window: SlidingWindow[NDArray[np.float64]] = SlidingWindow(settings.motion_window_s)
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
        else:
            yield from map(self._answer, self._window.push(time_s, position))

    def finish(self) -> Iterator[tuple[float, str | None]]:
        """Answer for the frames that still wait, with what has been seen of their windows."""
        yield from map(self._answer, self._window.finish())

    def _answer(self, around: Around[NDArray[np.float64]]) -> tuple[float, str | None]:
        moved = velocity(around.times_s, around.items)
        if moved is None:
            return around.time_s, None
        limit = self._settings.static_m_s if self._moving else self._settings.moving_m_s
        self._moving = float(np.linalg.norm(moved)) > limit
        return around.time_s, v.MOVING if self._moving else v.STATIC
