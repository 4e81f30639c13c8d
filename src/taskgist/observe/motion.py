"""Motion of objects: speed over a short window, with hysteresis between starting and coming to rest (5.3.2)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.facts import vocabulary as v
from taskgist.settings import Timing
from taskgist.world.scene import Scene
from taskgist.world.state import State

# --- Hysteresis: what is true of a frame may depend on what was true of the frame before it.
#
# A hand begins to hold at a low slip and lets go at a high one; in between, all stays as it was. Who watches frames
# as they come keeps the last answer. Who asks for one frame out of a whole sequence goes back to the nearest frame
# whose answer is the same whatever came before it, and follows the frames from there.


def followed(answer: Callable[[int, bool], bool], index: int) -> bool:
    """What is true of a frame after all the frames before it, as if the answer before the first one were False.

    Args:
        answer: Gives what is true of a frame, by its index and what was true of the frame before it.
        index: Which frame.
    """
    start = index
    while start > 0 and answer(start, True) != answer(start, False):
        start -= 1
    state = answer(start, False)
    for each in range(start + 1, index + 1):
        state = answer(each, state)
    return state


# --- A window that slides over frames as they come, and the velocity within it.
#
# Facts about motion need what came before a frame and what comes after. A ``SlidingWindow`` takes frames one by one
# and gives each back, half a window later, with the frames around it: those within the width, and in any case the
# neighbours, so that slow trackers (5 Hz) are served, too. ``window_at`` finds the same window where all frames are
# there already.

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
