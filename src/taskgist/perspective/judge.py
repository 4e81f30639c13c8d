"""What the judges of the three abilities share: how an ability is judged from stances, and what they answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from taskgist.perspective.acting.stances import Stances
from taskgist.world import State


@dataclass(frozen=True, eq=False)
class Outcome:
    """How the ability holds from a stance.

    Attributes:
        angles_rad: Angles of the head, by index into qpos, in the attained state; the others are the stance's.
        actions: Virtual actions after those of the stance, in order.
        head_rad: How far the head turned, radians.
        merit: Decides between equal amounts; less is better.
        evidence: Gives what was found, as plain data; only asked of the outcome that is chosen.
    """

    angles_rad: Mapping[int, float] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    head_rad: float = 0.0
    merit: float = 0.0
    evidence: Callable[[], Mapping[str, object]] = dict


@dataclass(frozen=True, order=True)
class Miss:
    """Why the ability does not hold in a state; the least ``shortfall`` of a level is the one worth telling.

    Attributes:
        shortfall: How far the ability is, for comparing misses of one ability.
        why: For people.
        evidence: Gives what shows it, as plain data; only asked of the miss that is told.
    """

    shortfall: float
    why: str
    evidence: Callable[[], Mapping[str, object]] = field(default=dict, compare=False)


NO_ARM = Miss(math.inf, "no arm may be stretched out")


Why = Callable[[], Miss]
"""Tells why the ability does not hold; only asked if somebody wants to know."""


class Among(Protocol):
    """Stances, passed over quickly where the ability surely does not hold."""

    def next(self, start: int, stop: int) -> int:
        """The first stance from ``start`` on from which the ability may hold; ``stop`` if none before it does."""

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:
        """How it holds from that stance, best first; or why it does not."""

    def miss(self) -> Miss | None:
        """Why it does not hold from those passed over: the nearest miss; None if there were none. Asked at last."""


class Hopeless:
    """An ability that no stance can give, for one and the same reason."""

    def __init__(self, why: Miss) -> None:
        self._why = why

    def next(self, start: int, stop: int) -> int:  # noqa: ARG002 - as all of these
        """None."""
        return stop

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:  # noqa: ARG002 - as all of these
        """Never."""
        yield self.miss

    def miss(self) -> Miss:
        """The reason."""
        return self._why


class Judge(Protocol):
    """Judges one ability towards one object. The stage may show anything before and after each call."""

    def unknown(self, level: int) -> str | None:
        """Why nothing can be said at an effort level, for want of tracking; None if something can."""

    def without_effort(self) -> Outcome | Why:
        """Level 0: whether the ability holds in the current state."""

    def among(self, stances: Stances) -> Among:
        """Look at stances."""


def untracked_parts(state: State, agent: str, parts: tuple[str, ...]) -> str | None:
    """Sentence about those parts of an agent that were not tracked; None if all were."""
    if not state.untracked:
        return None
    lost = [part for part in parts if not state.known([f"{agent}/{part}"])]
    return f"{agent}'s {' and '.join(lost)} not tracked" if lost else None
