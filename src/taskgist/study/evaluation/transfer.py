"""Do learned clauses hold in demonstrations that they were not learned from, and in those alone? And if not, why?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded
from taskgist.study.evaluation.draws import drawn, sizes_within
from taskgist.study.evaluation.holding import Held, HeldOut, Table, table_of
from taskgist.study.evaluation.learned import Learned, Truths, learned, truths
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.rules import PAPER, Judging
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.spread import rounded

SIZES = (1, 2, 3, 5, 10)
"""Demonstrations after which clauses are judged."""
CLAUSE, EFFECTS = "clause", "effects"
"""Parts: the paper's whole clause, effects and preconditions together; and its effects alone."""
PARTS = (CLAUSE, EFFECTS)
WORTH_TELLING = 0.02
"""Misses in a smaller share of demonstrations are not told."""


@dataclass(frozen=True)
class Miss:
    """A predicate of a task's clause that is false in held-out demonstrations of that very task."""

    task: str
    node: str
    value: str
    """The value that the clause wants, where draws differ the most frequent one."""
    share: float
    """Share of draws and demonstrations in which the clause has the predicate and it is false."""


@dataclass(frozen=True)
class Transfer(Result):
    """Where clauses hold.

    Attributes:
        tables: For each size and part.
        by_means: Share in which the whole clause holds after the most demonstrations, by task and means.
        misses: Why clauses fail in demonstrations of their own task, after the most demonstrations.
    """

    tables: tuple[Table, ...]
    by_means: Mapping[str, Mapping[str, float]]
    misses: tuple[Miss, ...]

    @property
    def sizes(self) -> tuple[int, ...]:
        """Demonstrations after which there are tables."""
        return tuple(dict.fromkeys(each.after for each in self.tables))

    def table(self, after: int, part: str) -> Table:
        """One of the tables."""
        return next(each for each in self.tables if (each.after, each.part) == (after, part))


def transfer(coded: Coded, *, draws: int, seed: int, judging: Judging = PAPER) -> Transfer:
    """Learn each task in many random orders; judge all held-out demonstrations by the clauses.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    judges = HeldOut.of(coded)
    orders = {task: drawn(coded, task, draws=draws, seed=seed) for task in coded.pool.tasks}
    sizes = sizes_within(SIZES, orders.values())
    known = {task: learned(order, coded, judging) for task, order in orders.items()}
    last = {task: held_in(each, judges, sizes[-1], CLAUSE) for task, each in known.items()}
    return Transfer(
        tables=tuple(_table(known, judges, after, part) for after in sizes for part in PARTS),
        by_means={task: _by_means(coded, judges, task, held) for task, held in last.items()},
        misses=tuple(miss for task, each in known.items() for miss in _misses(coded, judges, task, each, sizes[-1])),
    )


def held_in(known: Learned, judges: HeldOut, after: int, part: str) -> Held:
    """Whether the clauses after so many demonstrations hold in demonstrations."""
    return truths(mask_of(known, part)[:, after - 1], known.values[:, after - 1], judges.codes)


def mask_of(known: Learned, part: str) -> Truths:
    """Nodes of a part of the clauses, (draws, demonstrations, nodes)."""
    return known.effects() if part == EFFECTS else known.effects() | known.preconditions()


def _table(known: Mapping[str, Learned], judges: HeldOut, after: int, part: str) -> Table:
    held = {task: held_in(each, judges, after, part) for task, each in known.items()}
    return table_of(held, judges, after=after, part=part)


def _by_means(coded: Coded, judges: HeldOut, task: str, held: Held) -> dict[str, float]:
    means = np.array([each.means for each in coded.pool.of(task, CLEAN, held_out=True)])
    own = held[:, judges.task_of == judges.tasks.index(task)] == 1
    return {str(name): rounded(own[:, means == name].mean()) for name in np.unique(means)}


def _misses(coded: Coded, judges: HeldOut, task: str, known: Learned, after: int) -> list[Miss]:
    """The predicates that fail, most frequent first."""
    mask, values = mask_of(known, CLAUSE)[:, after - 1], known.values[:, after - 1]
    own = judges.codes[judges.task_of == judges.tasks.index(task)]
    failing = (own != values[:, None]) & (own != UNKNOWN_CODE) & mask[:, None]
    shares = failing.mean(axis=(0, 1))
    return [
        Miss(task, coded.nodes[node].name, _usual(coded, node, values[mask[:, node], node]), rounded(shares[node]))
        for node in np.argsort(-shares, kind="stable")
        if shares[node] >= WORTH_TELLING
    ]


def _usual(coded: Coded, node: int, codes: np.ndarray) -> str:
    return coded.values[node][int(np.bincount(codes).argmax())]
