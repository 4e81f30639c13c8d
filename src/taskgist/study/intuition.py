"""The intuitive understanding of each task (8.2, Table 4), as predicates over what was learned.

The paper compares what was learned with what people would say a task is about, in three columns: for the target
agent's ability to *see* and to *reach*, and for the state of the *object*. It says so in words; here each cell says
which nodes of the tree must be kept, with which value, and which must have been pruned.

**The level matters.** A task is understood at a level of abstraction. *Supportive* is the nature of a change: as long
as all demonstrations agree on *Becomes_Easier*, too, the learner still believes that it must become easier, and has
not reached the intuitive understanding yet. So such a cell holds when its node is the deepest one kept that speaks of
the final state. (So higher abstraction takes more demonstrations, as the paper finds: *Difficult* is reached only when
efforts have been seen to differ.) *Directly* and *No action* name values at the bottom of the tree, and hold as soon as
these are kept. The object's states are where it ends, wherever it was: the nature of its placement names that status
(Eq. 21), and its final motion must be kept.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from taskgist.facts import vocabulary as v
from taskgist.learning import Understanding

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
