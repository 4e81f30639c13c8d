"""Episodes of a recording without a label: each time that a thing is handled, by whom, perhaps for whom, from when on.

A day in a living room is one recording, in which many things are taken, carried, shown, given and put down. Each of
these is a *handling*: what a label would name, but for the task. It is found from who has the thing when
(``turns``), from when it moves, and from what it rests on::

    P1 has the cup      ──────────────┐                          ────────────
    P2 has the cup                 ─────────────────┐
    the cup moves       ────    ──────  ────────────┐            ──    ──────
    handlings           [1: pause ]
                        [2: changes hands]
                                     [3: rests      ]            [4 pause]
                                                                 [5: rests  ]

- A handling starts a little before the thing leaves what it rests on, or is pushed; a taker's starts where the thing
  changes hands. It ends when the thing changes hands, or has come to rest, as proposed labels do (``courses``).
- Who holds a thing still for a while, and moves it on, may have shown it: that is a handling of its own, with the same
  start (1, 4). What is offered, and then taken, is one handling (2): no pause before a change of hands counts.
- What nobody holds and moves is *pushed* by whose hand is at it. What moves in or on another thing goes along with
  that one. Where hands are not tracked it is unknown who did it: ``performing_agent`` is None.
- For whom it is done nobody knows before it is recognised: each other agent may be meant. Who takes it is named first,
  then who looks at it, or is looked at.

What is not done: two hands of two agents that carry a table together are one agent's; a thing whose state is changed
without being moved (a lamp switched on) is not found.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from taskgist.observe.attention import gaze
from taskgist.observe.frames import ROUNDING_S
from taskgist.observe.observer import Observer
from taskgist.observe.under_way import nearest_hand_m
from taskgist.recognition.courses import (
    BEFORE_S,
    LOOKS,
    UNENDED,
    UNSEEN,
    Course,
    Doubt,
    Ends,
    Span,
    change_of,
    courses_of,
    ends_of,
    rest_of,
    unclear,
    unseen,
)
from taskgist.recognition.turns import Change, Turn, resting, rests_between
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

REGRASPED_S = 0.5
"""Who lets go of a thing, and has it again so soon, has not done with it; so it is with what is pushed again."""
PAUSE_S = 0.6
"""Held still for so long, a thing may have been shown."""
AWAY_M = 0.05
"""So far from where it was, or turned so that it moved for as long as a pause lasts: before that it is only grasped."""
PUSHED_M = 0.02
"""Who pushes a thing less far has not moved it."""
PAUSED = 0.5
"""Confidence in an episode that ends while the thing is held still, and goes on."""
GLANCES = 6
"""In as many frames of a handling it is looked who looks at what."""
UNNAMED = "unnamed"
"""The task of a label of which nobody has said yet what was done."""
Ending = Literal["rests", "changes hands", "held still", "recording ends"]


@dataclass(frozen=True)
class Handling:
    """One time that a thing is handled: a candidate for a label.

    Attributes:
        thing: The thing.
        performing_agent: Who handles it; None: nobody knows.
        target_agents: For whom it may be: the others, the likeliest first.
        taker: Who takes it in the end from the performing agent's hands.
        start_s: When it starts, seconds.
        end_s: When it ends.
        ending: With what it ends.
        along: Things that go along in or on this one.
        confidence: From 0 to 1: that of the greatest doubt.
        reason: What that is, in one clause; empty if there is none.
        how: How start and end were found.
    """

    thing: str
    performing_agent: str | None
    target_agents: tuple[str, ...]
    taker: str | None
    start_s: float
    end_s: float
    ending: Ending
    along: tuple[str, ...]
    confidence: float
    reason: str
    how: str

    def label(self, target_agent: str | None = None, thing: str | None = None, task: str = UNNAMED) -> Label:
        """A label of it.

        Args:
            target_agent: For whom; None: for nobody else.
            thing: What it was about, if that is another thing than the one that was moved.
            task: What it is called.

        Raises:
            LabelError: It is not known who did it.
        """
        targets = (target_agent,) if target_agent else ()
        return Label(
            task, self.performing_agent or "", targets, thing or self.thing, self.start_s, self.end_s, self.how
        )


def handlings_of(
    recording: Recording,
    observer: Observer,
    *,
    things: Iterable[str] | None = None,
    settings: Settings = DEFAULT,
) -> tuple[Handling, ...]:
    """Each time that a thing is handled, in order of time; it takes a time that grows as the recording is long.

    Args:
        recording: The recording.
        observer: One of it.
        things: Which things; by default all.
        settings: What counts as held, as moving.

    Raises:
        UnknownNameError: There is no such thing.
    """
    courses = courses_of(observer, things)
    finder = _Finder(recording, settings, courses)
    found = [handling for course in courses.values() for handling in finder.of(course)]
    found = _with_what_goes_along(found, finder.along)
    return tuple(sorted(found, key=lambda each: (each.start_s, each.end_s, each.thing)))


def _with_what_goes_along(found: list[Handling], along: Sequence[tuple[str, str, float]]) -> list[Handling]:
    """The handlings, each told what goes along with its thing.

    Args:
        found: All handlings.
        along: What goes along in or on what at a time, in order of time.
    """
    by_carrier: dict[str, list[tuple[float, str]]] = {}
    for thing, carrier, time_s in along:
        by_carrier.setdefault(carrier, []).append((time_s, thing))
    told = []
    for each in found:
        times = sorted(by_carrier.get(each.thing, ()))
        first, last = (bisect_left(times, (time_s, "")) for time_s in (each.start_s, each.end_s))
        told.append(replace(each, along=tuple(sorted({thing for _, thing in times[first:last]}))))
    return told


@dataclass(frozen=True)
class _Stretch:
    """An agent has a thing, or a thing is moved that nobody has."""

    agent: str | None
    start_s: float
    end_s: float
    turn: Turn | None = None
    taken: Change | None = None
    given: Change | None = None


class _Finder:
    """Finds the handlings of one thing after the other.

    Args:
        recording: The recording.
        settings: What counts.
        courses: Those of all things that are looked at.

    Attributes:
        along: What went along in or on what, and a time of it.
    """

    def __init__(self, recording: Recording, settings: Settings, courses: dict[str, Course]) -> None:
        self._recording, self._settings, self._courses = recording, settings, courses
        self._stage = Stage(recording.scene)
        self.along: list[tuple[str, str, float]] = []

    def of(self, course: Course) -> list[Handling]:
        """The handlings of a thing."""
        held = _held(course)
        stretches = sorted([*held, *self._pushed(course, held)], key=lambda each: each.start_s)
        found = []
        for number, stretch in enumerate(stretches):
            from_s = stretches[number - 1].end_s if number else -math.inf
            until_s = stretches[number + 1].start_s if number + 1 < len(stretches) else math.inf
            found += self._handlings(course.part((from_s, until_s)), stretch, (from_s, until_s))
        return found

    # --- Who has it, or pushes it, from when to when.

    def _pushed(self, course: Course, held: Sequence[_Stretch]) -> list[_Stretch]:
        """When it moves and nobody has it: what slides, rolls or is tipped over."""
        loose = list[_Stretch]()
        starts = [each.start_s for each in held]
        for moving in course.moving:
            before = bisect_left(starts, moving.end_s + REGRASPED_S)
            if before and held[before - 1].end_s > moving.start_s - REGRASPED_S:
                continue  # it is taken, or was just let go
            if loose and moving.start_s - loose[-1].end_s < REGRASPED_S:
                loose[-1] = replace(loose[-1], end_s=moving.end_s)
            else:
                loose.append(_Stretch(None, moving.start_s, moving.end_s))
        found = []
        for each in loose:
            carrier = self._carrier(course.part((each.start_s, each.end_s)), each)
            if carrier is not None:
                self.along.append((course.name, carrier, (each.start_s + each.end_s) / 2))
                continue
            agent = self._toucher(course.name, each)
            if self._way_m(course.name, (each.start_s, each.end_s)) >= PUSHED_M or agent is not None:
                found.append(replace(each, agent=agent))
        return found

    def _carrier(self, course: Course, stretch: _Stretch) -> str | None:
        """The thing in or on which it moves; None where that does not move."""
        for placement in course.placements:
            for carrier in placement.value.by:
                other = self._courses.get(carrier)
                if other and other.part((stretch.start_s, stretch.end_s)).moving:
                    return carrier
        return None

    def _toucher(self, name: str, stretch: _Stretch) -> str | None:
        """Whose hand is at it in most frames in which somebody's is."""
        touched: dict[str, int] = {}
        for index in self._frames(stretch.start_s, stretch.end_s, LOOKS):
            stage = self._stage.show(self._recording.state(index))
            gaps = {agent: nearest_hand_m(stage, agent, name) for agent in stage.scene.agents}
            near = {
                agent: gap for agent, gap in gaps.items() if gap is not None and gap < self._settings.contact.grip_m
            }
            if near:
                agent = min(near, key=lambda each: near[each])
                touched[agent] = touched.get(agent, 0) + 1
        return max(touched, key=lambda agent: touched[agent], default=None)

    # --- What of that is a handling.

    def _handlings(self, course: Course, stretch: _Stretch, span: Span) -> list[Handling]:
        """Those of one stretch: until each pause, and until the end."""
        turns = (stretch.turn,) if stretch.turn else ()
        ends = self._ends(course, stretch, span)
        whole, doubts = (ends.start_s, ends.end_s), [*ends.late, *ends.doubts, *unseen(course, turns)]
        found = []
        for pause_s in self._pauses(course, stretch, *whole):
            how = f"{ends.start_how}; ends while {course.name} is held still, before it is moved on"
            told = [*doubts, *unclear(course, ends.start_s, pause_s)]
            told.append(Doubt(PAUSED, f"{stretch.agent} holds {course.name} still for a while, and moves it on"))
            found.append(self._handling(course.name, stretch, (ends.start_s, pause_s), "held still", told, how))
        if ends.end_s > ends.start_s and course.part(whole).moving:
            how = f"{ends.start_how}; {ends.end_how}"
            ending = self._ending(course, stretch, ends.end_s)
            found.append(self._handling(course.name, stretch, whole, ending, doubts, how))
        return found

    def _ends(self, course: Course, stretch: _Stretch, span: Span) -> Ends:
        """When one stretch starts and ends."""
        if stretch.turn is None:
            return self._ends_of_push(course, stretch, span)
        given = (stretch.given,) if stretch.given else ()
        within = (span[0], math.inf if stretch.given else span[1])
        ends = ends_of(self._recording, course, (stretch.turn,), given, stretch.turn.agent, within, self._settings)
        if stretch.taken is None:
            return ends
        return replace(ends, start_s=change_of(course, stretch.taken)[0], start_how="starts when it changes hands")

    def _ends_of_push(self, course: Course, stretch: _Stretch, span: Span) -> Ends:
        """When a thing that nobody has is moved: nothing but its motion tells."""
        first_s, last_s = (float(self._recording.times_s[each]) for each in (0, -1))
        start_s = max(stretch.start_s - BEFORE_S, first_s, span[0])
        start_how = f"starts {stretch.start_s - start_s:.2g} s before it is pushed"
        end_s, end_how = rest_of(course, after_s=stretch.start_s, until_s=span[1]) or (
            last_s,
            "ends with the recording",
        )
        doubts = [*unclear(course, start_s, end_s)]
        if end_s >= last_s:
            doubts.append(Doubt(UNENDED, f"the recording ends before {course.name} has come to rest"))
        if stretch.agent is None:
            doubts.append(Doubt(0.0, f"nobody is seen to move {course.name}"))
        if stretch.start_s <= first_s:
            doubts.append(Doubt(UNSEEN, f"{course.name} moves already when the recording begins"))
        return Ends(start_s, start_how, end_s, end_how, (), tuple(doubts))

    def _ending(self, course: Course, stretch: _Stretch, end_s: float) -> Ending:
        """With what a stretch ends."""
        if stretch.given:
            return "changes hands"
        if end_s >= self._recording.times_s[-1]:
            return "recording ends"
        if stretch.turn and not rests_between(resting(course.placements), end_s - ROUNDING_S, end_s):
            return "held still"
        return "rests"

    def _pauses(self, course: Course, stretch: _Stretch, start_s: float, end_s: float) -> list[float]:
        """When within a stretch the thing has been still for a while, in hand, and is then moved on."""
        if stretch.turn is None:
            return []
        moving, found = course.moving, []
        rests = resting(course.placements)
        for still in course.still:
            if not (start_s < still.start_s and still.end_s < end_s and still.end_s - still.start_s >= PAUSE_S):
                continue
            if rests_between(rests, still.start_s, still.end_s):
                continue
            later = [each for each in moving if still.end_s <= each.start_s < end_s]
            before = course.part((start_s, still.start_s)).moving
            moved_s = sum(min(each.end_s, still.start_s) - max(each.start_s, start_s) for each in before)
            away = self._way_m(course.name, (start_s, still.start_s)) >= AWAY_M or moved_s >= PAUSE_S
            if later and away:
                found.append(still.start_s + PAUSE_S / 2)
        return found

    def _handling(
        self, name: str, stretch: _Stretch, span: Span, ending: Ending, doubts: Sequence[Doubt], how: str
    ) -> Handling:
        doubt = min(doubts, key=lambda each: each.confidence, default=Doubt(1.0, ""))
        taker = stretch.given.taker if stretch.given and ending == "changes hands" else None
        targets = self._targets(name, stretch.agent, taker, span)
        reason = doubt.reason if doubt.confidence < 1.0 else ""
        return Handling(name, stretch.agent, targets, taker, *span, ending, (), doubt.confidence, reason, how)

    def _targets(self, name: str, performer: str | None, taker: str | None, span: Span) -> tuple[str, ...]:
        """The other agents: who takes the thing, then those whose eyes are at it, or who are looked at."""
        others = [agent for agent in self._recording.scene.agents if agent != performer]
        if len(others) < 2 or performer is None:
            return tuple(others)
        glances = dict.fromkeys(others, 0)
        for index in self._frames(*span, GLANCES):
            stage = self._stage.show(self._recording.state(index))
            own = gaze(stage, performer, self._settings)
            for agent in others:
                found = gaze(stage, agent, self._settings)
                glances[agent] += (own is not None and own.target == agent) + (
                    found is not None and found.target in (name, performer)
                )
        return tuple(sorted(others, key=lambda agent: (agent != taker, -glances[agent], agent)))

    def _frames(self, start_s: float, end_s: float, count: int) -> range:
        """Some frames of a span, evenly."""
        first, last = (bisect_left(self._recording.times_s, time_s) for time_s in (start_s, end_s))
        last = min(max(last, first + 1), len(self._recording))
        return range(first, last, max((last - first) // count, 1))

    def _way_m(self, name: str, span: Span) -> float:
        """How far a thing gets away from where it was at the start of a span, metres."""
        indices = self._frames(*span, len(self._recording))
        places = self._recording.qpos[indices.start : indices.stop, self._recording.scene.object_slice(name)][:, :3]
        return math.sqrt(float(((places - places[:1]) ** 2).sum(axis=1).max(initial=0.0)))


def _held(course: Course) -> list[_Stretch]:
    """The turns of a thing, those of one agent that follow each other closely as one, and how each begins and ends."""
    by_taken = {(change.taker, change.taken_s): change for change in course.changes}
    found = list[_Stretch]()
    for turn in course.turns:
        change = by_taken.get((turn.agent, turn.start_s))
        if found and found[-1].agent == turn.agent and turn.start_s - found[-1].end_s < REGRASPED_S:
            last = found[-1]
            whole = Turn(turn.agent, last.start_s, max(turn.end_s, last.end_s))
            found[-1] = replace(last, end_s=whole.end_s, turn=whole)
            continue
        if found and change and found[-1].agent == change.giver:
            found[-1] = replace(found[-1], end_s=change.time_s, given=change)
        start_s = change.time_s if change else turn.start_s
        found.append(_Stretch(turn.agent, start_s, max(turn.end_s, start_s), turn, taken=change))
    return found
