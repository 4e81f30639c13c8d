"""A plan: what is done, action by action, phase by phase. A value that planning makes and performing carries out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.frozen import FrozenMap
from taskgist.learning.understanding import Clause
from taskgist.moving.acting import RATE_HZ
from taskgist.perspective.effort import NO_KNOWN_LEVEL
from taskgist.planning.placing import Candidate
from taskgist.world.state import Hold

__all__ = ["RATE_HZ", "About", "Action", "Cost", "Phase", "PhaseName", "Plan", "Purpose", "efforts_of", "total_cost"]

PhaseName = Literal[
    "drive",
    "open",
    "reach",
    "approach",
    "close",
    "lift",
    "slide",
    "carry",
    "transport",
    "transfer",
    "lower",
    "take",
    "draw near",
    "retreat",
    "fold",
    "withdraw",
]


@dataclass(frozen=True, eq=False)
class Phase:
    """One motion: of the base, of an arm, or of a hand that closes or opens.

    Attributes:
        name: What it is for.
        qpos: Positions of everything, ``RATE_HZ`` a second, (n, nq); read-only.
        holds: What is in which hands meanwhile; in two hands while it is handed over.
    """

    name: PhaseName
    qpos: Array
    holds: frozenset[Hold]

    def __post_init__(self) -> None:
        qpos = np.array(self.qpos, dtype=float)
        qpos.flags.writeable = False
        object.__setattr__(self, "qpos", qpos)

    @property
    def duration_s(self) -> float:
        """How long it takes."""
        return len(self.qpos) / RATE_HZ


Purpose = Literal["move", "cover", "clear", "relay", "slide"]
"""What an action is for: to bring the thing where it shall be; to cover it; to take something out of the way of whoever
shall see, reach or grasp it; to bring it where a helper takes it; to slide it out over an edge, where a hand gets
around it."""


@dataclass(frozen=True, eq=False)
class Action:
    """One thing brought to one place by one agent.

    Attributes:
        performer: Who does it.
        side: The hand.
        purpose: What it is for.
        candidate: Where what is carried is in the end, and what that is.
        effort: The least effort level with which the performer grasps it where it lies, and gets at it there; None if
            one of them is unknown.
        phases: One motion after the other.
        about: For the sake of which of the task's things it is done: that which is covered, say.
    """

    performer: str
    side: str
    purpose: Purpose
    candidate: Candidate
    effort: int | None
    phases: tuple[Phase, ...]
    about: str

    @property
    def thing(self) -> str:
        """What is carried: what the task is about, or what covers it, or is in the way."""
        return self.candidate.thing

    @property
    def taker(self) -> str | None:
        """To whom it is handed over; None if it is not."""
        return self.candidate.carrier if self.candidate.means == "hand_over" else None

    @property
    def level(self) -> int:
        """The effort as it is counted: what is not known as none known."""
        return NO_KNOWN_LEVEL if self.effort is None else self.effort

    @property
    def duration_s(self) -> float:
        """How long it takes."""
        return sum(phase.duration_s for phase in self.phases)


EFFORT_COST = 1 / NO_KNOWN_LEVEL
"""What a level of effort costs, in actions: the greatest weighs as much as an action (ours)."""


@dataclass(frozen=True)
class Cost:
    """What a plan costs: its actions, and the efforts of all who take part.

    Attributes:
        actions: How many actions.
        efforts: Effort levels by agent: of each that acts the sum over its actions, of whoever the thing is for what it
            takes it in the end to get at it; of several things the sum.
    """

    actions: int
    efforts: Mapping[str, int]

    def __post_init__(self) -> None:
        object.__setattr__(self, "efforts", FrozenMap(self.efforts))

    @property
    def total(self) -> float:
        """In actions."""
        return self.actions + EFFORT_COST * sum(self.efforts.values())


def total_cost(costs: Sequence[Cost]) -> Cost:
    """What several plans cost, one after the other."""
    efforts = Counter[str]()
    for cost in costs:
        efforts.update(cost.efforts)
    return Cost(sum(cost.actions for cost in costs), efforts)


def efforts_of(actions: Sequence[Action]) -> dict[str, int]:
    """Effort levels of those who act, each summed over its actions."""
    found = dict[str, int]()
    for action in actions:
        found[action.performer] = found.get(action.performer, 0) + action.level
    return found


class About:
    """Target agents and things of a task, of which the first ones stand by themselves."""

    target: str
    thing: str
    also_for: tuple[str, ...]
    also_with: tuple[str, ...]

    @property
    def targets(self) -> tuple[str, ...]:
        """All target agents."""
        return (self.target, *self.also_for)

    @property
    def things(self) -> tuple[str, ...]:
        """All that the task is about, in the order in which it is brought."""
        return (self.thing, *self.also_with)


@dataclass(frozen=True, eq=False)
class Plan(About):
    """What is done to perform a task, by a robot or a person, and by those who help.

    Attributes:
        clause: What it is to make true.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        actions: One after the other, each from where the one before has left everything.
        cost: What they cost.
        notes: What was chosen, in words.
        also_for: Further target agents.
        also_with: Further things.
    """

    clause: Clause
    performer: str
    target: str
    thing: str
    actions: tuple[Action, ...]
    cost: Cost
    notes: tuple[str, ...] = ()
    also_for: tuple[str, ...] = ()
    also_with: tuple[str, ...] = ()

    @property
    def task(self) -> str:
        """Name of the task."""
        return self.clause.task

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Motions of all actions."""
        return tuple(phase for action in self.actions for phase in action.phases)

    @property
    def candidate(self) -> Candidate:
        """Where what was moved last is in the end."""
        return self.actions[-1].candidate

    @property
    def performers(self) -> tuple[str, ...]:
        """All who act, each once, in the order in which they do."""
        return tuple(dict.fromkeys(action.performer for action in self.actions))

    @property
    def moved(self) -> tuple[str, ...]:
        """All that is carried, each once."""
        return tuple(dict.fromkeys(action.thing for action in self.actions))

    @property
    def duration_s(self) -> float:
        """How long it takes, seconds."""
        return sum(action.duration_s for action in self.actions)
