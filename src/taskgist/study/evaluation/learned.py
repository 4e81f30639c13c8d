"""What is understood after each demonstration of each draw: the learner of ``learning``, in arrays.

It follows ``learning.understand`` and ``learning.clause_of`` node by node; tests hold it to them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.facts import Node
from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded, Codes
from taskgist.study.evaluation.oracle import Oracle
from taskgist.study.evaluation.rules import CONFUSING, PAPER, RELEVANT, Judging
from taskgist.study.evaluation.tally import Tally, tally
from taskgist.study.intuition import Cell

Truths = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Learned:
    """What is understood, (draws, demonstrations, nodes) each.

    Attributes:
        nodes: The tree's nodes.
        kept: Whether each node belongs to the largest consistent subtree.
        values: Code of each node's desired value.
        asked: Questions asked so far, (draws, demonstrations).
    """

    nodes: tuple[Node, ...]
    kept: Truths
    values: Codes
    asked: NDArray[np.int32]

    def effects(self) -> Truths:
        """Which nodes are effects of the clause: the deepest kept ones, initial ones left aside."""
        return self._deepest(np.array([node.instant != 1 for node in self.nodes]))

    def preconditions(self) -> Truths:
        """Which nodes are preconditions of the clause: the deepest kept initial ones."""
        return self._deepest(np.array([node.instant == 1 for node in self.nodes]))

    def holds(self, cell: Cell, coded: Coded) -> Truths:
        """Whether a cell of Table 4 holds, (draws, demonstrations)."""
        true = np.ones(self.kept.shape[:2], dtype=bool)
        for name, value in cell.kept:
            column = coded.index(name)
            true &= self.kept[:, :, column] & (self.values[:, :, column] == coded.code(name, value))
        for name in cell.pruned:
            true &= ~self.kept[:, :, coded.index(name)]
        return true

    def _deepest(self, chosen: Truths) -> Truths:
        """The chosen nodes that are kept and have no chosen, kept child."""
        kept = self.kept & chosen
        deepest = kept.copy()
        for column, parent in enumerate(_parents(self.nodes)):
            if parent is not None:
                deepest[:, :, parent] &= ~kept[:, :, column]
        return deepest


def learned(drawn: Codes, coded: Coded, judging: Judging = PAPER, oracle: Oracle | None = None) -> Learned:
    """Learn along draws.

    Args:
        drawn: Codes, (draws, demonstrations, nodes).
        coded: The pool that they come from.
        judging: How counts become verdicts.
        oracle: Who answers, where the judging asks.
    """
    return from_tally(tally(drawn), coded, judging, oracle)


def from_tally(counted: Tally, coded: Coded, judging: Judging, oracle: Oracle | None = None) -> Learned:
    """What is understood from counts; see ``learned``."""
    verdicts = judging.verdicts(counted, coded.nodes)
    if judging.asks:
        assert oracle is not None, "somebody must answer"
        return _asking(counted, coded.nodes, verdicts, oracle)
    kept = verdicts == RELEVANT
    for column, parent in enumerate(_parents(coded.nodes)):
        if parent is not None:
            kept[:, :, column] &= kept[:, :, parent]
    return Learned(coded.nodes, kept, counted.best, np.zeros(kept.shape[:2], dtype=np.int32))


def _asking(counted: Tally, nodes: tuple[Node, ...], verdicts: NDArray[np.int8], oracle: Oracle) -> Learned:
    """Whatever is confusing below what is kept is asked at once, and stays as answered."""
    draws, demonstrations, count = verdicts.shape
    kept = np.zeros(verdicts.shape, dtype=bool)
    answered = np.zeros((draws, count), dtype=bool)
    values = counted.best.copy()
    asked = np.zeros((draws, demonstrations), dtype=np.int32)
    for step in range(demonstrations):
        for column, parent in enumerate(_parents(nodes)):
            above = np.ones(draws, dtype=bool) if parent is None else kept[:, step, parent]
            answered[:, column] |= above & (verdicts[:, step, column] == CONFUSING)
            relevant = np.where(answered[:, column], oracle.kept[column], verdicts[:, step, column] == RELEVANT)
            kept[:, step, column] = above & relevant
        told = answered & oracle.kept & (oracle.values != UNKNOWN_CODE)
        values[:, step] = np.where(told, oracle.values, values[:, step])
        asked[:, step] = answered.sum(axis=1)
    return Learned(nodes, kept, values, asked)


def _parents(nodes: tuple[Node, ...]) -> list[int | None]:
    """Column of each node's parent."""
    columns = {node.name: column for column, node in enumerate(nodes)}
    return [None if node.parent is None else columns[node.parent] for node in nodes]


def truths(mask: Truths, values: Codes, samples: Codes) -> NDArray[np.int8]:
    """Whether clauses hold in demonstrations: 1 true, 0 false, -1 unknown, (clauses, demonstrations).

    Args:
        mask: Nodes of each clause, (clauses, nodes).
        values: Code of the value that each must have, (clauses, nodes).
        samples: Codes of demonstrations, (demonstrations, nodes).
    """
    false = np.zeros((len(mask), len(samples)), dtype=bool)
    unknown = false.copy()
    for node in np.flatnonzero(mask.any(axis=0)):
        meant, has = mask[:, [node]], samples[:, node]
        missing = has == UNKNOWN_CODE
        unknown |= meant & missing
        false |= meant & ~missing & (has != values[:, [node]])
    return np.where(false, 0, np.where(unknown, UNKNOWN_CODE, 1)).astype(np.int8)
