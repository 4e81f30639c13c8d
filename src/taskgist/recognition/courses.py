"""The course of one thing through a recording, and when something that is done with it starts and ends.

A *course* is all that is confirmed of one thing over time: where it is, when it moves, who has it, when it changes
hands. It is found once, for all that is asked of it; ``part`` gives a piece of it, so that what is asked of each of
many pieces of a long recording takes no longer than the recording does.

What is done with a thing

- *starts* a little before the thing leaves what it rests on, or is first moved;
- *ends* when the thing changes hands, in the middle of the time in which both have it; where it does not, when it has
  come to rest, before somebody else takes it.

What speaks against this is counted (``Doubt``), each as a share from 0 to 1.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

from taskgist.facts import vocabulary as v
from taskgist.observe.frames import Interval
from taskgist.observe.observer import Observer, Placement
from taskgist.observe.under_way import nearest_hand_m
from taskgist.recognition.turns import BRIEF_S, RESTING, Change, Turn, all_grips, changes_from, turns_from
from taskgist.recording.recording import Recording
from taskgist.settings import Checks, Settings
from taskgist.world.stage import Stage

BEFORE_S = 0.3
"""How long before the first event a label starts."""
AFTER_S = 0.3
"""How long after the object has come to rest a label ends."""
LOOKS = 20
"""In as many frames of a turn it is looked whose hand is nearer."""
TOO_LATE, UNENDED, UNSEEN = 0.7, 0.4, 0.3
"""Confidence where the start is not seen, where the end is not, and where it is not who takes the thing first."""
UNSEEN_S = 0.5
"""Who has a thing at first is not seen where it is unknown for so long before somebody has it."""
Span = tuple[float, float]
"""From when to when, seconds; either may be infinite."""
V = TypeVar("V")


@dataclass(frozen=True)
class Doubt:
    """One thing that a proposal hangs on.

    Attributes:
        confidence: From 0 (nothing speaks for it) to 1.
        reason: What was counted, in one clause.
    """

    confidence: float
    reason: str


@dataclass(frozen=True)
class Ends:
    """Where something may start and end for one thing, how each was found, and what the start and all else hang on."""

    start_s: float
    start_how: str
    end_s: float
    end_how: str
    late: tuple[Doubt, ...]
    doubts: tuple[Doubt, ...]


@dataclass(frozen=True)
class Course:
    """What is confirmed of one thing over time, each in order.

    Attributes:
        name: The thing.
        placements: Where it is.
        motions: When it moves, and when it does not; None is unknown.
        turns: Who has it.
        changes: When it changes hands.
    """

    name: str
    placements: tuple[Interval[Placement], ...]
    motions: tuple[Interval[str | None], ...]
    turns: tuple[Turn, ...]
    changes: tuple[Change, ...]

    @property
    def moving(self) -> tuple[Interval[str | None], ...]:
        """When it moves."""
        return tuple(interval for interval in self.motions if interval.value == v.MOVING)

    @property
    def still(self) -> tuple[Interval[str | None], ...]:
        """When it stands still."""
        return tuple(interval for interval in self.motions if interval.value == v.STATIC)

    def part(self, span: Span) -> Course:
        """The same between two times, with whole intervals; turns and changes are left to who asks."""
        return replace(
            self, placements=_within(self.placements, span), motions=_within(self.motions, span), turns=(), changes=()
        )


def _within(intervals: tuple[Interval[V], ...], span: Span) -> tuple[Interval[V], ...]:
    """The intervals that lie in a span of time, or reach into it; they follow each other."""
    first = bisect_right(intervals, span[0], key=lambda interval: interval.end_s)
    return intervals[first : bisect_left(intervals, span[1], key=lambda interval: interval.start_s)]


def courses_of(observer: Observer, names: Iterable[str] | None = None) -> dict[str, Course]:
    """The courses of things, by name.

    Args:
        observer: One of a whole recording.
        names: Which; by default all of the scene.

    Raises:
        UnknownNameError: There is no such object.
    """
    names = observer.scene.objects if names is None else tuple(names)
    placements = {name: observer.placement(name).intervals for name in names}
    motions = {name: observer.motion(name).intervals for name in names}
    grips, courses = all_grips(observer), dict[str, Course]()
    for name in names:
        turns = turns_from(grips.get(name, ()), placements[name])
        courses[name] = Course(name, placements[name], motions[name], turns, changes_from(turns, placements[name]))
    return courses


def percent(share: float) -> str:
    """A share in words."""
    return f"{100 * share:.0f} %"


# --- From when to when.


def ends_of(
    recording: Recording,
    course: Course,
    turns: tuple[Turn, ...],
    given: tuple[Change, ...],
    performer: str,
    span: tuple[float, float],
    settings: Settings,
) -> Ends:
    """When something that is done with a thing starts and ends, and what speaks against that.

    Args:
        recording: The recording.
        course: The thing's course.
        turns: Who has it when, of those that count.
        given: The changes of hands with which it may end.
        performer: Who does it.
        span: What happens before and after does not count, seconds.
        settings: How late a recording may begin.
    """
    own = [turn for turn in turns if turn.agent == performer]
    change = given[0] if given else None
    if change:
        own = [turn for turn in own if turn.start_s < change.taken_s][-1:]
    turn = own[0] if own else (turns[0] if turns else None)
    start_s, start_how, late = start_of(recording, course, turn, span, settings.checks)
    doubts: list[Doubt] = []
    if change:
        end_s, end_how = change_of(course, change)
        if len(given) > 1:
            doubts.append(
                Doubt(1.0 / len(given), f"{performer} gives {course.name} to {change.taker} {len(given)} times")
            )
        doubts.append(nearer(recording, course, change, turn.start_s if turn else start_s))
    else:
        later = [each.start_s for each in turns if each.agent != performer and turn and each.start_s > turn.start_s]
        found = rest_of(course, after_s=start_s, until_s=min([*later, span[1]]))
        end_s, end_how = found or (float(recording.times_s[-1]), "ends with the recording")
        if not found and span[1] == math.inf:
            doubts.append(Doubt(UNENDED, f"the recording ends before {course.name} has come to rest or changed hands"))
    doubts += unclear(course, start_s, end_s)
    too_late = (Doubt(TOO_LATE, late),) if late else ()
    return Ends(start_s, start_how, end_s, end_how, too_late, tuple(doubts))


def known_s(course: Course, *, from_s: float, until_s: float) -> float:
    """The first moment in a span at which the object's placement is known; its start, if there is none."""
    known = (i for i in course.placements if i.value.symbol is not None and i.end_s > from_s)
    moment = next((max(i.start_s, from_s) for i in known), from_s)
    return moment if moment < until_s else from_s


def start_of(
    recording: Recording,
    course: Course,
    turn: Turn | None,
    span: tuple[float, float],
    limits: Checks,
) -> tuple[float, str, str]:
    """Just before the object is moved or leaves what it rests on, how that was found, and what is late about it."""
    first_s = max(float(recording.times_s[0]), span[0])
    first_known_s = known_s(course, from_s=first_s, until_s=float(recording.times_s[-1]))
    event_s = _event_s(course, turn, first_known_s)
    if event_s is None:
        return first_known_s, "starts where the object is first known", ""
    still = [i.start_s for i in course.still if i.start_s < event_s]
    start_s = max(first_known_s, still[-1] if still else first_known_s, event_s - BEFORE_S)
    late = ""
    if span[0] == -math.inf and event_s - first_s < limits.begins_s:
        late = f"the recording begins too late: {course.name} is moved {event_s - first_s:.2f} s after its first frame"
    return start_s, f"starts {event_s - start_s:.2g} s before the object is moved", late


def _event_s(course: Course, turn: Turn | None, first_known_s: float) -> float | None:
    """When the object leaves what it rests on to be held for a turn, or is moved there before, in seconds."""
    moving = course.moving
    later = [i.start_s for i in moving if i.start_s > first_known_s]
    if turn is None:
        return later[0] if later else None
    rests = [i for i in course.placements if i.value.symbol in RESTING and i.start_s < turn.end_s]
    rests = [i for i in rests if i.start_s <= turn.start_s]
    if not rests:  # it was held from the first on
        during = [start_s for start_s in later if start_s < turn.end_s]
        return during[0] if during else first_known_s
    left_s = min(rests[-1].end_s, turn.start_s) if rests[-1].end_s > first_known_s else turn.start_s
    slid = [i.start_s for i in moving if i.start_s <= left_s <= i.end_s]
    return min(left_s, *slid) if slid else left_s


def change_of(course: Course, change: Change) -> tuple[float, str]:
    """When it changes hands; where hands are hidden then, when it is first known thereafter where the object is."""
    end_s = known_s(course, from_s=change.time_s, until_s=change.kept_s)
    if change.released_s > change.taken_s:
        how = f"ends in the middle of the {change.released_s - change.taken_s:.2f} s in which both have it"
    else:
        how = "ends when it changes hands"
    return end_s, f"{how} ({change.giver} gives, {change.taker} takes)"


def rest_of(course: Course, *, after_s: float, until_s: float) -> tuple[float, str] | None:
    """Just after the object has last come to rest before a time; None if it does not."""
    rests = [i for i in course.still if after_s < i.start_s < until_s]
    if not rests:
        return None
    end_s = min(rests[-1].start_s + AFTER_S, max(rests[-1].end_s, rests[-1].start_s), until_s)
    return end_s, f"ends {end_s - rests[-1].start_s:.2g} s after the object comes to rest"


# --- How sure that is.


def unclear(course: Course, start_s: float, end_s: float) -> tuple[Doubt, Doubt]:
    """How much of the time it is known who or what has the object, and how much of its way somebody carries it."""
    whole_s = max(end_s - start_s, 1e-9)
    unknown_s = sum(_shared_s(i.start_s, i.end_s, start_s, end_s) for i in course.placements if i.value.symbol is None)
    moving = course.moving
    moved_s = sum(_shared_s(i.start_s, i.end_s, start_s, end_s) for i in moving)
    alone_s = sum(
        _shared_s(max(i.start_s, j.start_s), min(i.end_s, j.end_s), start_s, end_s)
        for i in course.placements
        if i.value.symbol == v.IN_AIR
        for j in moving
    )
    known = f"in {percent(unknown_s / whole_s)} of the time from start to end it is unknown who has {course.name}"
    carried = f"in {percent(alone_s / max(moved_s, 1e-9))} of the time in which {course.name} moves nobody has it"
    return Doubt(1.0 - unknown_s / whole_s, known), Doubt(1.0 - alone_s / max(moved_s, 1e-9), carried)


def unseen(course: Course, first: tuple[Turn, ...]) -> Iterator[Doubt]:
    """Whether somebody else may have had it before the first who is seen to."""
    for turn in first:
        for interval in course.placements:
            lasts_s = turn.start_s - interval.start_s
            before = interval.value.symbol is None and interval.start_s < turn.start_s <= interval.end_s + BRIEF_S / 2
            if before and lasts_s >= UNSEEN_S:
                when = f"for {lasts_s:.2f} s before {turn.agent} has it"
                yield Doubt(UNSEEN, f"it is unknown who has {course.name} {when}, so it is not clear who performs")


def _shared_s(start_s: float, end_s: float, from_s: float, until_s: float) -> float:
    return max(min(end_s, until_s) - max(start_s, from_s), 0.0)


def nearer(recording: Recording, course: Course, change: Change, start_s: float) -> Doubt:
    """Whose hands are nearer to the object while only one of the two has it.

    Where trackers are some centimetres off, another's hand is nearer for a while, and that says little; the doubt grows
    with the square of the time.
    """
    stage = Stage(recording.scene)
    spans = (
        (change.giver, change.taker, start_s, min(change.taken_s, change.released_s)),
        (change.taker, change.giver, max(change.taken_s, change.released_s), change.kept_s),
    )
    shares: list[float] = []
    for has, other, from_s, until_s in spans:
        first, last = (bisect_left(recording.times_s, time_s) for time_s in (from_s, until_s))
        gaps = [
            (
                nearest_hand_m(stage.show(recording.state(index)), has, course.name),
                nearest_hand_m(stage, other, course.name),
            )
            for index in range(first, last, max((last - first) // LOOKS, 1))
        ]
        known = [(own, others) for own, others in gaps if own is not None and others is not None]
        shares.append(sum(own <= others for own, others in known) / len(known) if known else 1.0)
    share = min(shares)
    has, other, _, _ = spans[shares.index(share)]
    return Doubt(
        1.0 - (1.0 - share) ** 2,
        f"in {percent(1.0 - share)} of the time in which {has} has {course.name}, {other}'s hand is nearer to it",
    )
