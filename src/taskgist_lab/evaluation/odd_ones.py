"""Are wrong labels found? One demonstration in ten is of another task, and which of them are called odd?"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.task_clauses import learn_task, odd_demonstrations
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.pool import HELD_OUT_EVERY
from taskgist_lab.evaluation.values import CLEAN, Result, Sample, rounded

OF_EACH = 10
"""Demonstrations of each task that are known, one of which is wrong in the task that is looked at."""
MOST_RUNS = 20
"""Random choices, at most: each learns all tasks once more for each odd one."""


@dataclass(frozen=True)
class OddOnes(Result):
    """How well wrong labels are found.

    Attributes:
        precision: Share of those called odd that are wrong ones; None where none was called so.
        recall: Share of the wrong ones that are called odd.
        wrong: How many wrong ones there were.
        right_all_the_same: How many of them fulfil the task that they are labelled as, too.
    """

    precision: float | None
    recall: float
    wrong: int
    right_all_the_same: int


def odd_ones(coded: Coded, *, runs: int, seed: int, progress: Progress = silent) -> OddOnes:
    """Label one demonstration of another task as each task, among nine right ones, and ask which ones look odd.

    Args:
        coded: A pool.
        runs: Random choices for each task; ``MOST_RUNS`` at most.
        seed: Their seed.
        progress: Told how far it is.

    Raises:
        InputError: A task has no more than ``OF_EACH`` demonstrations to learn from.
    """
    pool, runs = coded.pool, min(runs, MOST_RUNS)
    known = {task: pool.of(task, CLEAN, held_out=False) for task in pool.tasks}
    for task, own in known.items():
        if len(own) <= OF_EACH:
            hint = f"make {HELD_OUT_EVERY * (OF_EACH + 1) // 2} or more of each task (-n)"
            raise InputError("too few demonstrations", field="pool", where=task, value=len(own), hint=hint)
    called = found = right = 0
    for run in range(runs):
        rng = np.random.default_rng([seed, run])
        order = {task: [own[int(i)] for i in rng.permutation(len(own))] for task, own in known.items()}
        chosen = {task: some[:OF_EACH] for task, some in order.items()}
        for number, task in enumerate(chosen):
            progress("odd ones", (run + number / len(chosen)) / runs)
            others = [each for other, some in order.items() if other != task for each in some[OF_EACH:]]
            wrong = others[int(rng.integers(len(others)))]
            odd = _called_odd(coded, {**chosen, task: [*chosen[task][:-1], wrong]}, task)
            called += len(odd)
            found += _name(wrong) in odd
            right += task in wrong.fulfilled
    count = runs * len(known)
    return OddOnes(rounded(found / called) if called else None, rounded(found / count), count, right)


def _called_odd(coded: Coded, samples: dict[str, list[Sample]], task: str) -> set[str]:
    """The demonstrations of a task that look odd, by name."""
    pool, knowledge = coded.pool, Knowledge()
    for label, some in samples.items():
        told = (each.explanation(pool.nodes, pool.context) for each in some)
        knowledge = knowledge.add(*(replace(each, task=label) for each in told))
    odd = odd_demonstrations(knowledge, learn_task(knowledge, task))
    return {each.explanation.demonstration for each in odd}


def _name(sample: Sample) -> str:
    return f"{sample.task} {sample.number}"
