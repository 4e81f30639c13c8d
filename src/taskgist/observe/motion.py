"""Motion of objects: speed over a short window, with hysteresis between starting and coming to rest (5.3.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import vocabulary as v
from taskgist.settings import Timing
from taskgist.world import Around, Scene, SlidingWindow, State, velocity
from taskgist.world.hysteresis import followed
from taskgist.world.window import window_at

Place = NDArray[np.float64]


def object_place(scene: Scene, state: State, name: str) -> Place | None:
    """Place of an object in metres, (3,); None where it was not tracked."""
    return np.array(state.qpos[scene.object_slice(name)][:3]) if state.known([name]) else None


def speed_m_s(times_s: Sequence[float], places: Sequence[Place]) -> float | None:
    """Speed of a straight line through places (3,) in metres; None where there is but one."""
    moved = velocity(times_s, places)
    return None if moved is None else float(np.linalg.norm(moved))


def moves_on(speed_m_s: float | None, before: bool, settings: Timing) -> bool:
    """Whether something moves, by its speed and whether it moved before; it goes on where the speed is unknown."""
    return before if speed_m_s is None else speed_m_s > (settings.static_m_s if before else settings.moving_m_s)


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
        self._window: SlidingWindow[Place] = SlidingWindow(settings.motion_window_s)
        self._moving = False

    def update(self, time_s: float, position: Place | None) -> Iterator[tuple[float, str | None]]:
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

    def _answer(self, around: Around[Place]) -> tuple[float, str | None]:
        speed = speed_m_s(around.times_s, around.items)
        self._moving = moves_on(speed, self._moving, self._settings)
        return around.time_s, _symbol(speed, self._moving)


class MotionLookup:
    """Says of any frame of a sequence what a ``MotionWatch`` that sees all of them says.

    Args:
        times_s: Times of all frames in seconds, strictly increasing.
        place: Gives the object's place in a frame in metres (3,), by its index; None where it was not tracked.
        settings: Window in seconds, and the two speeds in metres per second.
    """

    def __init__(self, times_s: Sequence[float], place: Callable[[int], Place | None], settings: Timing) -> None:
        self._times_s, self._settings = times_s, settings
        self._place, self._speed_m_s = cache(place), cache(self._measure)

    def at(self, index: int) -> str | None:
        """``Moving``, ``Static``, or None where it is unknown."""
        if self._place(index) is None:
            return None
        return _symbol(self._speed_m_s(index), followed(self._moves, index))

    def _moves(self, index: int, before: bool) -> bool:
        return self._place(index) is not None and moves_on(self._speed_m_s(index), before, self._settings)

    def _measure(self, index: int) -> float | None:
        """Speed from those frames of the window between which the object was always tracked."""
        window = window_at(self._times_s, index, self._settings.motion_window_s)
        before = self._tracked(range(index - 1, window.start - 1, -1))
        behind = self._tracked(range(index, window.stop))
        return speed_m_s([time_s for time_s, _ in (*before[::-1], *behind)], [at for _, at in (*before[::-1], *behind)])

    def _tracked(self, indices: range) -> list[tuple[float, Place]]:
        """Times and places of frames until the first in which the object was not tracked."""
        found = []
        for index in indices:
            if (place := self._place(index)) is None:
                break
            found.append((self._times_s[index], place))
        return found


def _symbol(speed_m_s: float | None, moving: bool) -> str | None:
    if speed_m_s is None:
        return None
    return v.MOVING if moving else v.STATIC
