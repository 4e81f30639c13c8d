"""Where eyes look: what is assumed of the gaze of people whose recording tells of their heads only.

Trackers give heads. Heads turn less than the gaze, and who takes a thing looks down at it with the eyes alone: by its
head, the receiver of a handover sees past what it takes. What eyes do while hands work is well known: they are at the
thing about half a second before a hand is, stay with it while it is handled, and go on to the next one before that is
taken [Land et al. 1999]. So three things are assumed, and nothing else:

- While nothing speaks against it, eyes look where the head does.
- From half a second before a hand takes a thing, and as long as it holds or moves it, the eyes of that person turn
  towards the thing, as far as eyes do (``gaze.range_rad``); the head stays as it was recorded.
- Of several things it is the one whose taking is nearest in time, be it past or to come.

An example: P1 holds a tray all the time, takes the cup at 3 s and puts it down at 5 s::

    time, s      0 ... 2.5 ... 3 ... 5 ...
    eyes at      tray  cup     cup   tray

A gaze that was recorded (``Recording.state`` and ``State.eyes``) is never touched.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.frames import KEPT_FRAMES, ROUNDING_S, FrameSequence
from taskgist.settings import Gaze
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage
from taskgist.world.state import EyeTurn, State

NO_SIDE = 1e-9
"""A thing so exactly behind the head, as a share of its distance, is on neither side of it."""


@dataclass(frozen=True)
class Use:
    """A hand takes a thing, and holds it or works on it.

    Attributes:
        thing: The thing.
        start_s: When the hand takes it, seconds.
        end_s: Until when it is known to have it.
    """

    thing: str
    start_s: float
    end_s: float


def regarded(time_s: float, uses: Iterable[Use], settings: Gaze) -> str | None:
    """The thing that a person's eyes are at: of those that its hands have, or are about to have, the nearest in time.

    Args:
        time_s: When, seconds.
        uses: What its hands do.
        settings: How long before a hand the eyes are at a thing.

    Returns:
        None where the hands have nothing to do with any thing. Of two that were taken equally long ago, or will be,
        the later one is taken, and of two that are taken at once the first by name: hands say no more.
    """
    reach_s = settings.before_s + ROUNDING_S
    near = [use for use in uses if use.start_s - reach_s <= time_s <= use.end_s + ROUNDING_S]
    first = min(near, key=lambda use: (abs(time_s - use.start_s), -use.start_s, use.thing), default=None)
    return None if first is None else first.thing


def turned_towards(ahead: Pose, point: Array, thing: str, range_rad: float) -> EyeTurn:
    """The turn of eyes that look at a point, or as far towards it as they turn.

    Args:
        ahead: The eye as it looks where the head does: x forward, y left, z up.
        point: Where they turn to, metres in the world, (3,).
        thing: What is there.
        range_rad: How far they turn at most, radians.
    """
    x, y, z = ahead.to_local(point).tolist()
    aside = math.hypot(y, z)
    if aside <= NO_SIDE * abs(x):
        return EyeTurn(towards=thing)
    turn_rad = min(math.atan2(aside, x), range_rad)
    return EyeTurn(turn_rad * y / aside, turn_rad * z / aside, thing)


Hand = tuple[str, str]
"""Agent and side."""


class Eyes:
    """Infers where eyes look, from what hands do in the settled frames of a sequence.

    Args:
        stage: The scene; it shows other states after each question.
        frames: The frames; live, one is settled once it is known what hands do ``before_s`` later.
        handled: Gives what a hand holds or works on in a settled frame, by its index; None: nothing that is known.
        settings: What is assumed.
    """

    def __init__(
        self,
        stage: Stage,
        frames: FrameSequence,
        handled: Callable[[Hand, int], str | None],
        settings: Gaze,
    ) -> None:
        self._stage, self._frames, self._settings = stage, frames, settings
        self._thing = lru_cache(4 * KEPT_FRAMES)(handled)
        self._starts: dict[tuple[Hand, int], int] = {}

    def turns(self, state: State, agents: Iterable[str]) -> Mapping[str, EyeTurn]:
        """How eyes are turned in a state, by agent: as recorded where they were, else as inferred for some agents.

        Agents of which nothing is known or assumed are left out, and those whose head, or thing, was not tracked.
        """
        if not self._settings.inferred:
            return state.eyes
        found = dict(state.eyes)
        for name in agents:
            if name not in found and (turn := self._turn(self._stage.scene.agent(name), state)) is not None:
                found[name] = turn
        return found

    def _turn(self, agent: Agent, state: State) -> EyeTurn | None:
        own_rad = agent.profile.eye.turn_rad
        range_rad = self._settings.range_rad if own_rad is None else own_rad
        if range_rad == 0.0 or not state.known([f"{agent.name}/head"]):
            return None
        thing = self.regarded(agent, state.time_s)
        if thing is None or not state.known([thing]):
            return None
        stage = self._stage.show(state)
        middle = np.asarray(stage.geom_centers(stage.scene.seen_geoms(thing)).mean(axis=0))
        return turned_towards(stage.eye_ahead(agent), middle, thing, range_rad)

    def regarded(self, agent: Agent, time_s: float) -> str | None:
        """The thing that an agent's hands draw its eyes to at a time, as far as that is settled."""
        index = self._frames.index_at(time_s)
        if index < 0:
            return None
        uses = [use for side in agent.sides for use in self._uses((agent.name, side), index)]
        return regarded(self._frames.times_s[index], uses, self._settings)

    def _uses(self, hand: Hand, index: int) -> list[Use]:
        """What a hand has in a frame, and what it takes soon after."""
        times_s, found = self._frames.times_s, list[Use]()
        until_s = times_s[index] + self._settings.before_s + ROUNDING_S
        each, before = index, None
        while each < len(times_s) and times_s[each] <= until_s:
            thing = self._thing(hand, each)
            if thing is not None and thing != before:
                start_s = times_s[self._start(hand, each) if each == index else each]
                found.append(Use(thing, start_s, times_s[each]))
            each, before = each + 1, thing
        return found

    def _start(self, hand: Hand, index: int) -> int:
        """The frame in which a hand took what it has in another."""
        thing, first = self._thing(hand, index), index
        while first > 0 and (hand, first) not in self._starts and self._thing(hand, first - 1) == thing:
            first -= 1
        first = self._starts.get((hand, first), first)
        if len(self._starts) >= KEPT_FRAMES:
            del self._starts[next(iter(self._starts))]
        self._starts[hand, index] = first
        return first
