"""The background that is shipped: neutral manipulations, as what people do when they do nothing for anybody.

Things are lifted, tapped, dropped, dumped, thrown, moved, turned and stacked here, in generated rooms, and explained as
demonstrations are. A user's first task is compared with them; from the second on, tasks are compared with each other as
well. Tasks of the paper are not among them: whoever teaches *hide* shall not compete with ours.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from taskgist.common.documents import read_packed_json
from taskgist.common.frozen import FrozenMap
from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.evidence import Effects
from taskgist.learning.explanation import Context
from taskgist.learning.literals import vocabularies
from taskgist.settings import DEFAULT

NEUTRAL = " "
"""How the names of kinds of neutral manipulations begin in evidence; that of a task begins with no space."""
FORMAT = "taskgist background 1"
SHIPPED = Path(__file__).parent.parent / "data" / "neutral.json.gz"
HINT = "install taskgist anew, or make it again: python -m tools.neutral_background"

Rows = tuple[FrozenMap[str, str], ...]
"""Known values of demonstrations, of the nodes that literals are about; equal ones stand side by side."""


@dataclass(frozen=True)
class Background:
    """Effects of demonstrations that belong to no task.

    Args:
        context: Under what they were explained.
        manipulations: By what was done. Each is a kind of background of its own: together they would weigh no more than
            one task does, and what they have in common would soon be believed to be a meaning.
    """

    context: Context
    manipulations: FrozenMap[str, Rows]

    @staticmethod
    def of(
        context: Context, demonstrations: Mapping[str, Iterable[Effects]], tree: HypothesisTree = STANDARD_TREE
    ) -> Background:
        """The background of explained demonstrations by what was done, in an order of its own."""
        told = {vocabulary.node.name for vocabulary in vocabularies(tree)}
        return Background(
            context, FrozenMap({name: _rows(demonstrations[name], told) for name in sorted(demonstrations)})
        )

    @property
    def kinds(self) -> dict[str, Rows]:
        """The manipulations as kinds of evidence."""
        return {NEUTRAL + name: rows for name, rows in self.manipulations.items()}

    def to_json(self) -> dict[str, Any]:
        """Plain data: values by node, and each different demonstration as a count and indices, −1 for unknown."""
        values: dict[str, set[str]] = {}
        for rows in self.manipulations.values():
            for name, value in (pair for row in rows for pair in row.items()):
                values.setdefault(name, set()).add(value)
        table = {name: sorted(values[name]) for name in sorted(values)}
        return {
            "format": FORMAT,
            "settings_digest": self.context.settings_digest,
            "tree_version": self.context.tree_version,
            "values": table,
            "manipulations": {name: _counted(rows, table) for name, rows in self.manipulations.items()},
        }

    @staticmethod
    def from_json(document: Mapping[str, Any], *, where: Path | None = None) -> Background:
        """Read back what ``to_json`` gave.

        Raises:
            KnowledgeError: It is something else.
        """
        try:
            if document["format"] != FORMAT:
                raise ValueError(f"format {document['format']!r}")
            context = Context(document["settings_digest"], document["tree_version"])
            table: Mapping[str, Sequence[str]] = document["values"]
            manipulations = {
                name: _rows((_row(indices, table) for count, *indices in rows for _ in range(count)), set(table))
                for name, rows in document["manipulations"].items()
            }
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise KnowledgeError(f"not a background: {error!r}", where=where, hint=HINT) from error
        return Background(context, FrozenMap(manipulations))


def _rows(demonstrations: Iterable[Effects], told: Collection[str]) -> Rows:
    rows = [{name: value for name, value in each.items() if name in told} for each in demonstrations]
    return tuple(map(FrozenMap, sorted(rows, key=lambda row: sorted(row.items()))))


def _counted(rows: Rows, table: Mapping[str, Sequence[str]]) -> list[list[int]]:
    counted = Counter(
        tuple(values.index(row[name]) if name in row else -1 for name, values in table.items()) for row in rows
    )
    return [[count, *row] for row, count in sorted(counted.items())]


def _row(indices: Sequence[int], table: Mapping[str, Sequence[str]]) -> Effects:
    named = zip(table.items(), indices, strict=True)
    return {name: values[index] for (name, values), index in named if index >= 0}


@cache
def shipped_background() -> Background:
    """The neutral manipulations that are shipped.

    Raises:
        KnowledgeError: The file is missing or damaged.
    """
    document = read_packed_json(
        SHIPPED, most_bytes=DEFAULT.limits.document_bytes, problem="not a background", hint=HINT, error=KnowledgeError
    )
    return Background.from_json(document, where=SHIPPED)
