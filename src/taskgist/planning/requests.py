"""What is to be performed, and what became of the search for it: the values that go into a planner and come out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal as OneOf
from typing import NamedTuple, get_args

from taskgist.errors import InputError, UnknownNameError
from taskgist.facts.values import Raw
from taskgist.learning.understanding import AnyLiteral, Clause
from taskgist.planning.judging import Attention, Reason
from taskgist.planning.placing import Candidate
from taskgist.planning.plan import About, Purpose

MEANS: tuple[Purpose, ...] = get_args(Purpose)
"""All means, in the order in which they are tried at equal cost."""
Spared = OneOf["nobody", "performer", "target", "both"]
"""Whose effort decides which place comes first (Fig. 2): nobody's, the giver's, the taker's, or both alike."""
SPARED: tuple[Spared, ...] = get_args(Spared)


@dataclass(frozen=True)
class Request(About):
    """What is to be performed.

    Attributes:
        clause: The meaning of the task.
        performer: Who performs it.
        target: For whom.
        thing: With what.
        attention: What the target agent is assumed to look at in the end.
        allow: Supports that may be used; None for all. What is moved on the way may stay on what it is on already.
        prefer: Supports that come first.
        seed: The same request with the same seed has the same plans.
        means: By what means it may be performed; moving the thing alone is tried first.
        helpers: Who may take part in a relay, people only if they are named; None: every other robot of the room.
        spare: Whose effort decides which of the places that will do comes first.
        also_for: Further target agents: one place must do for all of them.
        also_with: Further things, one after the other.
    """

    clause: Clause
    performer: str
    target: str
    thing: str
    attention: Attention = "thing"
    allow: tuple[str, ...] | None = None
    prefer: tuple[str, ...] = ()
    seed: int = 0
    means: tuple[Purpose, ...] = MEANS
    helpers: tuple[str, ...] | None = None
    spare: Spared = "nobody"
    also_for: tuple[str, ...] = ()
    also_with: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        _check("means", self.means, MEANS)
        _check("spare", (self.spare,), SPARED)
        if self.clause.tree_of == "performer":
            hint = "learn it without --of performer, from labels with a target agent"
            problem = "its clause tells of who performs it, and not of whom it is performed for"
            raise InputError(problem, where="Request", field="clause", value=self.clause.task, hint=hint)
        busy = next((name for name in self.helpers or () if name in (self.performer, *self.targets)), None)
        if busy is not None:
            hint = "name others: who performs a task, or whom it is performed for, does not help"
            raise InputError("takes part already", where="Request", field="helpers", value=busy, hint=hint)
        who, what = ("also_for" if self.also_for else "target"), "also_with"
        for field_, names in ((who, (self.performer, *self.targets)), (what, self.things)):
            twice = next((name for name in names if names.count(name) > 1), None)
            if twice is not None:
                hint = "name each once; a task is performed for others"
                raise InputError("stands twice", where="Request", field=field_, value=twice, hint=hint)


def check_one_problem(request: Request) -> None:
    """See that a request is one problem for other planners.

    Raises:
        InputError: There are several things, whose order and judges PDDL does not have.
    """
    if len(request.things) > 1:
        value, hint = " ".join(request.things), "ask for each alone"
        raise InputError("several things are no one problem", field="pddl", value=value, hint=hint)


def _check(what: str, given: Iterable[str], known: tuple[str, ...]) -> None:
    for each in given:
        if each not in known:
            raise UnknownNameError(what, each, known, where="Request")


class Missed(NamedTuple):
    """The nearest miss of a literal: how far off it was, what was found, and where the thing was then."""

    off: float
    found: Raw
    candidate: Candidate


@dataclass
class Search:
    """What became of the candidates.

    Places are counted where the thing itself is to be moved by the performer alone, which is tried first; what became
    of all other means is told by them.

    Attributes:
        thing: The thing that was to be brought somewhere.
        places: How many were judged.
        missed: How many failed at each literal.
        out_of_hand: How many are where the target agent's hand does not get to take the thing.
        not_taken: Why not, each with its number.
        nearest: The nearest miss at each literal whose attribute is a number or a level.
        unknown: Of how many it is not known whether they do: something that decides is not tracked.
        wanted: How many satisfy the goal.
        out_of_hold: Why the performer does not get hold of the thing where it lies; then no more places are looked for
            to which it could bring it. Empty if it does.
        out_of_reach: How many of those that satisfy the goal are where it does not get at the thing, likewise.
        tried: How many of these were tried with the performer's body.
        refusals: Why the performer does not bring these about, each with its number.
        details: Where grasps and stands failed, of all places that were tried together, in sentences.
        others: Of every other way that was tried why it does not do, in the order in which they were.
    """

    thing: str = ""
    places: int = 0
    missed: Counter[AnyLiteral] = field(default_factory=Counter)
    nearest: dict[AnyLiteral, Missed] = field(default_factory=dict)
    out_of_hand: int = 0
    not_taken: Counter[str] = field(default_factory=Counter)
    unknown: int = 0
    wanted: int = 0
    out_of_hold: str = ""
    out_of_reach: int = 0
    tried: int = 0
    refusals: Counter[Reason] = field(default_factory=Counter)
    details: tuple[str, ...] = ()
    others: list[Tried] = field(default_factory=list)

    def refused_by(self, literal: AnyLiteral) -> int:
        """How many ends a literal refused: of places, of what the performer brought about, and of other ways."""
        ended = (n for why, n in self.refusals.items() if not isinstance(why, str) and why.literal == literal)
        return self.missed[literal] + sum(ended) + sum(each.why == literal for each in self.others)


@dataclass(frozen=True)
class Tried:
    """A way besides moving the thing that was tried in vain.

    Attributes:
        what: The way, in words: "R covers the cup with the bin".
        places: How many places were judged for its first action.
        why: Why it does not do; or the literal that fails.
    """

    what: str
    places: int
    why: Reason | AnyLiteral
