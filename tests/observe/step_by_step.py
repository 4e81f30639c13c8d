"""The slow, obvious twin: watches every frame as it comes, one step after the other, and keeps what it confirms."""

from __future__ import annotations

import bisect
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

import numpy as np

from taskgist.common.arrays import Array
from taskgist.facts import vocabulary as v
from taskgist.observe import HandStatus, Interval, Placement, velocity
from taskgist.observe.eyes import turned_towards
from taskgist.observe.holding import Carrier, Evidence, NearHand, NoHand, pressed
from taskgist.settings import DEFAULT, Contact, Settings, Timing
from taskgist.world import Hold, Holding, Scene, Stage, State, hand_gap_m, hand_known, posture_of, rests_on
from taskgist.world.contacts import POINT_SPACING_M, Rest, hook_of, object_points, rest_of, wearer_of
from taskgist.world.geometry.transforms import Pose
from tests.observe import holding_twin

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
        self._moving = float(np.linalg.norm(fitted, axis=1).max()) > limit_m_s
        return around.time_s, v.MOVING if self._moving else v.STATIC


@dataclass(frozen=True, eq=False)
class Seen:
    """One frame: what was tracked of a thing and of the hands, what is beneath it, and how far hands are from it."""

    time_s: float
    pose: Pose | None
    palms: dict[tuple[str, str], Array]
    rest: Rest
    gaps_m: dict[tuple[str, str], float]


class HoldingWatch:
    """Takes all states, and says for each what carries one thing: every frame is looked at, and every story tried."""

    def __init__(self, scene: Scene, name: str, settings: Settings) -> None:
        self._scene, self._name, self._settings = scene, name, settings
        self._stage = Stage(scene)
        self._local = _middle(self._stage, name)
        self._hands = [(who, arm.profile.side) for who in scene.agents for arm in scene.agent(who).arms]

    def decided(self, states: Sequence[State]) -> list[Carrier]:
        """Of each state; where the thing was not tracked, whatever comes out."""
        seen = [self._look(state) for state in states]
        times_s = [each.time_s for each in seen]
        beneath = {each.rest.container or each.rest.support for each in seen} & set(self._scene.objects)
        under = {other: self._velocities(states, other) for other in beneath if other}
        places = [None if each.pose is None else each.pose.to_world(self._local) for each in seen]
        frames = [self._evidence(seen, places, index, under) for index in range(len(seen))]
        stories: dict[tuple[int, int], list[Carrier]] = {}
        found = list[Carrier]()
        for index, time_s in enumerate(times_s):
            # Back and forth to where it rests, or to five seconds beyond the ten seconds to which the frame belongs.
            start_s = times_s[0] + 10.0 * int((time_s - times_s[0]) / 10.0)
            first = last = index
            while first > 0 and not frames[first].rests and times_s[first - 1] >= start_s - 5.0:
                first -= 1
            while last < len(times_s) - 1 and not frames[last].rests and times_s[last + 1] <= start_s + 15.0:
                last += 1
            if (first, last) not in stories:
                story = holding_twin.likeliest(frames[first : last + 1], self._settings.carrying)
                stories[first, last] = pressed(story, times_s[first : last + 1], self._settings.carrying.closing_s)
            found.append(NoHand.SUPPORT if frames[index].rests else stories[first, last][index - first])
        return found

    def _look(self, state: State) -> Seen:
        stage, scene = self._stage.show(state), self._scene
        arms = {hand: (scene.agent(hand[0]), scene.agent(hand[0]).arm(hand[1])) for hand in self._hands}
        known = {hand: arm for hand, (agent, arm) in arms.items() if hand_known(stage, agent, arm)}
        palms = {hand: stage.site(arm.palm_site).position for hand, arm in known.items()}
        if not state.known([self._name]):
            return Seen(state.time_s, None, palms, Rest(None, None), {})
        gaps_m = {hand: hand_gap_m(stage, arm, self._name, limit_m=0.3) for hand, arm in known.items()}
        rest = rest_of(stage, self._name, self._settings.contact)
        return Seen(state.time_s, stage.body(scene.object_body(self._name)), palms, rest, gaps_m)

    def _velocities(self, states: Sequence[State], name: str) -> list[Array | None]:
        local, body = _middle(self._stage, name), self._scene.object_body(name)
        places = [
            self._stage.show(state).body(body).to_world(local) if state.known([name]) else None for state in states
        ]
        return [_velocity([state.time_s for state in states], places, index) for index in range(len(states))]

    def _evidence(
        self, seen: list[Seen], places: list[Array | None], index: int, under: dict[str, list[Array | None]]
    ) -> Evidence:
        frame, times_s = seen[index], [each.time_s for each in seen]
        after = max(index, 1)
        dt_s = times_s[after] - times_s[after - 1] if len(seen) > 1 else self._settings.carrying.independent_s
        if frame.pose is None:
            return Evidence(dt_s, tracked=False)
        moving, beneath = _velocity(times_s, places, index), frame.rest.container or frame.rest.support
        if beneath:
            along = under[beneath][index] if beneath in under else None
            up_m_s = 0.0 if moving is None else moving[2] - (0.0 if along is None else along[2])
            if abs(up_m_s) <= self._settings.timing.moving_m_s:
                return Evidence(dt_s, touches=True, rests=True)
        return Evidence(
            dt_s,
            touches=beneath is not None,
            speed_m_s=None if moving is None else float(np.linalg.norm(moving)),
            falls=_falls(times_s, places, index),
            near=tuple(
                NearHand(hand, gap_m, self._slip(seen, hand, index))
                for hand, gap_m in frame.gaps_m.items()
                if gap_m < self._settings.carrying.near_m
            ),
            lost=frozenset(self._hands) - set(frame.palms),
        )

    def _slip(self, seen: list[Seen], hand: tuple[str, str], index: int) -> float | None:
        places = [
            (each.time_s, each.pose.to_local(each.palms[hand]))
            for each in (seen[at] for at in _window([each.time_s for each in seen], index))
            if each.pose is not None and hand in each.palms
        ]
        slip = velocity([time_s for time_s, _ in places], [place for _, place in places]) if places else None
        return None if slip is None else float(np.linalg.norm(slip))


def _middle(stage: Stage, name: str) -> Array:
    at_first = stage.show(stage.scene.initial)
    local = at_first.body(stage.scene.object_body(name)).to_local(object_points(at_first, name, POINT_SPACING_M))
    return np.asarray(local.mean(axis=0))


def _window(times_s: Sequence[float], index: int) -> list[int]:
    """Frames within a tenth of a second, and the neighbours."""
    near = [at for at, time_s in enumerate(times_s) if abs(time_s - times_s[index]) <= 0.1 + ROUNDING_S]
    return sorted({*near, *(at for at in (index - 1, index + 1) if 0 <= at < len(times_s))})


def _around(places: Sequence[Array | None], window: Sequence[int], index: int) -> list[int]:
    """Those frames of the window between which nothing was lost."""
    return [
        at for at in window if all(places[between] is not None for between in range(min(at, index), max(at, index) + 1))
    ]


def _velocity(times_s: Sequence[float], places: Sequence[Array | None], index: int) -> Array | None:
    frames = _around(places, _window(times_s, index), index)
    return velocity([times_s[at] for at in frames], np.array([places[at] for at in frames])) if frames else None


def _falls(times_s: Sequence[float], places: Sequence[Array | None], index: int) -> bool:
    frames = _around(places, _window(times_s, index), index)
    if len(frames) < 4:
        return False
    since_s = np.array([times_s[at] for at in frames]) - times_s[index]
    bends = np.polyfit(since_s, np.array([places[at] for at in frames]), 2)[0]
    return bool(np.linalg.norm(2 * bends - np.array([0.0, 0.0, -9.81])) < 3.0)


class Watching:
    """Watches states as they come; asked at any time, it says what an ``Observer`` says."""

    def __init__(self, scene: Scene, settings: Settings = DEFAULT) -> None:
        self.scene, self._settings, self._stage = scene, settings, Stage(scene)
        minimum_s = settings.timing.minimum_s
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
        self._states, self._times_s = list[State](), list[float]()

    @classmethod
    def of(cls, scene: Scene, states: Iterable[State], settings: Settings = DEFAULT) -> Watching:
        """One that has seen all of these states, and knows that no more will come."""
        watching, states = cls(scene, settings), list(states)
        watching._states, watching._times_s = states, [state.time_s for state in states]
        carriers = {name: HoldingWatch(scene, name, settings).decided(states) for name in scene.objects}
        for index, state in enumerate(states):
            watching._take(state, {name: found[index] for name, found in carriers.items()})
        for name, watch in watching._watches.items():
            for at_s, motion in watch.finish():
                watching._motions[name].update(at_s, motion)
        return watching

    def _take(self, state: State, carriers: dict[str, Carrier]) -> None:
        stage, contact, time_s = self._stage.show(state), self._settings.contact, state.time_s
        held = {name: holding_by(stage, name, carrier, contact) for name, carrier in carriers.items()}
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

    def as_confirmed(self, state: State, gaze_of: str | None = None) -> State:  # noqa: ARG002 - of all, the slow way
        eyes = dict(state.eyes)
        for name in self.scene.agents:
            if name in eyes or not self._settings.gaze.inferred or not state.known([f"{name}/head"]):
                continue
            thing = self._regarded(name, state.time_s)
            if thing is not None and state.known([thing]):
                stage = self._stage.show(state)
                middle = stage.geom_centers(self.scene.seen_geoms(thing)).mean(axis=0)
                ahead = stage.site(self.scene.agent(name).eye_site)
                eyes[name] = turned_towards(ahead, middle, thing, self._settings.gaze.range_rad)
        return state.with_holding(self.holds(state.time_s)).with_eyes(eyes)

    def _regarded(self, name: str, time_s: float) -> str | None:
        """Of all that the agent's hands ever have, what is had now or half a second later and began nearest to now."""
        now_s = max((each for each in self._times_s if each <= time_s + ROUNDING_S), default=-np.inf)
        spans = [span for side in self.scene.agent(name).sides for span in self._spans[name, side]]
        near = [(abs(now_s - a), -a, thing) for thing, a, b in spans if a - 0.5 - ROUNDING_S <= now_s <= b + ROUNDING_S]
        return min(near)[2] if near else None

    @cached_property
    def _spans(self) -> dict[tuple[str, str], list[tuple[str, float, float]]]:
        """What each hand has, one after the other: the thing, from when to when."""
        found: dict[tuple[str, str], list[tuple[str, float, float]]] = {}
        for hand in self._hands:
            spans, before = found.setdefault(hand, []), None
            for state in self._states:
                thing = self._handled(hand, state)
                if thing is not None:
                    start_s = spans.pop()[1] if thing == before else state.time_s
                    spans.append((thing, start_s, state.time_s))
                before = thing
        return found

    def _handled(self, hand: tuple[str, str], state: State) -> str | None:
        status = self._hands[hand].at(state.time_s)
        if status is None or status.symbol is None or status.symbol == v.HOLDING_OBJECT:
            return status.thing if status and status.symbol else None
        arm, stage = self.scene.agent(hand[0]).arm(hand[1]), self._stage.show(state)
        for name in sorted(self.scene.objects):
            gap_m = stage.closest(arm.hand_geoms, self.scene.solid_geoms_of(name), limit_m=1.0)[0]
            if gap_m < self._settings.contact.grip_m and self._motions[name].at(state.time_s) == v.MOVING:
                return name
        return None


def holding_by(stage: Stage, name: str, carrier: Carrier, settings: Contact) -> Holding | None:
    """What the carrier of a thing in a state says of who holds it."""
    scene, state = stage.scene, stage.state
    if not state.known([name]):
        return None
    if carrier is NoHand.SUPPORT:
        rest = rest_of(stage, name, settings)
        return Holding((), rest.support, rest.container, complete=True)
    hands = [(who, arm.profile.side) for who in scene.agents for arm in scene.agent(who).arms]
    known = [hand for hand in hands if hand_known(stage, scene.agent(hand[0]), scene.agent(hand[0]).arm(hand[1]))]
    if isinstance(carrier, frozenset):
        holding = tuple(hand for hand in known if hand in carrier)
        return Holding(holding, None, None, complete=bool(holding))
    all_known = known == hands and state.known(scene.objects)
    return Holding((), None, None, complete=carrier is NoHand.NOBODY and all_known)


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
