"""What is confirmed of hands, postures, placements and motion over time: all that a snapshot asks of the past."""

from __future__ import annotations

import bisect
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Generic, Protocol, TypeVar

from taskgist.facts import vocabulary as v
from taskgist.observe.holding import HoldingLookup, HoldingWatch
from taskgist.observe.motion import MotionLookup, MotionWatch, Place, object_place
from taskgist.observe.status import (
    HandUse,
    Placed,
    hand_key,
    hand_use,
    placed,
    placement_key,
    posture_symbol,
    statuses_of,
)
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import RestingMemory
from taskgist.world.holding import Holding, holding_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Frames, Hold, State

# --- Confirmation: facts that must last before they count.
#
# A raw fact flickers: a tracked hand trembles at the edge of a contact, an object wobbles when it is put down. A
# ``Confirmation`` takes one raw value per frame, as they come, and lets a change count only after the new value has
# lasted for a minimum duration. The change is then backdated to its onset. Until that moment the new value is
# *provisional*: the old one still stands.
#
# Example, with a minimum of 0.2 s and frames every 0.1 s::
#
#     raw        A A A B A A A B B B B
#     confirmed  A A A A A A A B B B B      the lone B never counted, the last B counts from its first frame on
#
# Live and offline are the same code fed the same frames, so what was confirmed live stands offline.
#
# Only the key of a value must last. What else belongs to it, such as the support that an object rests on, is not
# confirmed: it is told as of the last frame that had the key.

H = TypeVar("H", bound=Hashable)
ROUNDING_S = 1e-9


def lasts(onset_s: float, time_s: float, minimum_s: float) -> bool:
    """Whether a value has lasted long enough to be confirmed."""
    return time_s - onset_s >= minimum_s - ROUNDING_S


@dataclass(frozen=True)
class Interval(Generic[H]):
    """A value that holds from ``start_s`` until ``end_s``, in seconds; the last one's end is the last frame seen."""

    value: H
    start_s: float
    end_s: float


class Confirmation(Generic[H]):
    """Confirms the values of one fact over time.

    Args:
        minimum_s: How long a value must last to be confirmed, in seconds.
        key: What of a value must last.
    """

    def __init__(self, minimum_s: float, key: Callable[[H], Hashable] = lambda value: value) -> None:
        self._minimum_s = minimum_s
        self._key = key
        self._onsets: list[float] = []
        self._values: list[H] = []
        self._run: tuple[H, float] | None = None
        self._changes_s: list[float] = []
        self._changes: list[H] = []
        self._now_s = 0.0

    def update(self, time_s: float, value: H) -> None:
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

    def _same(self, one: H, other: H) -> bool:
        return self._key(one) == self._key(other)

    @property
    def provisional(self) -> H | None:
        """The raw value of the last frame, where it is not confirmed (yet)."""
        if self._run is None or (self._values and self._same(self._values[-1], self._run[0])):
            return None
        return self._run[0]

    @property
    def intervals(self) -> tuple[Interval[H], ...]:
        """The confirmed values in order, each as it was at its onset; it ends where the next begins."""
        ends = [*self._onsets[1:], self._now_s][: len(self._onsets)]
        return tuple(
            Interval(value, start, end) for value, start, end in zip(self._values, self._onsets, ends, strict=True)
        )

    def at(self, time_s: float) -> H | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""
        index = bisect.bisect_right(self._onsets, time_s + ROUNDING_S) - 1
        if index < 0:
            return None
        latest = bisect.bisect_right(self._changes_s, time_s + ROUNDING_S)
        back = (self._changes[change] for change in range(latest - 1, -1, -1))
        return next(raw for raw in back if self._same(raw, self._values[index]))


V_co = TypeVar("V_co", covariant=True)


class Confirmed(Protocol[V_co]):
    """The confirmed values of one fact."""

    def at(self, time_s: float) -> V_co | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""


class History(ABC):
    """Confirmed facts of one scene over time. Whoever has them all gives the same answers, however they were found.

    Args:
        scene: The scene.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    @abstractmethod
    def placement(self, name: str) -> Confirmed[Placed]:
        """Placement of an object over time.

        Raises:
            UnknownNameError: There is no such object.
        """

    @abstractmethod
    def motion(self, name: str) -> Confirmed[str | None]:
        """Motion of an object over time; None is unknown.

        Raises:
            UnknownNameError: There is no such object.
        """

    @abstractmethod
    def hand(self, agent: str, side: str) -> Confirmed[HandUse]:
        """Use of a hand over time.

        Raises:
            UnknownNameError: There is no such agent, or it has no such hand.
        """

    @abstractmethod
    def posture(self, agent: str) -> Confirmed[str | None]:
        """Posture of an agent over time; None is unknown.

        Raises:
            UnknownNameError: There is no such agent.
        """

    def sides(self, agent: str) -> tuple[str, ...]:
        """Sides on which an agent has a hand."""
        return self.scene.agent(agent).sides

    def holds(self, time_s: float) -> tuple[Hold, ...]:
        """Which hands hold what at a time, as confirmed."""
        hands = ((agent, side) for agent in self.scene.agents for side in self.sides(agent))
        return tuple(
            Hold(agent, side, use.of)
            for agent, side in hands
            if (use := self.hand(agent, side).at(time_s)) and use.symbol == v.HOLDING_OBJECT and use.of
        )

    def decided(self, state: State) -> State:
        """A state with who holds what in it, as confirmed at its time: what perspective should start from."""
        return state.with_holding(self.holds(state.time_s))


# --- Lookup: the confirmed value of a fact at one time, found from the frames around it.
#
# A ``Confirmation`` takes all frames as they come. Who asks for one time of a whole sequence needs few of them: the
# run of equal raw values around that frame, as far as it takes to see that it lasts. Where it does not last, the run
# before it decides, and so on.
#
# Example, with a minimum of 0.2 s and frames every 0.1 s; asked for the frame under the caret::
#
#     raw    A A A B A A A B B B B
#                  ^                  this B does not last, the A before it does: 5 frames were looked at
#                          ^          this B lasts: 4 frames were looked at

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


# --- The lazy observer: says of any time what an observer that has seen all frames says, and looks at few of them.
#
# An explanation asks for two times, one object and one agent's hands and posture. What is confirmed there hangs on
# the frames around these times: the windows of motion and slip, the frames before them as long as hysteresis leaves
# them open, and the runs of equal raw facts until one has lasted. These frames are looked at, and no others.


class LazyObserver(History):
    """Confirmed facts over a whole sequence of frames, each found when it is asked for.

    Args:
        scene: The scene whose states they are.
        frames: The frames, such as a recording.
        settings: Distances and durations.
    """

    def __init__(self, scene: Scene, frames: Frames, settings: Settings = DEFAULT) -> None:
        super().__init__(scene)
        self._frames, self._settings = frames, settings
        self._times_s: list[float] = frames.times_s.tolist()
        self._stage = Stage(scene)
        self._holding = HoldingLookup(self._stage, frames, settings.contact)
        self._resting = RestingMemory(scene, settings.contact)
        self._held = cache(self._holding_of)
        self._placement, self._motion = cache(self._placement_of), cache(self._motion_of)
        self._hand, self._posture = cache(self._hand_of), cache(self._posture_of)

    def placement(self, name: str) -> Lookup[Placed]:
        """Placement of an object over time."""
        return self._placement(name)

    def motion(self, name: str) -> Lookup[str | None]:
        """Motion of an object over time; None is unknown."""
        return self._motion(name)

    def hand(self, agent: str, side: str) -> Lookup[HandUse]:
        """Use of a hand over time."""
        return self._hand(agent, side)

    def posture(self, agent: str) -> Lookup[str | None]:
        """Posture of an agent over time; None is unknown."""
        return self._posture(agent)

    def _placement_of(self, name: str) -> Lookup[Placed]:
        self.scene.object_body(name)
        return self._lookup(lambda index: placed(self._held(index, name)), placement_key)

    def _motion_of(self, name: str) -> Lookup[str | None]:
        self.scene.object_body(name)
        moving = MotionLookup(self._times_s, partial(self._place, name), self._settings.timing)
        return self._lookup(moving.at)

    def _hand_of(self, agent: str, side: str) -> Lookup[HandUse]:
        who, arm = self.scene.agent(agent), self.scene.agent(agent).arm(side)

        def raw(index: int) -> HandUse:
            stage = self._stage.show(self._holding.decided(index))
            return hand_use(stage, who, arm, partial(self._held, index), self._settings.contact)

        return self._lookup(raw, hand_key)

    def _posture_of(self, agent: str) -> Lookup[str | None]:
        who = self.scene.agent(agent)
        return self._lookup(
            lambda index: posture_symbol(self._stage.show(self._frames.state(index)), who, self._settings.contact)
        )

    def _holding_of(self, index: int, name: str) -> Holding | None:
        stage = self._stage.show(self._holding.decided(index))
        return holding_of(stage, name, self._settings.contact, self._resting)

    def _place(self, name: str, index: int) -> Place | None:
        return object_place(self.scene, self._frames.state(index), name)

    def _lookup(self, raw: Callable[[int], V], key: Callable[[V], Hashable] = lambda value: value) -> Lookup[V]:
        return Lookup(self._times_s, raw, self._settings.timing.minimum_s, key)


# --- The observer: watches states as they come and keeps what is confirmed of hands, postures, placements and motion.
#
# Live use feeds it frames from a tracker; offline use feeds it a recording. Both are the same code::
#
#     observer = Observer(scene)
#     for state in states:
#         observer.update(state)
#     observer.placement("cup").at(2.5)


class Observer(History):
    """Confirms facts over time.

    Args:
        scene: The scene whose states it will be shown.
        settings: Distances and durations.
    """

    def __init__(self, scene: Scene, settings: Settings = DEFAULT) -> None:
        super().__init__(scene)
        minimum = settings.timing.minimum_s
        self._settings = settings
        self._stage = Stage(scene)
        self._holding = HoldingWatch(scene, settings.contact)
        self._resting = RestingMemory(scene, settings.contact)
        self._placements: dict[str, Confirmation[Placed]] = {
            name: Confirmation(minimum, key=placement_key) for name in scene.objects
        }
        self._motions: dict[str, Confirmation[str | None]] = {name: Confirmation(minimum) for name in scene.objects}
        self._watches = {name: MotionWatch(settings.timing) for name in scene.objects}
        self._hands: dict[tuple[str, str], Confirmation[HandUse]] = {
            (agent, side): Confirmation(minimum, key=hand_key)
            for agent in scene.agents
            for side in scene.agent(agent).sides
        }
        self._postures: dict[str, Confirmation[str | None]] = {name: Confirmation(minimum) for name in scene.agents}

    @classmethod
    def of(cls, scene: Scene, states: Iterable[State], settings: Settings = DEFAULT) -> Observer:
        """An observer that has seen all of these states, and knows that no more will come."""
        observer = cls(scene, settings)
        for state in states:
            observer.update(state)
        observer.finish()
        return observer

    def update(self, state: State) -> None:
        """Take the next frame."""
        for decided in self._holding.update(state):
            self._take(decided)

    def finish(self) -> None:
        """Say that no more frames will come."""
        for decided in self._holding.finish():
            self._take(decided)
        for name, watch in self._watches.items():
            for at_s, motion in watch.finish():
                self._motions[name].update(at_s, motion)

    def _take(self, state: State) -> None:
        time = state.time_s
        statuses = statuses_of(self._stage.show(state), self._settings.contact, self._resting)
        for name, placement in statuses.placements.items():
            self._placements[name].update(time, placement)
        for hand, use in statuses.hands.items():
            self._hands[hand].update(time, use)
        for agent, posture in statuses.postures.items():
            self._postures[agent].update(time, posture)
        for name, watch in self._watches.items():
            for at_s, motion in watch.update(time, object_place(self.scene, state, name)):
                self._motions[name].update(at_s, motion)

    def placement(self, name: str) -> Confirmation[Placed]:
        """Placement of an object over time."""
        self.scene.object_body(name)
        return self._placements[name]

    def motion(self, name: str) -> Confirmation[str | None]:
        """Motion of an object over time; None is unknown."""
        self.scene.object_body(name)
        return self._motions[name]

    def hand(self, agent: str, side: str) -> Confirmation[HandUse]:
        """Use of a hand over time."""
        self.scene.agent(agent).arm(side)
        return self._hands[agent, side]

    def posture(self, agent: str) -> Confirmation[str | None]:
        """Posture of an agent over time; None is unknown."""
        self.scene.agent(agent)
        return self._postures[agent]
