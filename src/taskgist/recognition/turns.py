"""Who has an object when, one after the other, and when it changes hands.

Hands hold things (``grips_of``); people have them, with one hand or with both, and pass them on::

    P1's right hand   ──────────────┐
    P1's left hand          ────────────┐
    P2's right hand                ──────────────
    P1 has it         ──────────────────┐
    P2 has it                      ──────────────
    changes hands                     ↑             in the middle of the time in which both have it
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from taskgist.facts import vocabulary as v
from taskgist.observe.frames import Interval
from taskgist.observe.observer import Observer, Placement

RESTING = frozenset({v.ON_SUPPORT, v.INSIDE_CONTAINER, v.HANGING, v.ON_AGENT})
"""Placements in which nobody's hand has an object."""
GIVING = frozenset({"give", "hand over", "handover", "pass"})
"""Tasks in which an object goes from the performing agent to the target agent; others are called as people like."""
BRIEF_S = 0.5
"""Who has an object for less, between two turns of one other agent, only steadies it."""


@dataclass(frozen=True)
class Grip:
    """One hand holds the object from ``start_s`` until ``end_s``, in seconds."""

    agent: str
    side: str
    start_s: float
    end_s: float


@dataclass(frozen=True)
class Turn:
    """One agent has the object, with whichever hands, from ``start_s`` until ``end_s``, in seconds."""

    agent: str
    start_s: float
    end_s: float


@dataclass(frozen=True)
class Change:
    """An object passes from one agent to another, without resting in between.

    Attributes:
        giver: Who had it before.
        taker: Who has it then.
        taken_s: When the taker first has it, seconds.
        released_s: When the giver no longer has it, seconds; before ``taken_s`` if for a while nobody is seen to.
        kept_s: Until when the taker has it, seconds.
    """

    giver: str
    taker: str
    taken_s: float
    released_s: float
    kept_s: float

    @property
    def time_s(self) -> float:
        """The middle of the time in which both have it; when the taker is first seen to, if they never both do."""
        return (self.taken_s + self.released_s) / 2 if self.released_s > self.taken_s else self.taken_s


def grips_of(observer: Observer, name: str) -> tuple[Grip, ...]:
    """Which hands hold an object when, in order of time.

    Args:
        observer: One of a whole recording.
        name: The object.

    Raises:
        UnknownNameError: There is no such object.
    """
    observer.scene.object_body(name)
    return all_grips(observer).get(name, ())


def all_grips(observer: Observer) -> dict[str, tuple[Grip, ...]]:
    """Which hands hold what when: by object, in order of time; what nobody holds is left out.

    Args:
        observer: One of a whole recording.
    """
    scene, grips = observer.scene, dict[str, list[Grip]]()
    for agent in scene.agents:
        for side in scene.agent(agent).sides:
            for interval in observer.hand(agent, side).intervals:
                if interval.value.symbol == v.HOLDING_OBJECT and interval.value.thing is not None:
                    grip = Grip(agent, side, interval.start_s, interval.end_s)
                    grips.setdefault(interval.value.thing, []).append(grip)
    return {
        name: tuple(sorted(found, key=lambda grip: (grip.start_s, grip.agent, grip.side)))
        for name, found in grips.items()
    }


def turns_of(observer: Observer, name: str) -> tuple[Turn, ...]:
    """Who has an object when, in order of time: each turn begins and ends later than the one before.

    Args:
        observer: One of a whole recording.
        name: The object.

    Raises:
        UnknownNameError: There is no such object.
    """
    return turns_from(grips_of(observer, name), observer.placement(name).intervals)


def turns_from(grips: Iterable[Grip], placements: Iterable[Interval[Placement]]) -> tuple[Turn, ...]:
    """The turns of ``turns_of``, from which hands hold the object when, and where it is when."""
    rests = resting(placements)
    turns = _joined(rests, [Turn(grip.agent, grip.start_s, grip.end_s) for grip in grips])
    # Who helps for a while, while another has it all along, does not have a turn.
    own = [turn for turn in turns if not any(_covers(other, turn) for other in turns)]
    own = [
        turn
        for number, turn in enumerate(own)
        if not (0 < number < len(own) - 1 and _steadies(turn, own[number - 1], own[number + 1]))
    ]
    return tuple(_joined(rests, own))


def changes_of_hands(observer: Observer, name: str, turns: Sequence[Turn]) -> tuple[Change, ...]:
    """When an object passes from one agent's hands into those of another.

    Args:
        observer: One of a whole recording.
        name: The object.
        turns: Who has it when.
    """
    return changes_from(turns, observer.placement(name).intervals)


def changes_from(turns: Sequence[Turn], placements: Iterable[Interval[Placement]]) -> tuple[Change, ...]:
    """The changes of ``changes_of_hands``, from who has the object when, and where it is when."""
    rests = resting(placements)
    return tuple(
        Change(before.agent, after.agent, after.start_s, before.end_s, after.end_s)
        for before, after in pairwise(turns)
        if before.agent != after.agent
        and before.end_s < after.end_s
        and not rests_between(rests, before.end_s, after.start_s)
    )


def resting(placements: Iterable[Interval[Placement]]) -> tuple[Interval[Placement], ...]:
    """Those in which nobody's hand has the object, for sure."""
    return tuple(interval for interval in placements if interval.value.symbol in RESTING)


def rests_between(rests: Sequence[Interval[Placement]], start_s: float, end_s: float) -> bool:
    """Whether an object rests at some time within a span, in seconds.

    Args:
        rests: When it rests, in order.
        start_s: Start of the span.
        end_s: End of the span.
    """
    before = bisect_left(rests, end_s, key=lambda rest: rest.start_s)
    return before > 0 and rests[before - 1].end_s > start_s


def _covers(longer: Turn, turn: Turn) -> bool:
    within = longer.start_s <= turn.start_s and turn.end_s <= longer.end_s
    return longer.agent != turn.agent and within and longer.end_s - longer.start_s > turn.end_s - turn.start_s


def _steadies(turn: Turn, before: Turn, after: Turn) -> bool:
    """Whether an agent has the object so briefly between two turns of another that it never was its own."""
    if before.agent == turn.agent or before.agent != after.agent:
        return False
    return min(turn.end_s, after.start_s) - max(turn.start_s, before.end_s) < BRIEF_S


def _joined(rests: Sequence[Interval[Placement]], turns: Sequence[Turn]) -> list[Turn]:
    """The turns of each agent, joined where they overlap, or where the object rests nowhere and goes to nobody else."""
    joined: list[Turn] = []
    for turn in sorted(turns, key=lambda turn: (turn.start_s, turn.end_s)):
        last = max((k for k, each in enumerate(joined) if each.agent == turn.agent), default=None)
        before = None if last is None else joined[last]
        elsewhere = [each for each in turns if before and each.agent != turn.agent and each.end_s > before.end_s]
        alone = not any(each.start_s < turn.start_s for each in elsewhere)
        if (
            last is not None
            and before
            and (turn.start_s <= before.end_s or (alone and not rests_between(rests, before.end_s, turn.start_s)))
        ):
            joined[last] = Turn(turn.agent, before.start_s, max(before.end_s, turn.end_s))
        else:
            joined.append(turn)
    return joined
