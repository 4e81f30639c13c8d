"""Pools of the paper's study as values, with nothing to play or to watch."""

from __future__ import annotations

import numpy as np

from taskgist.facts import STANDARD_TREE
from taskgist.learning import Context, Explanation
from taskgist_lab.evaluation.pool import Pool
from taskgist_lab.evaluation.values import CLEAN, Sample
from tests.learning.learning_samples import STUDY, explained

NODES = tuple(node.name for node in STANDARD_TREE.nodes)


def sample(explanation: Explanation, number: int, condition: str = CLEAN, means: str = "as told") -> Sample:
    return Sample.of(explanation, NODES, number=number, condition=condition, means=means)


def study_pool(count: int = 24, conditions: tuple[str, ...] = (CLEAN,)) -> Pool:
    """So many demonstrations of each task, watched perfectly under each condition."""
    samples = [
        sample(explained(task, number, STUDY[task][told(task, number)]), number, condition, f"way {number % 2}")
        for task in STUDY
        for number in range(count)
        for condition in conditions
    ]
    return Pool(Context.of(), "study", 1000, NODES).with_more(samples)


def told(task: str, number: int) -> int:
    """Which of the study's demonstrations: any of them, for those to learn from and those held out alike."""
    return int(np.random.default_rng(number).integers(len(STUDY[task])))
