"""Where learned clauses hold: in held-out demonstrations of their own task, and in those of the others.

Rows are the clauses of the learned tasks, columns the demonstrations that are judged; each task weighs the same,
however many of its demonstrations were held out. *Recall* is the share of the task's own demonstrations in which its
clause holds; *precision* the share of its own among those in which it holds, 0 where it holds nowhere. A clause that
is unknown in a demonstration, because something was not observed, does not hold there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import InputError
from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded, Codes
from taskgist.study.evaluation.pool import HELD_OUT_EVERY
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.spread import Spread, rounded

Held = NDArray[np.int8]
"""Whether clauses hold in demonstrations: 1 true, 0 false, -1 unknown, (draws, demonstrations)."""


@dataclass(frozen=True, eq=False)
class HeldOut:
    """Demonstrations that judge.

    Attributes:
        tasks: Names of the tasks.
        codes: Codes, (demonstrations, nodes).
        task_of: Index of each demonstration's task, (demonstrations,).
    """

    tasks: tuple[str, ...]
    codes: Codes
    task_of: NDArray[np.intp]

    @staticmethod
    def of(coded: Coded, condition: str = CLEAN) -> HeldOut:
        """All held-out demonstrations of a pool under a condition.

        Raises:
            InputError: None of a task were held out.
        """
        codes = [coded.of_task(task, condition, held_out=True) for task in coded.pool.tasks]
        for task, of_task in zip(coded.pool.tasks, codes, strict=True):
            if not len(of_task):
                hint = f"make more demonstrations: every {HELD_OUT_EVERY}rd is held out"
                raise InputError("no demonstrations held out", where=f"{task}, {condition}", field="pool", hint=hint)
        task_of = np.repeat(np.arange(len(codes)), [len(each) for each in codes])
        return HeldOut(coded.pool.tasks, np.concatenate(codes), task_of)

    def shares(self, held: Held, truth: int) -> NDArray[np.float64]:
        """Share of each task's demonstrations in which each draw's clause is of that truth, (draws, tasks)."""
        alike = held == truth
        shares = [alike[:, self.task_of == task].mean(axis=1) for task in range(len(self.tasks))]
        return np.stack(shares, axis=1)


@dataclass(frozen=True)
class Scores:
    """How well one task's clause tells its demonstrations from others, over draws."""

    recall: Spread
    precision: Spread
    """0 where the clause holds nowhere."""
    f1: Spread
    """Harmonic mean of both; 0 where the clause holds in none of its own."""


@dataclass(frozen=True)
class Table:
    """Clauses of tasks (rows) in demonstrations of tasks (columns), mean over draws.

    Attributes:
        after: Demonstrations that were learned from.
        part: Which part of the clause.
        tasks: Names of rows and columns.
        true: Share of demonstrations in which the clause holds, by row and column.
        unknown: Share in which that is unknown.
        scores: By task.
        overall: Means over tasks, with their spread over draws.
    """

    after: int
    part: str
    tasks: tuple[str, ...]
    true: tuple[tuple[float, ...], ...]
    unknown: tuple[tuple[float, ...], ...]
    scores: Mapping[str, Scores]
    overall: Scores


def table_of(held: Mapping[str, Held], judges: HeldOut, *, after: int, part: str) -> Table:
    """The table of clauses that hold in these demonstrations.

    Args:
        held: By learned task, whether the clause of each draw holds in each demonstration.
        judges: The demonstrations.
        after: Demonstrations that were learned from.
        part: Which part of the clause.
    """
    true = {task: judges.shares(held[task], 1) for task in judges.tasks}
    unknown = {task: judges.shares(held[task], UNKNOWN_CODE) for task in judges.tasks}
    by_draw = {task: scores_of(true[task], own) for own, task in enumerate(judges.tasks)}
    means = np.mean(list(by_draw.values()), axis=0)
    return Table(
        after=after,
        part=part,
        tasks=judges.tasks,
        true=tuple(_means(true[task]) for task in judges.tasks),
        unknown=tuple(_means(unknown[task]) for task in judges.tasks),
        scores={task: Scores(*map(Spread.of, each)) for task, each in by_draw.items()},
        overall=Scores(*map(Spread.of, means)),
    )


def scores_of(true: NDArray[np.float64], own: int) -> NDArray[np.float64]:
    """Scores of one task's clauses, (recall, precision, f1) × draws.

    Args:
        true: Share of each task's demonstrations in which they hold, (draws, tasks).
        own: Index of the task.
    """
    recall, everywhere = true[:, own], true.sum(axis=1)
    precision = np.divide(recall, everywhere, out=np.zeros(len(true)), where=everywhere > 0)
    both = recall + precision
    f1 = np.divide(2 * recall * precision, both, out=np.zeros(len(true)), where=both > 0)
    return np.stack((recall, precision, f1))


def _means(shares: NDArray[np.float64]) -> tuple[float, ...]:
    return tuple(rounded(each) for each in shares.mean(axis=0))
