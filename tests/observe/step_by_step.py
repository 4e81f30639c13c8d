"""The slow, obvious twin: watches every frame as it comes, one step after the other, and keeps what it confirms."""

from __future__ import annotations

import bisect
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from taskgist.common.arrays import Array
from taskgist.facts import vocabulary as v
from taskgist.observe import HandStatus, Interval, Placement, velocity
from taskgist.settings import DEFAULT, Contact, Settings, Timing
from taskgist.world import Hold, Holding, Scene, Stage, State, hand_known, holding_of, posture_of, rests_on
from taskgist.world.contacts import POINT_SPACING_M, hook_of, object_points, possible_holds, wearer_of
from taskgist.world.geometry.transforms import Pose

H = TypeVar("H", bound=Hashable)
T = TypeVar("T")
ROUNDING_S = 1e-6


class Confirmation(Generic[H]):
    """Confirms the values of one fact; each change counts once its value has lasted, from its onset on."""

    def __init__(self, minimum_s: float, key: Callable[[H], Hashable] = lambda value: value) -> None:
        self._minimum_s, self._key = minimum_s, key
        self._onsets: list[float] = []
        self._values: list[H] = []
        self._run: tuple[H, float] | None = None
        self._changes_s: list[float] = []
        self._changes: list[H] = []
        self._now_s = 0.0

    def update(self, time_s: float, value: H) -> None:
        if self._run is None or not self._same(self._run[0], value):
            self._run = (value, time_s)
        if not self._changes or self._changes[-1] != value:
            self._changes_s.append(time_s)
            self._changes.append(value)
        self._now_s = time_s
        first, onset = self._run
        has_lasted = time_s - onset >= self._minimum_s - ROUNDING_S
        if has_lasted and not (self._values and self._same(self._values[-1], first)):
            self._onsets.append(onset)
            self._values.append(first)

    def _same(self, one: H, other: H) -> bool:
        return self._key(one) == self._key(other)

    @property
    def intervals(self) -> tuple[Interval[H], ...]:
        ends = [*self._onsets[1:], self._now_s][: len(self._onsets)]
        return tuple(
            Interval(value, start, end) for value, start, end in zip(self._values, self._onsets, ends, strict=True)
        )

    def at(self, time_s: float) -> H | None:
        index = bisect.bisect_right(self._onsets, time_s + ROUNDING_S) - 1
        if index < 0:
            return None
        latest = bisect.bisect_right(self._changes_s, time_s + ROUNDING_S)
        back = (self._changes[change] for change in range(latest - 1, -1, -1))
        return next(raw for raw in back if self._same(raw, self._values[index]))


class InTwoSteps(Generic[H]):
    """Confirms what kind a value is of, and apart from that the value; where the two agree the value counts."""

    def __init__(self, minimum_s: float, kind: Callable[[H], Hashable]) -> None:
        self._kind, self._rough, self._whole = kind, Confirmation[H](minimum_s, kind), Confirmation[H](minimum_s)

    def update(self, time_s: float, value: H) -> None:
        self._rough.update(time_s, value)
        self._whole.update(time_s, value)

    def at(self, time_s: float) -> H | None:
        rough, whole = self._rough.at(time_s), self._whole.at(time_s)
        agree = rough is not None and whole is not None and self._kind(rough) == self._kind(whole)
        return whole if agree else rough

    @property
    def intervals(self) -> tuple[Interval[H], ...]:
        both = [*self._rough.intervals, *self._whole.intervals]
        changes: list[tuple[float, H]] = []
        for start_s in sorted({interval.start_s for interval in both}):
            value = self.at(start_s)
            if value is not None and value not in [known for _, known in changes[-1:]]:
                changes.append((start_s, value))
        starts = [start_s for start_s, _ in changes]
        ends = [*starts[1:], max((interval.end_s for interval in both), default=0.0)][: len(starts)]
        return tuple(Interval(value, start_s, end) for (start_s, value), end in zip(changes, ends, strict=True))


@dataclass(frozen=True)
class Around(Generic[T]):
    """A frame and those around it, in order of time, its own among them."""

    time_s: float
    item: T
    times_s: tuple[float, ...]
    items: tuple[T, ...]


class SlidingWindow(Generic[T]):
    """Takes frames one by one and gives each back, half a window later, with those within the window around it."""

    def __init__(self, width_s: float) -> None:
        self._half_s = width_s / 2 + ROUNDING_S
        self._frames: deque[tuple[float, T]] = deque()
        self._next = 0

    def push(self, time_s: float, item: T) -> Iterator[Around[T]]:
        self._frames.append((time_s, item))
        late_s = self._half_s - 2 * ROUNDING_S
        while self._next < len(self._frames) - 1 and time_s - self._frames[self._next][0] >= late_s:
            yield self._around()

    def finish(self) -> Iterator[Around[T]]:
        """Those that still wait, with what has been seen of their windows; all is forgotten."""
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


class MotionWatch:
    """Follows one object's points; a frame in which it was not tracked is unknown, and all starts anew behind it."""

    def __init__(self, settings: Timing) -> None:
        self._settings = settings
        self._window: SlidingWindow[Array] = SlidingWindow(settings.motion_window_s)
        self._moving = False

    def update(self, time_s: float, points: Array | None) -> Iterator[tuple[float, str | None]]:
        """Gives (time in seconds, ``Moving`` | ``Static`` | None) of the frames that can be answered now.

        Points are in the world, (n, 3).
        """
        if points is None:
            yield from self.finish()
            self._moving = False
            yield time_s, None
        else:
            yield from map(self._answer, self._window.push(time_s, points))

    def finish(self) -> Iterator[tuple[float, str | None]]:
        yield from map(self._answer, self._window.finish())

    def _answer(self, around: Around[Array]) -> tuple[float, str | None]:
        fitted = velocity(around.times_s, around.items)
        if fitted is None:
            return around.time_s, None
        limit_m_s = self._settings.static_m_s if self._moving else self._settings.moving_m_s
        self._moving = max(float(np.linalg.norm(each)) for each in fitted) > limit_m_s
        return around.time_s, v.MOVING if self._moving else v.STATIC


@dataclass(frozen=True, eq=False)
class Hands:
    """A state, its hands that are near to objects, and where palms and objects are, as far as they were tracked."""

    state: State
    near: frozenset[Hold]
    palms: dict[tuple[str, str], Array]
    objects: dict[str, Pose]

    def place(self, hold: Hold) -> Array | None:
        palm, thing = self.palms.get((hold.agent, hold.side)), self.objects.get(hold.object)
        return None if palm is None or thing is None else thing.to_local(palm)


def hands_of(stage: Stage, settings: Contact) -> Hands:
    scene, state = stage.scene, stage.state
    agents = [scene.agent(name) for name in scene.agents]
    palms = {
        (agent.name, arm.profile.side): stage.site(arm.palm_site).position
        for agent in agents
        for arm in agent.arms
        if hand_known(stage, agent, arm)
    }
    objects = {name: stage.body(scene.object_body(name)) for name in scene.objects if state.known([name])}
    return Hands(state, possible_holds(stage, settings), palms, objects)


class HoldingWatch:
    """Takes states and gives them back, half a window later, with who holds what decided."""

    def __init__(self, settings: Contact) -> None:
        self._settings = settings
        self._window: SlidingWindow[Hands] = SlidingWindow(settings.slip_window_s)
        self._held: frozenset[Hold] = frozenset()

    def update(self, stage: Stage) -> Iterator[State]:
        hands = hands_of(stage, self._settings)
        yield from map(self._decided, self._window.push(stage.state.time_s, hands))

    def finish(self) -> Iterator[State]:
        yield from map(self._decided, self._window.finish())

    def _decided(self, around: Around[Hands]) -> State:
        self._held = frozenset(hold for hold in around.item.near if self._stays(hold, around.items))
        return around.item.state.with_holding(self._held)

    def _stays(self, hold: Hold, window: Iterable[Hands]) -> bool:
        places = [(hands.state.time_s, place) for hands in window if (place := hands.place(hold)) is not None]
        slip = velocity([time_s for time_s, _ in places], [place for _, place in places])
        limit_m_s = self._settings.slip_stop_m_s if hold in self._held else self._settings.slip_start_m_s
        return slip is None or float(np.linalg.norm(slip)) < limit_m_s


class Watching:
    """Watches states as they come; asked at any time, it says what an ``Observer`` says."""

    def __init__(self, scene: Scene, settings: Settings = DEFAULT) -> None:
        self.scene, self._settings, self._stage = scene, settings, Stage(scene)
        minimum_s = settings.timing.minimum_s
        self._holding = HoldingWatch(settings.contact)
        self._watches = {name: MotionWatch(settings.timing) for name in scene.objects}
        at_first = self._stage.show(scene.initial)
        self._points = {
            name: at_first.body(scene.object_body(name)).to_local(object_points(at_first, name, POINT_SPACING_M))
            for name in scene.objects
        }
        self._motions = {name: Confirmation[str | None](minimum_s) for name in scene.objects}
        self._placements = {
            name: InTwoSteps[Placement](minimum_s, lambda placement: placement.symbol) for name in scene.objects
        }
        self._hands = {
            (agent, side): InTwoSteps[HandStatus](minimum_s, held)
            for agent in scene.agents
            for side in scene.agent(agent).sides
        }
        self._postures = {name: Confirmation[str | None](minimum_s) for name in scene.agents}

    @classmethod
    def of(cls, scene: Scene, states: Iterable[State], settings: Settings = DEFAULT) -> Watching:
        """One that has seen all of these states, and knows that no more will come."""
        watching = cls(scene, settings)
        for state in states:
            for decided in watching._holding.update(watching._stage.show(state)):
                watching._take(decided)
        for decided in watching._holding.finish():
            watching._take(decided)
        for name, watch in watching._watches.items():
            for at_s, motion in watch.finish():
                watching._motions[name].update(at_s, motion)
        return watching

    def _take(self, state: State) -> None:
        stage, contact, time_s = self._stage.show(state), self._settings.contact, state.time_s
        held = {name: holding_of(stage, name, contact) for name in self.scene.objects}
        for name, holding in held.items():
            self._placements[name].update(time_s, placement_by(stage, name, holding, contact))
        for who, side in self._hands:
            self._hands[who, side].update(time_s, hand_status(stage, who, side, held, contact))
        for who, confirmation in self._postures.items():
            posture = posture_of(stage, self.scene.agent(who), contact)
            confirmation.update(time_s, {"standing": v.STANDING, "sitting": v.SITTING}[posture] if posture else None)
        for name, watch in self._watches.items():
            points = stage.show(state).body(self.scene.object_body(name)).to_world(self._points[name])
            for at_s, motion in watch.update(time_s, points if state.known([name]) else None):
                self._motions[name].update(at_s, motion)

    def placement(self, name: str) -> InTwoSteps[Placement]:
        return self._placements[name]

    def motion(self, name: str) -> Confirmation[str | None]:
        return self._motions[name]

    def hand(self, agent: str, side: str) -> InTwoSteps[HandStatus]:
        return self._hands[agent, side]

    def posture(self, agent: str) -> Confirmation[str | None]:
        return self._postures[agent]

    def holds(self, time_s: float) -> tuple[Hold, ...]:
        found = ((hand, confirmation.at(time_s)) for hand, confirmation in self._hands.items())
        return tuple(
            Hold(*hand, status.thing)
            for hand, status in found
            if status and status.thing and status.symbol == v.HOLDING_OBJECT
        )

    def with_holding(self, state: State) -> State:
        return state.with_holding(self.holds(state.time_s))


def held(status: HandStatus) -> tuple[str | None, bool, str | None]:
    """Unknown, or what it holds, or that it holds nothing."""
    holds = status.symbol == "Holding_Object"
    return status.symbol and "known", holds, status.thing if holds else None


def placement_by(stage: Stage, name: str, holding: Holding | None, settings: Contact) -> Placement:
    """Inside_Container before On_Support before In_Hand (5.3.1), before On_Agent before Hanging before In_Air."""
    if holding is None:
        return Placement(None)
    if holding.container:
        return Placement("Inside_Container", (holding.container,))
    if holding.support:
        return Placement("On_Support", (holding.support,))
    if holding.hands:
        return Placement("In_Hand", tuple(f"{who}'s {side} hand" for who, side in holding.hands))
    wearer, sure = wearer_of(stage, name, settings)
    hook = hook_of(stage, name, settings)
    if not holding.complete or not sure:
        return Placement(None)
    if wearer:
        return Placement("On_Agent", (wearer,))
    return Placement("Hanging", (hook,)) if hook else Placement("In_Air")


def hand_status(stage: Stage, who: str, side: str, held: dict[str, Holding | None], settings: Contact) -> HandStatus:
    """What a hand holds, what it rests on, or that it is free."""
    agent = stage.scene.agent(who)
    if not hand_known(stage, agent, agent.arm(side)):
        return HandStatus(None)
    for name, holding in held.items():
        if holding and (who, side) in holding.hands:
            return HandStatus("Holding_Object", name)
    support = rests_on(stage, agent.arm(side), settings)
    return HandStatus("Resting_on_Support", support) if support else HandStatus("Free_of_Object")
