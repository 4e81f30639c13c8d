"""How many demonstrations it takes to reach the intuitive understanding of Table 4 (8.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from taskgist.study.evaluation.coded import UNKNOWN_CODE, Coded, Codes
from taskgist.study.evaluation.draws import drawn
from taskgist.study.evaluation.learned import Learned, Truths, learned
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.rules import PAPER, Judging
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.spread import Spread, rounded
from taskgist.study.intuition import INTUITION, NEEDED, NEEDED_BY_COLUMN, Cell

ALL = "all"
"""Column that asks for all three cells of a row."""


@dataclass(frozen=True)
class Needed:
    """Demonstrations until a cell of Table 4 holds.

    Attributes:
        task: Name of the task.
        column: Its column, or ``ALL``.
        wording: The paper's words.
        paper: Demonstrations that the paper needed, where the table says so.
        needed: Demonstrations after which it held for the first time, over the draws in which it ever did.
        median: Median over all draws; None where it is beyond the longest draw.
        reached: Share of draws in which it ever held.
        curve: Share of draws in which it held after 1, 2, 3 ... demonstrations.
        agreeing: Share of single demonstrations that show what must be kept; None where nothing must.
        alike: Share of the most frequent value of what must be pruned: near 1, hardly anything tells that it varies.
            None where nothing must.
    """

    task: str
    column: str
    wording: str
    paper: int | None
    needed: Spread
    median: float | None
    reached: float
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


def first_held(held: Truths) -> np.ndarray:
    """Demonstrations after which each draw holds for the first time, (draws,); NaN where it never does."""
    return np.where(held.any(axis=1), held.argmax(axis=1) + 1.0, np.nan)


def _row(task: str, column: str, wording: str, paper: int | None, held: Truths) -> Needed:
    first = first_held(held)
    median = float(np.median(np.where(np.isnan(first), np.inf, first)))
    return Needed(
        task=task,
        column=column,
        wording=wording,
        paper=paper,
        needed=Spread.of(first),
        median=median if np.isfinite(median) else None,
        reached=rounded(held.any(axis=1).mean()),
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
