"""How well the learner of whole clauses does beside the paper's rule, on demonstrations that were held out.

Both learn each task in the same random orders, cleanly, with one wrong demonstration in ten, and under each condition
that the pool has beside the clean one, such as a tracker's noise or label ends that are off. They are judged twice, by
clean demonstrations: by the one task that a held-out demonstration was played as (as in ``experiments.transfer``), and
by all tasks that it fulfils, so that a *hide away* in which *hide* holds is no mistake. The clauses are compared with
the shipped neutral manipulations, and with none, one, two or all of the pool's other tasks: what a user has when the
first, second, third and last task is taught.

**What the facts allow.** Beside them stands a random forest that is told more than any learner of ours: all tasks that
each demonstration fulfils, of as many demonstrations of each of the tasks. What it misses after fifty is hardly in the
facts.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.learning.background import shipped_background
from taskgist.learning.clauses import ClausePosterior, learn_clauses
from taskgist.learning.evidence import Effects, Evidence
from taskgist.learning.literals import SetLiteral, vocabularies
from taskgist_lab.evaluation.experiments import CLAUSE, HeldOut, held_in, scores_of
from taskgist_lab.evaluation.learner import UNKNOWN_CODE, Coded, Codes, in_random_order, learned, sizes_within
from taskgist_lab.evaluation.peers import door
from taskgist_lab.evaluation.values import CLEAN, Result, Sample, Spread

SIZES = (1, 3, 5, 10, 20, 50)
"""Demonstrations after which clauses are judged."""
ONE_WRONG, WRONG_SHARE = "one wrong in ten", 0.1
OTHERS = (0, 1, 2, 5)
"""Other tasks that clauses are compared with, beside neutral manipulations."""
OF_OTHERS = 10
"""Demonstrations of each of them."""
MOST_RUNS = 20
"""Random orders that are learned: a fit for each of them, task, size and background takes some milliseconds."""
PAPER_RULE, CLAUSES, FOREST = "paper", "clauses", "forest"
TREES = 200
"""Of the forest."""


def learner_text(learner: str, others: int | None) -> str:
    """A learner and what it was compared with, in a few words."""
    if learner == PAPER_RULE:
        return "the paper's rule"
    if learner == FOREST:
        return "a forest, told all that each fulfils"
    return f"clauses, {others or 'no'} other task{'s' * (others != 1)}"


@dataclass(frozen=True)
class ClauseScore:
    """One learner in one setting after so many demonstrations: F1 as means over tasks, with its spread over runs.

    Attributes:
        learner: ``PAPER_RULE``, ``CLAUSES`` or ``FOREST``.
        others: Other tasks that clauses were compared with; None for the rest.
        setting: A condition under which demonstrations were watched, or ``ONE_WRONG``.
        after: Demonstrations that were learned from.
        as_played: Judged by the one task that a demonstration was played as.
        as_fulfilled: Judged by all tasks that it fulfils.
    """

    learner: str
    others: int | None
    setting: str
    after: int
    as_played: Spread
    as_fulfilled: Spread


@dataclass(frozen=True)
class ClauseScores(Result):
    """All learners in all settings."""

    rows: tuple[ClauseScore, ...]
    runs: int
    neutral: int
    """Neutral manipulations that clauses were compared with."""

    @property
    def settings(self) -> tuple[str, ...]:
        """Settings, the clean one first."""
        return tuple(dict.fromkeys(each.setting for each in self.rows))

    def sizes(self, setting: str) -> tuple[int, ...]:
        """Demonstrations after which there are scores in a setting."""
        return tuple(sorted({each.after for each in self.rows if each.setting == setting}))

    def learners(self, setting: str) -> tuple[tuple[str, int | None], ...]:
        """Learners in a setting and the numbers of other tasks that they were compared with, in order."""
        return tuple(dict.fromkeys((each.learner, each.others) for each in self.rows if each.setting == setting))

    def row(self, learner: str, others: int | None, setting: str, after: int) -> ClauseScore:
        """One of the rows."""
        wanted = (learner, others, setting, after)
        return next(each for each in self.rows if (each.learner, each.others, each.setting, each.after) == wanted)


def clause_learning(
    coded: Coded, *, runs: int, seed: int, others: Sequence[int] = OTHERS, progress: Progress = silent
) -> ClauseScores:
    """Learn each task in many random orders, by both learners, and judge all held-out demonstrations.

    Args:
        coded: A pool.
        runs: Random orders of each task; ``MOST_RUNS`` at most.
        seed: Their seed.
        others: With how many of the other tasks clauses are compared, under other conditions than the clean one with
            the last number alone; more than there are are left out.
        progress: Told how far it is.

    Raises:
        InputError: The pool has no demonstrations of a task to learn from, or none held out.
    """
    judges = Judges.of(coded)
    runs = min(runs, MOST_RUNS)
    rows: list[ClauseScore] = []
    spoiled = [(condition, condition, 0.0) for condition in coded.pool.conditions if condition != CLEAN]
    for setting, condition, share in ((CLEAN, CLEAN, 0.0), (ONE_WRONG, CLEAN, WRONG_SHARE), *spoiled):
        orders = {
            task: in_random_order(
                coded, task, runs=runs, seed=seed, condition=condition, wrong_share=share, longest=SIZES[-1]
            )
            for task in coded.pool.tasks
        }
        sizes = sizes_within(SIZES, orders.values())
        known = {task: learned(order, coded) for task, order in orders.items()}
        for after in sizes:
            held = {task: held_in(each, judges.held_out, after, CLAUSE) == 1 for task, each in known.items()}
            rows.append(ClauseScore(PAPER_RULE, None, setting, after, *judges.scores(held)))
        known_others = [count for count in others if count < len(orders)]
        told = known_others if condition == CLEAN else known_others[-1:]
        backgrounds = [(count, after) for count in told for after in sizes]
        for number, (count, after) in enumerate(backgrounds):
            progress(f"clauses, {setting}", number / len(backgrounds))
            held = {
                task: np.stack([judges.holds(each) for each in _posteriors(coded, orders, task, after, count, seed)])
                for task in orders
            }
            rows.append(ClauseScore(CLAUSES, count, setting, after, *judges.scores(held)))
    rows += _forests(judges, runs, seed, progress)
    return ClauseScores(tuple(rows), runs, sum(map(len, neutral_kinds(coded).values())))


def _forests(judges: Judges, runs: int, seed: int, progress: Progress) -> Iterator[ClauseScore]:
    """What the facts allow after each number of demonstrations; nothing where scikit-learn is not installed."""
    try:
        ensemble = door("sklearn.ensemble", "random forest")
    except InputError:
        return
    coded = judges.coded
    known = {task: coded.pool.of(task, held_out=False) for task in coded.pool.tasks}
    sizes = [size for size in SIZES if size <= min(map(len, known.values()))]
    for number, after in enumerate(sizes):
        progress("what the facts allow", number / len(sizes))
        held: dict[str, list[Mask]] = {task: [] for task in known}
        for run in range(runs):
            rng = np.random.default_rng([seed, run])
            told = [own[int(i)] for own in known.values() for i in rng.permutation(len(own))[:after]]
            forest = ensemble.RandomForestClassifier(TREES, random_state=seed + run)
            forest.fit(_features(coded, coded.codes(told)), _fulfilled(told, coded.pool.tasks).T)
            said = forest.predict(_features(coded, judges.held_out.codes))
            for task, column in zip(coded.pool.tasks, np.asarray(said, dtype=bool).T, strict=True):
                held[task].append(column)
        scores = judges.scores({task: np.stack(each) for task, each in held.items()})
        yield ClauseScore(FOREST, None, CLEAN, after, *scores)


def _features(coded: Coded, codes: Codes) -> Mask:
    """Whether each node that clauses are about has each of its values, (demonstrations, values)."""
    columns = [coded.index(each.node.name) for each in vocabularies(STANDARD_TREE)]
    return np.concatenate([codes[:, [i]] == np.arange(len(coded.values[i])) for i in columns], axis=1)


def _fulfilled(samples: Sequence[Sample], tasks: Sequence[str]) -> Mask:
    """Whether each sample fulfils each task, (tasks, samples)."""
    return np.array([[each.fulfils(task) for each in samples] for task in tasks])


def _posteriors(
    coded: Coded, orders: Mapping[str, Codes], task: str, after: int, others: int, seed: int
) -> Iterator[ClausePosterior]:
    """What is learned of a task in each run, compared with so many others."""
    for run in range(len(orders[task])):
        yield learn_clauses(run_evidence(coded, orders, task, run, after=after, others=others, seed=seed), task)


def run_evidence(
    coded: Coded, orders: Mapping[str, Codes], task: str, run: int, *, after: int, others: int, seed: int
) -> Evidence:
    """The first demonstrations of a task in a run, neutral ones, and those of other tasks, which differ by run.

    Args:
        coded: A pool.
        orders: Demonstrations of each task by run.
        task: The task.
        run: Which run.
        after: How many demonstrations of the task.
        others: How many other tasks; ``OF_OTHERS`` demonstrations of each.
        seed: Chooses them.
    """
    names = sorted(orders.keys() - {task})
    rng = np.random.default_rng([seed, run, zlib.crc32(task.encode())])
    chosen = [names[int(i)] for i in rng.permutation(len(names))[:others]]
    kinds = {name: effects(coded, orders[name][run, :OF_OTHERS]) for name in chosen}
    own = effects(coded, orders[task][run][:after])
    return Evidence.of({**neutral_kinds(coded), **kinds, task: own})


def effects(coded: Coded, codes: Codes) -> list[Effects]:
    """The known values of demonstrations, given as codes (demonstrations, nodes)."""
    return [
        {
            node.name: values[code]
            for node, values, code in zip(coded.nodes, coded.values, row, strict=True)
            if code != UNKNOWN_CODE
        }
        for row in codes.tolist()
    ]


def neutral_kinds(coded: Coded) -> Mapping[str, Sequence[Effects]]:
    """The shipped manipulations by kind; none where the pool was explained under another context."""
    shipped = shipped_background()
    return shipped.kinds if shipped.context == coded.pool.context else {}


@dataclass(frozen=True, eq=False)
class Judges:
    """Held-out demonstrations, and which tasks each of them is.

    Attributes:
        coded: Their vocabulary.
        held_out: The demonstrations.
        fulfilled: Whether each fulfils each task, (tasks, demonstrations).
    """

    coded: Coded
    held_out: HeldOut
    fulfilled: Mask

    @staticmethod
    def of(coded: Coded) -> Judges:
        """All clean held-out demonstrations of a pool.

        Raises:
            InputError: None of a task were held out.
        """
        samples = [each for task in coded.pool.tasks for each in coded.pool.of(task, CLEAN, held_out=True)]
        return Judges(coded, HeldOut.of(coded), _fulfilled(samples, coded.pool.tasks))

    def holds(self, posterior: ClausePosterior) -> Mask:
        """In which demonstrations the clauses hold, by a vote of their weights, (demonstrations,)."""
        truths = {
            literal: self._truth(literal) for literal in {each for one in posterior.clauses for each in one.literals}
        }
        yes, known = (np.zeros(len(self.held_out.codes)) for _ in range(2))
        for clause in posterior.clauses:
            each = np.array([truths[literal] for literal in clause.literals]).reshape(len(clause.literals), len(yes))
            false, true = (each == 0).any(axis=0), (each == 1).all(axis=0)
            yes += clause.weight * true
            known += clause.weight * (true | false)
        return np.asarray((yes > known / 2) & (known > 0))

    def _truth(self, literal: SetLiteral) -> Codes:
        """1 where a literal holds, 0 where it fails, −1 where it is unknown, (demonstrations,)."""
        column = self.coded.index(literal.node)
        table = [literal.admits(value) for value in self.coded.values[column]]
        return np.array([*table, UNKNOWN_CODE], dtype=np.int32)[self.held_out.codes[:, column]]

    def scores(self, held: Mapping[str, Mask]) -> tuple[Spread, Spread]:
        """F1 as played and as fulfilled, means over tasks.

        Args:
            held: By task, in which demonstrations it is said to hold, (runs, demonstrations).
        """
        as_played, as_fulfilled = [], []
        for index, task in enumerate(self.held_out.tasks):
            shares = self.held_out.shares(held[task].astype(np.int8), 1)
            as_played.append(scores_of(shares, index)[2])
            as_fulfilled.append(self._f1(held[task], self.fulfilled[index]))
        return Spread.of(np.mean(as_played, axis=0)), Spread.of(np.mean(as_fulfilled, axis=0))

    def _f1(self, held: Mask, true: Mask) -> Array:
        """F1 of each run; the demonstrations of each task weigh the same, however many were held out, (runs,)."""
        of_task = np.bincount(self.held_out.task_of)
        weights = 1.0 / of_task[self.held_out.task_of]
        hits, said, are = (held & true) @ weights, held @ weights, float(true @ weights)
        return np.asarray(2 * hits / (said + are))
