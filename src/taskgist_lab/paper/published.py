"""What the paper prints: clauses, the intuitive understanding, tables and times; and how ours compares with it.

The print calls one thing by several names (*Increase*, *Increasing*, *Increased*; *Object_Free* for Eq. 16's
*Free_of_object*; *Relative_Effort_to_Reach* for the class of Eq. 10): these are spellings. Where it says something that
its own definitions do not allow, or cannot be read, the reading has a reason beside it.
"""

from __future__ import annotations

import os
import platform
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from types import MappingProxyType

from taskgist.common.frozen import FrozenMap, Json, freeze, thaw
from taskgist.facts import vocabulary as v
from taskgist.facts.values import NEGLIGIBLE
from taskgist.facts.vocabulary import NO_ACTION
from taskgist.learning.understanding import Understanding

# --- The intuitive understanding of each task (8.2, Table 4), as predicates over what was learned.
#
# The paper compares what was learned with what people would say a task is about, in three columns: for the target
# agent's ability to *see* and to *reach*, and for the state of the *object*. It says so in words; here each cell says
# which nodes of the tree must be kept, with which value, and which must have been pruned.
#
# **The level matters.** A task is understood at a level of abstraction. *Supportive* is the nature of a change: as
# long as all demonstrations agree on *Becomes_Easier*, too, the learner still believes that it must become easier,
# and has not reached the intuitive understanding yet. So such a cell holds when its node is the deepest one kept that
# speaks of the final state. (So higher abstraction takes more demonstrations, as the paper finds: *Difficult* is
# reached only when efforts have been seen to differ.) *Directly* and *No action* name values at the bottom of the
# tree, and hold as soon as these are kept. The object's states are where it ends, wherever it was: the nature of its
# placement names that status (Eq. 21), and its final motion must be kept.

COLUMNS = ("see", "reach", "object")
"""Columns of Table 4."""


@dataclass(frozen=True)
class Cell:
    """One cell of Table 4.

    Args:
        wording: The paper's words.
        kept: Nodes that must belong to the understanding, with their value.
        pruned: Nodes that must not.
    """

    wording: str
    kept: tuple[tuple[str, str], ...] = ()
    pruned: tuple[str, ...] = ()

    def holds(self, understanding: Understanding) -> bool:
        """Whether this is what was understood."""
        values = {each.node.name: each.value for each in understanding.kept}
        return all(values.get(node) == value for node, value in self.kept) and values.keys().isdisjoint(self.pruned)


def _nature(ability: str) -> Cell:
    return Cell("Supportive", ((f"{ability}.nature", v.SUPPORTIVE),), (f"{ability}.class",))


def _class(wording: str, ability: str, value: str) -> Cell:
    return Cell(wording, ((f"{ability}.class", value),), (f"{ability}.effort.2",))


def _effortless(wording: str, ability: str) -> Cell:
    return Cell(wording, ((f"{ability}.effort.2", v.SEE_EFFORTS[0]),))


def _not_relevant(subtree: str) -> Cell:
    return Cell("Not relevant", pruned=(f"{subtree}.nature",))


_STATIC_ON_SUPPORT = Cell(
    "Static on support", (("motion.status.2", v.STATIC), ("placement.nature", v.supportive_of(v.ON_SUPPORT)))
)
_IN_THE_HAND = Cell(
    "In target-agent's hand", (("hands.class", v.MANIP_GAINED), ("placement.nature", v.supportive_of(v.IN_HAND)))
)

INTUITION: Mapping[str, Mapping[str, Cell]] = MappingProxyType(
    {
        "make accessible": {
            "see": _nature("see"),
            "reach": _class("Easier", "reach", v.BECOMES_EASIER),
            "object": _STATIC_ON_SUPPORT,
        },
        "hide": {
            "see": _class("Difficult", "see", v.BECOMES_DIFFICULT),
            "reach": _not_relevant("reach"),
            "object": _STATIC_ON_SUPPORT,
        },
        "show": {
            "see": _effortless("Directly", "see"),
            "reach": _not_relevant("reach"),
            "object": _not_relevant("placement"),
        },
        "give": {"see": _nature("see"), "reach": _effortless("No action", "reach"), "object": _IN_THE_HAND},
        "put away": {
            "see": _class("Maintain", "see", v.REMAINS_SAME),
            "reach": _class("Difficult", "reach", v.BECOMES_DIFFICULT),
            "object": _STATIC_ON_SUPPORT,
        },
        "hide away": {
            "see": _class("Difficult", "see", v.BECOMES_DIFFICULT),
            "reach": _class("Difficult", "reach", v.BECOMES_DIFFICULT),
            "object": _STATIC_ON_SUPPORT,
        },
    }
)
"""Table 4, left half: cells by task, in the table's order, and column."""

NEEDED: Mapping[str, int] = MappingProxyType(
    {"make accessible": 4, "hide": 2, "show": 4, "give": 3, "put away": 2, "hide away": 3}
)
"""Table 4, last column: demonstrations after which all three were understood."""

NEEDED_BY_COLUMN: Mapping[str, Mapping[str, int]] = MappingProxyType(
    {
        "make accessible": {"see": 4, "reach": 2},
        "hide": {"see": 2, "reach": 2},
        "show": {"reach": 3, "object": 4},
        "give": {"see": 3},
        "put away": {"see": 2, "reach": 2},
        "hide away": {"see": 3, "reach": 3},
    }
)
"""Table 4, the columns before; cells that are blank in the printed table are left out."""


def understood(understanding: Understanding) -> dict[str, bool]:
    """Which cells of its task's row hold, by column.

    Raises:
        KeyError: The paper has no row for this task.
    """
    return {column: cell.holds(understanding) for column, cell in INTUITION[understanding.task].items()}


# --- The computer that this runs on, in words.

CPUINFO = Path("/proc/cpuinfo")


def machine() -> str:
    """Processor, cores, and system: "AMD EPYC 7571, 2 cores, Linux, Python 3.11.2"."""
    return f"{_processor()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"


def _processor() -> str:
    if CPUINFO.exists():
        lines = (line.partition(":") for line in CPUINFO.read_text(encoding="utf-8").splitlines())
        for name, _, value in lines:
            if name.strip() == "model name":
                return value.strip()
    return platform.processor() or platform.machine()


# --- The clauses as the paper prints them, and how each predicate is read (Eq. 36-44).


@dataclass(frozen=True)
class Published:
    """One predicate of a published clause.

    Args:
        node: The node of the tree that it speaks of.
        printed: What the paper prints; empty where it prints nothing.
        value: How that is read: a value of the node.
        reason: Why it is read so, where the print says something else.
    """

    node: str
    printed: str
    value: str
    reason: str = ""


@dataclass(frozen=True)
class PublishedClause:
    """A clause of the paper.

    Args:
        task: The task.
        where: Its equation.
        predicates: In the order of the print.
    """

    task: str
    where: str
    predicates: tuple[Published, ...]


EFFORT_MAINTAINED = "Maintained is a value of postures (Eq. 15); of an effort it is Remains_Same (Eq. 10)"
RUN_TOGETHER = (
    "the last lines run together in the text that was read (“Final_Initial_Status = On_Support”, no final hands); "
    "they are those of Eq. 38 and 39"
)
GARBLED = "this line cannot be read in the text that we have; Table 4 says Supportive"
NOT_PRINTED = (
    "not in the text that we have; initial and final motion hang below one class, so that the final one cannot be "
    "dropped while the initial one stays"
)

_MAINTAINED = Published("posture.class", "Relative_Posture = Maintained", v.MAINTAINED)
_STATIC_1 = Published("motion.status.1", "Object_Initial_Motion_Status = Static", v.STATIC)
_STATIC_2 = Published("motion.status.2", "Object_Final_Motion_Status = Static", v.STATIC)
_FREE_1 = Published("hands.status.1", "Initial_Hand_Status = Object_Free", v.FREE_OF_OBJECT)
_FREE_2 = Published("hands.status.2", "Final_Hand_Status = Object_Free", v.FREE_OF_OBJECT)
_ON_SUPPORT_1 = Published("placement.status.1", "Object_Initial_Status = On_Support", v.ON_SUPPORT)
_ON_SUPPORT_2 = Published("placement.status.2", "Object_Final_Status = On_Support", v.ON_SUPPORT)
_INCREASED = Published("visibility.class", "Object_Relative_Visibility_Score = Increase", v.INCREASED)
_HARDER_TO_REACH = Published("reach.class", "Relative_Effort_to_Reach = Becomes_Difficult", v.BECOMES_DIFFICULT)
_HARDER_TO_GRASP = Published("grasp.class", "Relative_Effort_to_Grasp = Becomes_Difficult", v.BECOMES_DIFFICULT)
_ENDS_RUN_TOGETHER = (
    _FREE_1,
    Published("hands.status.2", "", v.FREE_OF_OBJECT, RUN_TOGETHER),
    Published("placement.status.1", "Final_Initial_Status = On_Support", v.ON_SUPPORT, RUN_TOGETHER),
    _ON_SUPPORT_2,
)
_WITHOUT_ABILITIES = (_MAINTAINED, _STATIC_1, _STATIC_2, _FREE_1, _FREE_2, _ON_SUPPORT_1, _ON_SUPPORT_2)

_PRINTED = (
    PublishedClause(
        "show",
        "Eq. 37",
        (
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _INCREASED,
            Published("see.action.2", "Action_to_See = No_Action_Required", NO_ACTION),
            _FREE_1,
            _FREE_2,
        ),
    ),
    PublishedClause(
        "hide",
        "Eq. 38",
        (
            Published("posture.value.1", "Human_Initial_Posture = Sitting", v.SITTING),
            Published("posture.value.2", "Human_Final_Posture = Sitting", v.SITTING),
            _STATIC_1,
            _STATIC_2,
            Published("visibility.score.2", "Object_Final_Visibility_Score ≈ 0", NEGLIGIBLE),
            Published("see.class", "Relative_Effort_Class_to_See = Becomes_Difficult", v.BECOMES_DIFFICULT),
            _FREE_1,
            _FREE_2,
            _ON_SUPPORT_1,
            _ON_SUPPORT_2,
        ),
    ),
    PublishedClause(
        "make accessible",
        "Eq. 39",
        (
            Published("reach.class", "Relative_Effort_to_Reach = Becomes_Easier", v.BECOMES_EASIER),
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            Published("grasp.class", "Relative_Effort_to_Grasp = Becomes_Easier", v.BECOMES_EASIER),
            Published("visibility.class", "Object_Relative_Visibility_Score = Increased", v.INCREASED),
            Published("see.nature", "Nature_Effort_Class_to_See = Supportive", v.SUPPORTIVE),
            _FREE_1,
            _FREE_2,
            _ON_SUPPORT_1,
            _ON_SUPPORT_2,
        ),
    ),
    PublishedClause(
        "give",
        "Eq. 40",
        (
            Published("reach.action.2", "Action_to_Reach = No_Action_Required", NO_ACTION),
            _MAINTAINED,
            Published("grasp.action.2", "Action_to_Grasp = No_Action_Required", NO_ACTION),
            _STATIC_1,
            Published("motion.status.2", "", v.STATIC, NOT_PRINTED),
            _INCREASED,
            Published("see.nature", "Native_Hand_Status = Manipulability_Gained", v.SUPPORTIVE, GARBLED),
            Published("hands.class", "Relative_Hand_Status = Manipulability_Gained", v.MANIP_GAINED),
            _ON_SUPPORT_1,
            Published("placement.status.2", "Object_Final_Status = In_Hand", v.IN_HAND),
        ),
    ),
    PublishedClause(
        "put away",
        "Eq. 41",
        (
            _HARDER_TO_REACH,
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _HARDER_TO_GRASP,
            Published("visibility.class", "Relative_Visibility_Score = Decreased", v.DECREASED),
            Published("see.class", "Relative_Effort_to_See = Maintained", v.REMAINS_SAME, EFFORT_MAINTAINED),
            *_ENDS_RUN_TOGETHER,
        ),
    ),
    PublishedClause(
        "hide away",
        "Eq. 42",
        (
            _HARDER_TO_REACH,
            _MAINTAINED,
            _STATIC_1,
            _STATIC_2,
            _HARDER_TO_GRASP,
            Published("visibility.score.2", "Object_Final_Visibility_Score ≈ 0.0", NEGLIGIBLE),
            Published("see.class", "Relative_Effort_to_See = Becomes_Difficult", v.BECOMES_DIFFICULT),
            *_ENDS_RUN_TOGETHER,
        ),
    ),
)
CLAUSES: Mapping[str, PublishedClause] = MappingProxyType({clause.task: clause for clause in _PRINTED})
"""Eq. 37 to 42 by task, in the paper's order."""

SHORT_SHOW = PublishedClause(
    "show",
    "Eq. 36",
    (
        Published("posture.class", "C_RPost = Maintained", v.MAINTAINED),
        Published("motion.status.1", "O_ms¹ = Static", v.STATIC),
        Published("motion.status.2", "O_ms² = Static", v.STATIC),
        Published("visibility.class", "C_RVis = Increasing", v.INCREASED),
        Published("see.action.2", "A_v²(see) = No_Action_Required", NO_ACTION),
        Published("hands.status.1", "H_s¹ = Object_Free", v.FREE_OF_OBJECT),
        Published("hands.status.2", "H_s² = Object_Free", v.FREE_OF_OBJECT),
    ),
)
"""Eq. 36: the clause of Eq. 37 in the notation of Fig. 11."""

WITHOUT_ABILITIES = (
    PublishedClause("make accessible", "Eq. 43", _WITHOUT_ABILITIES),
    PublishedClause("put away", "Eq. 44", _WITHOUT_ABILITIES),
)
"""What is left of two opposite tasks without any ability of the target agent (8.3)."""


# --- One published result beside ours, and the verdict of comparing them.


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
