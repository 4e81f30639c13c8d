"""What the judges of the three abilities share: how an ability is judged from a stance, and what they answer."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from taskgist.perspective.virtual_actions import Stance
from taskgist.world import State


@dataclass(frozen=True, eq=False)
class Outcome:
    """A state in which the ability holds.

    Attributes:
        state: The attained state.
        actions: Virtual actions after those of the stance, in order.
        head_rad: How far the head turned, radians.
        merit: Decides between equal amounts; less is better.
        evidence: Gives what was found, as plain data; only asked of the state that is chosen.
    """

    state: State
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
        blocking: The contact that blocks, as plain data, where only that is in the way.
    """

    shortfall: float
    why: str
    blocking: Mapping[str, object] | None = field(default=None, compare=False)


NO_ARM = Miss(math.inf, "no arm may be stretched out")


class Judge(Protocol):
    """Judges one ability towards one object. The stage may show anything before and after each call."""

    def unknown(self, level: int) -> str | None:
        """Why nothing can be said at an effort level, for want of tracking; None if something can."""

    def without_effort(self) -> Outcome | Miss:
        """Level 0: whether the ability holds in the current state."""

    def from_stance(self, stance: Stance) -> Iterator[Outcome | Miss]:
        """States from a stance in which the ability holds, best first; or a single miss."""


def untracked_parts(state: State, agent: str, parts: tuple[str, ...]) -> str | None:
    """Sentence about those parts of an agent that were not tracked; None if all were."""
    lost = [part for part in parts if not state.known([f"{agent}/{part}"])]
    return f"{agent}'s {' and '.join(lost)} not tracked" if lost else None


def best_first(results: Iterable[Outcome | Miss]) -> list[Outcome | Miss]:
    """The outcomes by merit; if there are none, the nearest miss."""
    outcomes: list[Outcome] = []
    misses: list[Miss] = []
    for result in results:
        if isinstance(result, Outcome):
            outcomes.append(result)
        else:
            misses.append(result)
    outcomes.sort(key=lambda outcome: outcome.merit)
    return [*outcomes] or [min(misses, default=NO_ARM)]
