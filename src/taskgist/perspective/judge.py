"""What the judges of the three abilities share: how an ability is judged from stances, and what they answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

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


class Among(Protocol):
    """What is known of an ability among stances before any is looked at closely."""

    @property
    def hopeful(self) -> NDArray[np.bool_]:
        """Where the ability may hold, (n,); it surely does not where this is false."""

    def outcomes(self, index: int) -> Iterator[Outcome | Miss]:
        """How it holds from a hopeful stance, best first; or why it does not."""

    def miss(self) -> Miss:
        """Why it does not hold from the others: the nearest miss."""


class Hopeless:
    """An ability that no stance can give, for one and the same reason."""

    def __init__(self, why: Miss, count: int) -> None:
        self._why = why
        self.hopeful: NDArray[np.bool_] = np.zeros(count, dtype=np.bool_)

    def outcomes(self, index: int) -> Iterator[Outcome | Miss]:  # noqa: ARG002 - as all of these
        """Never."""
        yield self._why

    def miss(self) -> Miss:
        """The reason."""
        return self._why


class Judge(Protocol):
    """Judges one ability towards one object. The stage may show anything before and after each call."""

    def unknown(self, level: int) -> str | None:
        """Why nothing can be said at an effort level, for want of tracking; None if something can."""

    def without_effort(self) -> Outcome | Miss:
        """Level 0: whether the ability holds in the current state."""

    def parts(self, stances: Stances) -> Sequence[Stances]:
        """In which parts to look at stances: one after the other, each all at once."""

    def among(self, stances: Stances) -> Among:
        """Look at a part of them."""


def untracked_parts(state: State, agent: str, parts: tuple[str, ...]) -> str | None:
    """Sentence about those parts of an agent that were not tracked; None if all were."""
    lost = [part for part in parts if not state.known([f"{agent}/{part}"])]
    return f"{agent}'s {' and '.join(lost)} not tracked" if lost else None
