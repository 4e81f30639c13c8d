"""How many demonstrations it takes to reach the intuitive understanding of Table 4 (8.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded, Codes
from taskgist.study.evaluation.draws import drawn
from taskgist.study.evaluation.learned import Learned, Truths, learned
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.rules import PAPER, Judging
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.spread import HIGH, LOW, rounded
from taskgist.study.intuition import INTUITION, NEEDED, NEEDED_BY_COLUMN, Cell

ALL = "all"
"""Column that asks for all three cells of a row."""


@dataclass(frozen=True)
class Waiting:
    """How many demonstrations it takes, over all draws; None: never within the draw."""

    median: int | None
    low: int | None
    """10 % quantile."""
    high: int | None
    """90 % quantile."""

    @staticmethod
    def of(counts: ArrayLike) -> Waiting:
        """Of numbers of demonstrations, infinite where a draw never gets there."""
        found = np.quantile(np.asarray(counts, dtype=np.float64), (0.5, LOW, HIGH), method="inverted_cdf")
        return Waiting(*(int(count) if np.isfinite(count) else None for count in found))


@dataclass(frozen=True)
class Needed:
    """Demonstrations until a cell of Table 4 holds.

    Attributes:
        task: Name of the task.
        column: Its column, or ``ALL``.
        wording: The paper's words.
        paper: Demonstrations that the paper needed, where the table says so.
        needed: The first demonstration from which on it holds to the end of the draw, as in Table 4; over all draws.
        ever: Share of draws in which it ever held, be it lost again.
        curve: Share of draws in which it held after 1, 2, 3 ... demonstrations.
        agreeing: Share of single demonstrations that show what must be kept; None where nothing must.
        alike: Share of the most frequent value of what must be pruned: near 1, hardly anything tells that it varies.
            None where nothing must.
    """

    task: str
    column: str
    wording: str
    paper: int | None
    needed: Waiting
    ever: float
    curve: tuple[float, ...]
    agreeing: float | None = None
    alike: float | None = None


@dataclass(frozen=True)
class Needs(Result):
    """All tasks and columns."""

    rows: tuple[Needed, ...]

    def row(self, task: str, column: str = ALL) -> Needed:
        """One of the rows."""
        return next(each for each in self.rows if (each.task, each.column) == (task, column))


def demonstrations_needed(
    coded: Coded, *, draws: int, seed: int, judging: Judging = PAPER, condition: str = CLEAN
) -> Needs:
    """Learn each task in many random orders, and watch when it is understood.

    Args:
        coded: A pool.
        draws: Random orders of each task.
        seed: Their seed.
        judging: How counts become verdicts; one that does not ask.
        condition: Under which demonstrations were watched.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    rows: list[Needed] = []
    for task in (task for task in INTUITION if task in coded.pool.tasks):
        orders = drawn(coded, task, draws=draws, seed=seed, condition=condition)
        rows += rows_of(task, learned(orders, coded, judging), coded)
    return Needs(tuple(rows))


def rows_of(task: str, known: Learned, coded: Coded) -> Iterator[Needed]:
    """A row for each column of the task, and one for all of them."""
    single = np.concatenate([coded.of_task(task, held_out=held_out) for held_out in (False, True)])
    held = {column: known.holds(cell, coded) for column, cell in INTUITION[task].items()}
    for column, cell in INTUITION[task].items():
        row = _row(task, column, cell.wording, NEEDED_BY_COLUMN[task].get(column), held[column])
        yield replace(row, agreeing=_agreeing(cell, coded, single), alike=_alike(cell, coded, single))
    yield _row(task, ALL, "all three", NEEDED[task], np.all(list(held.values()), axis=0))


def lasting_from(held: Truths) -> NDArray[np.float64]:
    """The first demonstration from which on each draw holds to its end, (draws,); infinite where it does not."""
    steps = np.arange(1, held.shape[1] + 1)
    last_without = np.where(held, 0, steps).max(axis=1)
    return np.where(held[:, -1], last_without + 1.0, np.inf)


def _row(task: str, column: str, wording: str, paper: int | None, held: Truths) -> Needed:
    return Needed(
        task=task,
        column=column,
        wording=wording,
        paper=paper,
        needed=Waiting.of(lasting_from(held)),
        ever=rounded(held.any(axis=1).mean()),
        curve=tuple(rounded(share) for share in held.mean(axis=0)),
    )


def _agreeing(cell: Cell, coded: Coded, single: Codes) -> float | None:
    """Share of demonstrations, (demonstrations, nodes), with all values that must be kept."""
    shown = [single[:, coded.index(node)] == coded.code(node, value) for node, value in cell.kept]
    return rounded(np.all(shown, axis=0).mean()) if shown else None


def _alike(cell: Cell, coded: Coded, single: Codes) -> float | None:
    """Share of the most frequent value of the node that must be pruned, among the known ones."""
    if not cell.pruned:
        return None
    (node,) = cell.pruned
    known = single[:, coded.index(node)]
    known = known[known != UNKNOWN_CODE]
    return rounded(np.bincount(known).max() / len(known)) if len(known) else None
