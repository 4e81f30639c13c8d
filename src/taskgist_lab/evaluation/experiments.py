"""Experiments: how many demonstrations it takes (Table 4), and whether what is learned holds in others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.errors import InputError
from taskgist_lab.evaluation.learner import (
    PAPER,
    UNKNOWN_CODE,
    Coded,
    Codes,
    Judging,
    Learned,
    in_random_order,
    learned,
    sizes_within,
    truths,
)
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.pool import HELD_OUT_EVERY
from taskgist_lab.evaluation.values import CLEAN, HIGH, LOW, Result, Spread, rounded
from taskgist_lab.paper.published import INTUITION, NEEDED, NEEDED_BY_COLUMN, Cell

# --- Where learned clauses hold: in held-out demonstrations of their own task, and in those of the others.
#
# Rows are the clauses of the learned tasks, columns the demonstrations that are judged; each task weighs the same,
# however many of its demonstrations were held out. *Recall* is the share of the task's own demonstrations in which
# its clause holds; *precision* the share of its own among those in which it holds, 0 where it holds nowhere. A clause
# that is unknown in a demonstration, because something was not observed, does not hold there.

Held = NDArray[np.int8]
"""Whether clauses hold in demonstrations: 1 true, 0 false, -1 unknown, (runs, demonstrations)."""


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
    task_of: Indices

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

    def shares(self, held: Held, truth: int) -> Array:
        """Share of each task's demonstrations in which each run's clause is of that truth, (runs, tasks)."""
        alike = held == truth
        shares = [alike[:, self.task_of == task].mean(axis=1) for task in range(len(self.tasks))]
        return np.stack(shares, axis=1)


@dataclass(frozen=True)
class Scores:
    """How well one task's clause tells its demonstrations from others, over runs."""

    recall: Spread
    precision: Spread
    """0 where the clause holds nowhere."""
    f1: Spread
    """Harmonic mean of both; 0 where the clause holds in none of its own."""


@dataclass(frozen=True)
class Table:
    """Clauses of tasks (rows) in demonstrations of tasks (columns), mean over runs.

    Attributes:
        after: Demonstrations that were learned from.
        part: Which part of the clause.
        tasks: Names of rows and columns.
        true: Share of demonstrations in which the clause holds, by row and column.
        unknown: Share in which that is unknown.
        scores: By task.
        overall: Means over tasks, with their spread over runs.
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
        held: By learned task, whether the clause of each run holds in each demonstration.
        judges: The demonstrations.
        after: Demonstrations that were learned from.
        part: Which part of the clause.
    """
    true = {task: judges.shares(held[task], 1) for task in judges.tasks}
    unknown = {task: judges.shares(held[task], UNKNOWN_CODE) for task in judges.tasks}
    by_task = {task: scores_of(true[task], own) for own, task in enumerate(judges.tasks)}
    means = np.mean(list(by_task.values()), axis=0)
    return Table(
        after=after,
        part=part,
        tasks=judges.tasks,
        true=tuple(_means(true[task]) for task in judges.tasks),
        unknown=tuple(_means(unknown[task]) for task in judges.tasks),
        scores={task: Scores(*map(Spread.of, each)) for task, each in by_task.items()},
        overall=Scores(*map(Spread.of, means)),
    )


def scores_of(true: Array, own: int) -> Array:
    """Scores of one task's clauses, (recall, precision, f1) × runs.

    Args:
        true: Share of each task's demonstrations in which they hold, (runs, tasks).
        own: Index of the task.
    """
    recall, everywhere = true[:, own], true.sum(axis=1)
    precision = np.divide(recall, everywhere, out=np.zeros(len(true)), where=everywhere > 0)
    both = recall + precision
    f1 = np.divide(2 * recall * precision, both, out=np.zeros(len(true)), where=both > 0)
    return np.stack((recall, precision, f1))


def _means(shares: Array) -> tuple[float, ...]:
    return tuple(rounded(each) for each in shares.mean(axis=0))


# --- How many demonstrations it takes to reach the intuitive understanding of Table 4 (8.2).

ALL = "all"
"""Column that asks for all three cells of a row."""


@dataclass(frozen=True)
class Waiting:
    """How many demonstrations it takes, over all runs; None: never within the run."""

    median: int | None
    low: int | None
    """10 % quantile."""
    high: int | None
    """90 % quantile."""

    @staticmethod
    def of(counts: ArrayLike) -> Waiting:
        """Of numbers of demonstrations, infinite where a run never gets there."""
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
        needed: The first demonstration from which on it holds to the end of the run, as in Table 4; over all runs.
        ever: Share of runs in which it ever held, be it lost again.
        curve: Share of runs in which it held after 1, 2, 3 ... demonstrations.
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
    coded: Coded, *, runs: int, seed: int, judging: Judging = PAPER, condition: str = CLEAN
) -> Needs:
    """Learn each task in many random orders, and watch when it is understood.

    Args:
        coded: A pool.
        runs: Random orders of each task.
        seed: Their seed.
        judging: How counts become verdicts; one that does not ask.
        condition: Under which demonstrations were watched.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    rows: list[Needed] = []
    for task in (task for task in INTUITION if task in coded.pool.tasks):
        orders = in_random_order(coded, task, runs=runs, seed=seed, condition=condition)
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


def lasting_from(held: Mask) -> Array:
    """The first demonstration from which on each run holds to its end, (runs,); infinite where it does not."""
    steps = np.arange(1, held.shape[1] + 1)
    last_without = np.where(held, 0, steps).max(axis=1)
    return np.where(held[:, -1], last_without + 1.0, np.inf)


def _row(task: str, column: str, wording: str, paper: int | None, held: Mask) -> Needed:
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


# --- Settings: what is wrong with the demonstrations that are learned from.

WRONG_PERCENT = (5, 10, 20)


@dataclass(frozen=True)
class Setting:
    """What is wrong with the demonstrations.

    Args:
        name: Its name.
        text: In a few words.
        condition: Under which they are watched.
        wrong_share: Probability of each to be a wrong one.
    """

    name: str
    text: str
    condition: str = CLEAN
    wrong_share: float = 0.0


SETTINGS = (
    *(Setting(each.name, each.text, each.name) for each in CONDITIONS.values()),
    *(
        Setting(f"wrong-{percent}", f"{percent} % wrong demonstrations", wrong_share=percent / 100)
        for percent in WRONG_PERCENT
    ),
)
"""All settings, the clean one first."""


# --- Do learned clauses hold in demonstrations that they were not learned from, and in those alone? And if not, why?

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
    """The value that the clause wants, where runs differ the most frequent one."""
    share: float
    """Share of runs and demonstrations in which the clause has the predicate and it is false."""


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


def transfer(coded: Coded, *, runs: int, seed: int, judging: Judging = PAPER) -> Transfer:
    """Learn each task in many random orders; judge all held-out demonstrations by the clauses.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from.
    """
    judges = HeldOut.of(coded)
    orders = {task: in_random_order(coded, task, runs=runs, seed=seed) for task in coded.pool.tasks}
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


def mask_of(known: Learned, part: str) -> Mask:
    """Nodes of a part of the clauses, (runs, demonstrations, nodes)."""
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
