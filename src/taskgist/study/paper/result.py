"""One published result beside ours, and the verdict of comparing them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum

from taskgist.facts import FrozenMap, Json, freeze, thaw


class Verdict(Enum):
    """What comes of comparing a published result with ours."""

    EQUAL = "equal"
    DIFFERS_EXPLAINED = "differs, explained"
    FAILS = "fails"


class Goal(Enum):
    """What comes of comparing a measured share with a goal of ours, of which the paper prints nothing."""

    MET = "goal met"
    OPEN = "not distinguishable"
    NOT_MET = "goal not met"


@dataclass(frozen=True)
class Result:
    """A published result and ours; or ours alone, held to a goal.

    Args:
        name: What is compared.
        where: Where the paper has it: ``"Eq. 37"``, ``"Table 2"``, ``"7.3"``.
        paper: What the paper says, as data; None where it says nothing.
        ours: What was measured, as data; None if nothing was.
        verdict: What the comparison says, with the paper or with the goal; None if nothing was measured.
        explanation: Why the two differ, or what to know of the figures.
    """

    name: str
    where: str
    paper: Json
    ours: Json
    verdict: Verdict | Goal | None
    explanation: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "paper", freeze(self.paper))
        object.__setattr__(self, "ours", freeze(self.ours))

    def to_json(self) -> dict[str, Json]:
        """Plain data."""
        return {
            "name": self.name,
            "where": self.where,
            "paper": thaw(self.paper),
            "ours": thaw(self.ours),
            "verdict": self.verdict.value if self.verdict else "not measured",
            "explanation": self.explanation,
        }


@dataclass(frozen=True)
class Section:
    """Results that belong together.

    Args:
        name: Its key in documents: ``"clauses"``.
        title: For people.
        results: In the paper's order.
        about: What was done, and what to mind.
        details: Further figures, as plain data.
    """

    name: str
    title: str
    results: tuple[Result, ...]
    about: str = ""
    details: Mapping[str, Json] = field(default_factory=FrozenMap)

    def __post_init__(self) -> None:
        object.__setattr__(self, "details", freeze(self.details))

    def to_json(self) -> dict[str, Json]:
        """Plain data."""
        return {
            "name": self.name,
            "title": self.title,
            "about": self.about,
            "results": [result.to_json() for result in self.results],
            "details": {key: thaw(value) for key, value in self.details.items()},
        }


def compared(name: str, where: str, paper: Json, ours: Json, *, explanation: str = "") -> Result:
    """Compare what the paper says with what was measured.

    Args:
        name: What is compared.
        where: Where the paper has it.
        paper: What the paper says.
        ours: What was measured.
        explanation: Why the two may differ in just this way. Where they are equal it is left out, and without one a
            difference is a failure.
    """
    if freeze(paper) == freeze(ours):
        return Result(name, where, paper, ours, Verdict.EQUAL)
    return Result(name, where, paper, ours, Verdict.DIFFERS_EXPLAINED if explanation else Verdict.FAILS, explanation)


def tally(results: Iterable[Result], kind: type[Verdict] | type[Goal] = Verdict) -> dict[str, int]:
    """How many results have each verdict of a kind, those without any as "not measured"."""
    counts = Counter(result.verdict for result in results)
    told = {verdict.value: counts[verdict] for verdict in kind}
    return told | ({"not measured": counts[None]} if counts[None] else {})
