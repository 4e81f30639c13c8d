"""A pool as numbers: each value is its index in its node's canonical order, unknown is -1."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import STANDARD_TREE, Node
from taskgist.learning.estimate import canonical_key
from taskgist.study.evaluation.pool import Pool
from taskgist.study.evaluation.sample import CLEAN, Sample

Codes = NDArray[np.int32]
UNKNOWN_CODE = -1


@dataclass(frozen=True, eq=False)
class Coded:
    """The vocabulary of a pool.

    Args:
        pool: The pool.
        nodes: The tree's nodes, in the order of the pool's values.
        values: Values of each node that occur in the pool or are declared, in canonical order, which decides ties.
    """

    pool: Pool
    nodes: tuple[Node, ...]
    values: tuple[tuple[str, ...], ...]

    @staticmethod
    def of(pool: Pool) -> Coded:
        """The vocabulary of everything in a pool."""
        nodes = tuple(STANDARD_TREE.node(name) for name in pool.nodes)
        columns = zip(*(sample.values for sample in pool.samples), strict=True) if pool.samples else ((),) * len(nodes)
        values = tuple(
            _ordered({*node.values, *(value for value in column if value is not None)}, node)
            for node, column in zip(nodes, columns, strict=True)
        )
        return Coded(pool, nodes, values)

    def index(self, node: str) -> int:
        """Column of a node."""
        return self.pool.nodes.index(node)

    def code(self, node: str, value: str) -> int:
        """Code of a value of a node."""
        return self.values[self.index(node)].index(value)

    def codes(self, samples: Iterable[Sample]) -> Codes:
        """Codes of samples, (samples, nodes)."""
        tables = [{None: UNKNOWN_CODE, **{value: code for code, value in enumerate(each)}} for each in self.values]
        rows = [[table[value] for table, value in zip(tables, each.values, strict=True)] for each in samples]
        return np.array(rows, dtype=np.int32).reshape(len(rows), len(self.nodes))

    def of_task(self, task: str, condition: str = CLEAN, *, held_out: bool) -> Codes:
        """Codes of a task's demonstrations under a condition, (demonstrations, nodes)."""
        return self.codes(self.pool.of(task, condition, held_out=held_out))


def _ordered(values: set[str], node: Node) -> tuple[str, ...]:
    return tuple(sorted(values, key=lambda value: canonical_key(value, node.values)))
