"""Actions: what was done between the initial and the final state, as symbols with times (A of ⟨WI, A, WF⟩, 10).

What the observer has confirmed of hands, placements and motion tells what somebody did; the geometry of single frames
tells when it began. An example, a cup that is handed over::

    P1  reach ─────┤
                   │ grasp
                   ├─ lift ─┤
                   ├──────── carry ────────┤ hand over (to P2) ├ release
    P2                          reach ─────┤ grasp             ├───── carry ...

- **grasp**: a hand comes to a thing that it has afterwards. A thing that rests on a support is held by nobody; so the
  grasp is looked for backwards, from the moment at which it is held to that at which the hand came to it.
- **reach**: the hand's way to the grasp, from where it set out.
- **lift**: the thing leaves what it rested on, until it rises no more.
- **carry**: it travels while an agent has it, from its first motion to its last.
- **place**: it comes to rest; on or in what is told. **release**: the hand that had it has come off it.
- **hand over**: it goes from one agent's hands into those of another; while both have it.
- **point**: an empty hand stays stretched out towards a thing that it is not near.
- **look**: an agent looks at a thing, or at another agent.

An action that cannot be told from what was tracked is not there; nothing says that it was not done.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.workers import Progress, silent
from taskgist.facts import vocabulary as v
from taskgist.observe.attention import gaze
from taskgist.observe.observer import Observer
from taskgist.recognition.turns import RESTING, Change, Grip, Turn, changes_of_hands, grips_of, turns_of
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import hand_gap_m, hand_known
from taskgist.world.stage import Stage

ActionKind = Literal["reach", "grasp", "lift", "carry", "place", "release", "hand over", "point", "look"]
KINDS: tuple[ActionKind, ...] = ("look", "point", "reach", "grasp", "lift", "carry", "place", "hand over", "release")
"""In the order in which those of one moment are told."""

STILL_M_S = 0.05
"""A hand that is slower has not set out yet."""
LONGEST_REACH_S, AT_IT_M = 6.0, 0.05
"""Longer ago a hand does not set out for what it grasps; and it has come, when it gets no nearer than this any more."""
RISING_M_S, FAINT_M_S, LIFTED_M = 0.05, 0.02, 0.03
"""A thing is lifted while it rises faster than this, from when on it faintly moves, and if it has risen so far."""
CARRIED_M = 0.05
"""What travels less in somebody's hands is not carried."""
LOOK_EVERY_S, LEAST_LOOK_S = 0.2, 0.4
"""How often it is looked where eyes look, and what a look lasts at least."""
OFF_POINT_RAD, STRETCHED, RAISED, LEAST_POINT_S, FAR_OFF_M = math.radians(10.0), 0.85, 0.7, 0.4, 0.15
"""A pointing arm is off the line to the thing by no more, is stretched by this share of its length at least, hangs by
no more than this share of it, stays so for so long, and its hand is farther from all things than this."""
ROUNDING_S = 1e-6


@dataclass(frozen=True)
class Action:
    """One thing that an agent did.

    Attributes:
        kind: What.
        agent: Who.
        thing: With what object; of a look, what it is at: an object or another agent.
        start_s: When it began, seconds.
        end_s: When it was over; the same, where it is a moment.
        side: With which hand; None where it is done with the eyes, or with whichever hands.
        to: Onto or into what it is placed, or to whom it is handed over; None elsewhere, and where it is not known.
    """

    kind: ActionKind
    agent: str
    thing: str
    start_s: float
    end_s: float
    side: str | None = None
    to: str | None = None

    @property
    def order(self) -> tuple[float, int, float, str, str, str]:
        """Sort key: by its begin."""
        return (self.start_s, KINDS.index(self.kind), self.end_s, self.agent, self.thing, self.side or "")

    def __str__(self) -> str:
        hand = f" with the {self.side} hand" if self.side else ""
        where = {"hand over": " to", "place": " at"}.get(self.kind, "")
        done = {"look": "look at", "point": "point at"}.get(self.kind, self.kind)
        return f"{self.agent}: {done} {self.thing}{f'{where} {self.to}' if self.to else ''}{hand}"


def actions_of(
    recording: Recording,
    observer: Observer,
    *,
    names: Iterable[str] | None = None,
    looks: bool = True,
    settings: Settings = DEFAULT,
    progress: Progress = silent,
) -> tuple[Action, ...]:
    """What agents did in a recording, by the time at which it began.

    Args:
        recording: A recording.
        observer: One of this recording.
        names: With which objects; None: with all.
        looks: Whether looks are among them; they cost most.
        settings: Distances and speeds.
        progress: Told how far it is.

    Raises:
        UnknownNameError: There is no such object.
    """
    things = tuple(recording.scene.objects) if names is None else tuple(names)
    found: list[Action] = []
    film = _Film(recording, settings)
    for number, name in enumerate(things):
        progress(f"what was done with {name}", number / (len(things) + looks))
        found += _handled(film, observer, name)
    found += _pointed(film, observer, things)
    if looks:
        progress("where eyes looked", len(things) / (len(things) + 1))
        found += [each for each in _looks(recording, observer, settings) if names is None or each.thing in things]
    progress("done", 1.0)
    return tuple(sorted(found, key=lambda each: each.order))


class _Film:
    """Places of hands and things in all frames, each looked up once."""

    def __init__(self, recording: Recording, settings: Settings) -> None:
        self.recording, self.scene, self.settings = recording, recording.scene, settings
        self.times_s = recording.times_s
        self._stage = Stage(recording.scene)
        hands = [(agent, side) for agent in self.scene.agents for side in self.scene.agent(agent).sides]
        self.palms = {hand: np.full((len(recording), 3), np.nan) for hand in hands}
        self.turns = {hand: np.full((len(recording), 3, 3), np.nan) for hand in hands}
        self.shoulders = {hand: np.full((len(recording), 3), np.nan) for hand in hands}
        self.middles = {name: np.full((len(recording), 3), np.nan) for name in self.scene.objects}
        for index in range(len(recording)):
            stage = self.show(index)
            for agent, side in hands:
                body = self.scene.agent(agent)
                arm = body.arm(side)
                if hand_known(stage, body, arm):
                    palm = stage.site(arm.palm_site)
                    self.palms[agent, side][index], self.turns[agent, side][index] = palm.position, palm.matrix
                    self.shoulders[agent, side][index] = stage.shoulder(arm).position
            for name, middles in self.middles.items():
                if stage.state.known([name]):
                    middles[index] = stage.body_position(self.scene.object_body(name))

    def show(self, index: int) -> Stage:
        return self._stage.show(self.recording.state(index))

    @cached_property
    def half_window(self) -> int:
        """Frames before and behind one that tell how fast something moves in it."""
        period_s = float(np.median(np.diff(self.times_s))) if len(self.times_s) > 1 else 1.0
        return max(1, round(self.settings.timing.motion_window_s / 2 / period_s))

    def velocities_m_s(self, places: Array) -> Array:
        """Velocities over the window in which motion is measured, (n, 3); NaN where a place is not known."""
        last = len(self.times_s) - 1
        shifts = (-self.half_window, self.half_window)
        before, after = (np.clip(np.arange(last + 1) + shift, 0, last) for shift in shifts)
        spans_s = np.maximum(self.times_s[after] - self.times_s[before], 1e-9)
        return np.asarray((places[after] - places[before]) / spans_s[:, None])

    def stays(self, hand: tuple[str, str], name: str) -> Callable[[int], bool]:
        """Tells whether a hand is at a thing in a frame: near it, and not on its way to it or from it."""
        agent, side = hand
        arm, grip_m = self.scene.agent(agent).arm(side), self.settings.contact.grip_m
        ways = self.middles[name] - self.palms[hand]
        in_hand = np.einsum("nji,nj->ni", self.turns[hand], ways)  # where the thing is, seen from the hand
        apart_m_s = np.linalg.norm(self.velocities_m_s(in_hand), axis=1)

        def at_it(index: int) -> bool:
            near = apart_m_s[index] < STILL_M_S  # false where it is not known
            return bool(near) and hand_gap_m(self.show(index), arm, name, limit_m=grip_m) < grip_m

        return at_it

    def index_at(self, time_s: float) -> int:
        return self.recording.index_at(time_s)


# --- What is done with one thing, turn by turn.


def _handled(film: _Film, observer: Observer, name: str) -> Iterator[Action]:
    """All that was done by hand with a thing."""
    grips, turns = grips_of(observer, name), turns_of(observer, name)
    changes = changes_of_hands(observer, name, turns)
    for turn in turns:
        own = [each for each in grips if each.agent == turn.agent and _overlaps(each, turn)]
        if not own:
            continue
        taken = next((each for each in changes if (each.taker, each.taken_s) == (turn.agent, turn.start_s)), None)
        given = next((each for each in changes if (each.giver, each.released_s) == (turn.agent, turn.end_s)), None)
        first, last = own[0], max(own, key=lambda each: each.end_s)
        lifted = None if taken else _lifted(film, observer, name, first)
        yield from _taken(film, observer, name, first, until_s=lifted.start_s if lifted else first.start_s)
        if lifted:
            yield lifted
        yield from _carried(film, observer, name, turn, until_s=given.taken_s if given else turn.end_s)
        yield from _given(name, given, last) if given else _placed(film, observer, name, last)


def _overlaps(grip: Grip, turn: Turn) -> bool:
    return grip.start_s < turn.end_s and grip.end_s > turn.start_s


def _taken(film: _Film, observer: Observer, name: str, grip: Grip, *, until_s: float) -> Iterator[Action]:
    """The grasp and the reach before it; neither, if the hand had the thing from the first frame on.

    Args:
        film: Where all is.
        observer: One of the recording.
        name: The thing.
        grip: The grip that they lead to.
        until_s: When the hand has closed at the latest, seconds.
    """
    hand, index = (grip.agent, grip.side), film.index_at(until_s)
    holds = (each for each in observer.hand(*hand).intervals if each.value.symbol == v.HOLDING_OBJECT)
    before_s = max((each.end_s for each in holds if each.end_s <= grip.start_s), default=-math.inf)
    stays = film.stays(hand, name)
    while index > 0 and film.times_s[index - 1] > before_s and stays(index - 1):
        index -= 1
    if index == 0:
        return
    grasp_s = float(film.times_s[index])
    yield Action("grasp", grip.agent, name, grasp_s, grasp_s, grip.side)
    away_m = np.linalg.norm(film.palms[hand] - film.middles[name], axis=1)
    moves = np.linalg.norm(film.velocities_m_s(film.palms[hand]), axis=1) > STILL_M_S
    first_s, last = max(before_s, grasp_s - LONGEST_REACH_S), index
    while index > 0 and film.times_s[index] > first_s and away_m[index] < away_m[last] + AT_IT_M:
        index -= 1  # it may have waited there, and trembled
    while index > 0 and film.times_s[index] > first_s and moves[index]:
        index -= 1
    if np.nanmax(away_m[index : last + 1]) > away_m[last] + AT_IT_M:
        yield Action("reach", grip.agent, name, float(film.times_s[index]), grasp_s, grip.side)


def _lifted(film: _Film, observer: Observer, name: str, grip: Grip) -> Action | None:
    """The thing's leaving of what it rested on: while it rises, slowly at first; None where it does not."""
    minimum_s = film.settings.timing.minimum_s
    rested = [
        each.end_s
        for each in observer.placement(name).intervals
        if each.value.symbol in RESTING and each.start_s < grip.start_s and abs(each.end_s - grip.start_s) <= minimum_s
    ]
    if not rested:
        return None
    heights_m = film.middles[name][:, 2]
    rising_m_s = film.velocities_m_s(film.middles[name])[:, 2]
    first = last = film.index_at(max(rested))
    while first > 0 and rising_m_s[first] > FAINT_M_S:
        first -= 1
    latest = film.index_at(min(grip.end_s, float(film.times_s[-1])))
    while last < latest and (rising_m_s[last] > RISING_M_S or film.times_s[last] - max(rested) < minimum_s):
        last += 1
    if not heights_m[last] - heights_m[first] >= LIFTED_M:
        return None
    return Action("lift", grip.agent, name, float(film.times_s[first]), float(film.times_s[last]), grip.side)


def _carried(film: _Film, observer: Observer, name: str, turn: Turn, *, until_s: float) -> Iterator[Action]:
    """The thing's travel while an agent has it."""
    moving = [
        (max(each.start_s, turn.start_s), min(each.end_s, until_s))
        for each in observer.motion(name).intervals
        if each.value == v.MOVING and each.start_s < until_s and each.end_s > turn.start_s
    ]
    if not moving:
        return
    first_s, last_s = moving[0][0], moving[-1][1]
    way = film.middles[name][film.index_at(first_s) : film.index_at(min(last_s, float(film.times_s[-1]))) + 1]
    if np.nanmax(np.linalg.norm(way - way[:1], axis=1), initial=0.0) >= CARRIED_M:
        yield Action("carry", turn.agent, name, first_s, last_s)


def _given(name: str, change: Change, last: Grip) -> Iterator[Action]:
    """The handing over, and the giver's letting go."""
    end_s = max(change.released_s, change.taken_s)
    yield Action("hand over", change.giver, name, change.taken_s, end_s, last.side, to=change.taker)
    yield Action("release", change.giver, name, last.end_s, last.end_s, last.side)


def _placed(film: _Film, observer: Observer, name: str, last: Grip) -> Iterator[Action]:
    """The thing's coming to rest out of a hand, and the hand's coming off it; neither, where it is held to the end."""
    final_s = float(film.times_s[-1])
    if last.end_s >= final_s:
        return
    minimum_s, index = film.settings.timing.minimum_s, film.index_at(last.end_s)
    stays, moves_m_s = film.stays((last.agent, last.side), name), film.velocities_m_s(film.middles[name])
    for each in observer.placement(name).intervals:
        if each.value.symbol in RESTING and abs(each.start_s - last.end_s) <= minimum_s:
            index = film.index_at(each.start_s)
            while index < len(film.times_s) - 1 and np.linalg.norm(moves_m_s[index]) > FAINT_M_S:
                index += 1  # it is lowered slowly at the end
            placed_s, to = float(film.times_s[index]), each.value.by[0] if each.value.by else None
            yield Action("place", last.agent, name, placed_s, placed_s, last.side, to=to)
            break
    while index < len(film.times_s) - 1 and stays(index):
        index += 1
    if index < len(film.times_s) - 1:  # else the hand stays at it
        released_s = float(film.times_s[index])
        yield Action("release", last.agent, name, released_s, released_s, last.side)


# --- What is done from afar: pointing and looking.


def _pointed(film: _Film, observer: Observer, names: Sequence[str]) -> Iterator[Action]:
    """Arms that stay stretched out towards things."""
    for (agent, side), palms in film.palms.items():
        arm, shoulders = film.scene.agent(agent).arm(side), film.shoulders[agent, side]
        ways, slow = palms - shoulders, np.linalg.norm(film.velocities_m_s(palms), axis=1) < STILL_M_S
        lengths_m = np.linalg.norm(ways, axis=1)
        raised = (lengths_m > STRETCHED * arm.profile.length_m) & (ways[:, 2] > -RAISED * lengths_m) & slow
        for index in np.flatnonzero(raised):
            status = observer.hand(agent, side).at(float(film.times_s[index]))
            raised[index] = status is not None and status.symbol == v.FREE_OF_OBJECT
        towards = [_pointed_at(film, ways[i], palms[i], names, i) if raised[i] else None for i in range(len(raised))]
        for thing, start_s, end_s in _lasting(film.times_s, towards, LEAST_POINT_S):
            yield Action("point", agent, thing, start_s, end_s, side)


def _pointed_at(film: _Film, way: Array, palm: Array, names: Sequence[str], index: int) -> str | None:
    """The thing that an arm points at: the one nearest to its line; None where there is none."""
    rests = {name: film.middles[name][index] - palm for name in film.middles}
    if any(np.linalg.norm(rest) < FAR_OFF_M for rest in rests.values()):
        return None  # it is there to take it, or has just put it down
    best, least_rad = None, OFF_POINT_RAD
    for name in names:
        rest, far_m = rests[name], float(np.linalg.norm(rests[name]))
        if not math.isnan(far_m):
            off_rad = math.acos(min(1.0, float(rest @ way) / (far_m * float(np.linalg.norm(way)))))
            if off_rad < least_rad:
                best, least_rad = name, off_rad
    return best


def _looks(recording: Recording, observer: Observer, settings: Settings) -> Iterator[Action]:
    """Looks of all agents at things and at each other."""
    stage, first_s = Stage(recording.scene), float(recording.times_s[0])
    times_s = [first_s + LOOK_EVERY_S * number for number in range(int(recording.duration_s / LOOK_EVERY_S) + 1)]
    for agent in recording.scene.agents:
        targets: list[str | None] = []
        for time_s in times_s:
            look = gaze(stage.show(observer.as_confirmed(recording.at(time_s), agent)), agent, settings)
            targets.append(look.target if look else None)
        for thing, start_s, end_s in _lasting(times_s, targets, LEAST_LOOK_S):
            yield Action("look", agent, thing, start_s, end_s)


def _lasting(
    times_s: Sequence[float] | Array, values: Sequence[str | None], least_s: float
) -> Iterator[tuple[str, float, float]]:
    """The stretches in which a value lasts: the value, and from when to when it was seen."""
    first = 0
    for index in range(1, len(values) + 1):
        if index == len(values) or values[index] != values[first]:
            value, start_s, end_s = values[first], float(times_s[first]), float(times_s[index - 1])
            if value is not None and end_s - start_s >= least_s - ROUNDING_S:
                yield value, start_s, end_s
            first = index
