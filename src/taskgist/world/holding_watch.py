"""Holding over time: a held object moves with the hand.

A hand that passes an object, or reaches around it before it closes, is near and yet does not hold. What tells them
apart is slip. A ``HoldingWatch`` takes states as they come and gives them back, half a window later, with
``State.holding`` decided. A ``HoldingLookup`` decides single frames of a whole sequence, as that watch would.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial

from taskgist.settings import Contact
from taskgist.world.frames import Frames
from taskgist.world.hysteresis import followed
from taskgist.world.scene import Scene
from taskgist.world.slip import Hands, holds_on, slip_m_s
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State
from taskgist.world.window import Around, SlidingWindow, window_at


class HoldingWatch:
    """Decides who holds what in states that follow each other.

    Args:
        scene: Their scene.
        settings: Distances, speeds and the window.
    """

    def __init__(self, scene: Scene, settings: Contact) -> None:
        self._settings = settings
        self._stage = Stage(scene)
        self._window: SlidingWindow[Hands] = SlidingWindow(settings.slip_window_s)
        self._held: frozenset[Hold] = frozenset()

    def update(self, state: State) -> Iterator[State]:
        """Take the next state; yields those that can be decided now, in order."""
        hands = Hands.of(self._stage, state, self._settings)
        yield from map(self._decided, self._window.push(state.time_s, hands))

    def finish(self) -> Iterator[State]:
        """Decide the states that still wait, by what has been seen of their windows."""
        yield from map(self._decided, self._window.finish())

    def _decided(self, around: Around[Hands]) -> State:
        self._held = frozenset(hold for hold in around.item.near if self._stays(hold, around))
        return around.item.state.with_holding(self._held)

    def _stays(self, hold: Hold, around: Around[Hands]) -> bool:
        return holds_on(slip_m_s(hold, around.items), hold in self._held, self._settings)


class HoldingLookup:
    """Decides who holds what in any frame of a sequence, as a ``HoldingWatch`` that saw all of them does.

    Args:
        stage: Their scene; it shows other states after each question.
        frames: The sequence.
        settings: Distances, speeds and the window.
    """

    def __init__(self, stage: Stage, frames: Frames, settings: Contact) -> None:
        self._stage, self._frames, self._settings = stage, frames, settings
        self._times_s: list[float] = frames.times_s.tolist()
        self._hands, self._slip_m_s = cache(self._look), cache(self._measure)
        self.decided = cache(self._decided)

    def _decided(self, index: int) -> State:
        hands = self._hands(index)
        held = (hold for hold in hands.near if followed(partial(self._holds, hold), index))
        return hands.state.with_holding(held)

    def _holds(self, hold: Hold, index: int, before: bool) -> bool:
        near = hold in self._hands(index).near
        return near and holds_on(self._slip_m_s(hold, index), before, self._settings)

    def _look(self, index: int) -> Hands:
        return Hands.of(self._stage, self._frames.state(index), self._settings)

    def _measure(self, hold: Hold, index: int) -> float | None:
        around = window_at(self._times_s, index, self._settings.slip_window_s)
        return slip_m_s(hold, map(self._hands, around))
