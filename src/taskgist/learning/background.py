"""The background that is shipped: neutral manipulations, as what people do when they do nothing for anybody.

Things are lifted, tapped, dropped and thrown here, in generated rooms, and explained as demonstrations are. A user's
first task is compared with them; from the second on, tasks are compared with each other as well. Tasks of the paper are
not among them: whoever teaches *hide* shall not compete with ours.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
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

NEUTRAL = ""
"""Name of the kind of neutral manipulations in evidence: the empty one, which no task has."""
FORMAT = "taskgist background 1"
SHIPPED = Path(__file__).parent.parent / "data" / "neutral.json.gz"
HINT = "install taskgist anew, or make it again: python -m tools.neutral_background"


@dataclass(frozen=True)
class Background:
    """Effects of demonstrations that belong to no task.

    Args:
        context: Under what they were explained.
        effects: Known values of each, of the nodes that literals are about; equal ones stand side by side.
    """

    context: Context
    effects: tuple[FrozenMap[str, str], ...]

    @staticmethod
    def of(context: Context, demonstrations: Iterable[Effects], tree: HypothesisTree = STANDARD_TREE) -> Background:
        """The background of explained demonstrations, in an order of its own."""
        told = {vocabulary.node.name for vocabulary in vocabularies(tree)}
        rows = [{name: value for name, value in each.items() if name in told} for each in demonstrations]
        return Background(context, tuple(map(FrozenMap, sorted(rows, key=lambda row: sorted(row.items())))))

    def to_json(self) -> dict[str, Any]:
        """Plain data: values by node, and each different demonstration as a count and indices, −1 for unknown."""
        values: dict[str, list[str]] = {}
        for row in self.effects:
            for name, value in row.items():
                if value not in values.setdefault(name, []):
                    values[name].append(value)
        nodes = sorted(values)
        table = {name: sorted(values[name]) for name in nodes}
        counted = Counter(
            tuple(table[name].index(row[name]) if name in row else -1 for name in nodes) for row in self.effects
        )
        return {
            "format": FORMAT,
            "settings_digest": self.context.settings_digest,
            "tree_version": self.context.tree_version,
            "values": table,
            "rows": [[count, *row] for row, count in sorted(counted.items())],
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
            rows = [(_row(indices, table), count) for count, *indices in document["rows"]]
            return Background(context, tuple(row for row, count in rows for _ in range(count)))
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise KnowledgeError(f"not a background: {error!r}", where=where, hint=HINT) from error


def _row(indices: Sequence[int], table: Mapping[str, Sequence[str]]) -> FrozenMap[str, str]:
    named = zip(table.items(), indices, strict=True)
    return FrozenMap({name: values[index] for (name, values), index in named if index >= 0})


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
