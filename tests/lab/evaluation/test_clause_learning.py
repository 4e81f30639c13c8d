"""The experiment on whole clauses: its judging is that of the learner, and tasks entail others."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import InputError
from taskgist.facts import UNKNOWN, Observation
from taskgist.learning import Evidence, learn_clauses
from taskgist_lab.evaluation.clause_learning import CLAUSES, PAPER_RULE, Judges, clause_learning, effects
from taskgist_lab.evaluation.experiments import transfer
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.odd_ones import odd_ones
from tests.lab.evaluation.pools import study_pool

POOL = study_pool(12)
CODED = Coded.of(POOL)


@pytest.mark.parametrize("task", POOL.tasks)
def test_a_vote_on_codes_is_that_of_the_learner(task: str) -> None:
    kinds = {each: effects(CODED, CODED.of_task(each, held_out=False)[:4]) for each in POOL.tasks}
    posterior = learn_clauses(Evidence.of(kinds), task)
    judges = Judges.of(CODED)
    samples = [each for name in POOL.tasks for each in POOL.of(name, held_out=True)]
    nodes = [
        {
            name: Observation(UNKNOWN if value is None else value)
            for name, value in zip(POOL.nodes, each.values, strict=True)
        }
        for each in samples
    ]
    assert judges.holds(posterior).tolist() == [posterior.probability(each) > 0.5 for each in nodes]


def test_the_papers_rule_scores_as_in_the_experiment_on_transfer() -> None:
    found, known = clause_learning(CODED, runs=4, seed=3, others=()), transfer(CODED, runs=4, seed=3)
    for after in (1, 3, 5):
        expected = next(table for table in known.tables if (table.after, table.part) == (after, "clause"))
        assert found.row(PAPER_RULE, None, "clean", after).as_played == expected.overall.f1


def test_what_is_fulfilled_besides_is_no_mistake() -> None:
    """Judged by one task, each of two that are always shown together looks wrong in half of what it is said of."""
    both = tuple(
        replace(each, task=task, fulfilled=("hide", "stow"))
        for each in POOL.samples
        if each.task == "hide"
        for task in ("hide", "stow")
    )
    others = tuple(each for each in POOL.samples if each.task == "give")
    found = clause_learning(Coded.of(replace(POOL, samples=(*both, *others))), runs=2, seed=1, others=(1,))
    row = found.row(CLAUSES, 1, "clean", 5)
    assert row.as_played.mean is not None
    assert row.as_fulfilled.mean is not None
    assert row.as_fulfilled.mean > row.as_played.mean


def test_runs_are_the_same_again() -> None:
    first, again = (clause_learning(CODED, runs=1, seed=3, others=(2,)) for _ in range(2))
    assert first == again


def test_f1_weighs_tasks_alike_however_many_were_held_out() -> None:
    judges = Judges.of(CODED)
    everything = {task: np.ones((1, len(judges.held_out.codes)), dtype=bool) for task in POOL.tasks}
    played, fulfilled = judges.scores(everything)
    assert played.mean == pytest.approx(2 / 7, abs=1e-4)  # recall 1, precision 1/6
    assert fulfilled.mean == pytest.approx(2 / 7, abs=1e-4)  # the study's samples fulfil their own task alone


def test_a_wrong_label_among_ten_is_found() -> None:
    coded = Coded.of(study_pool(18))
    found = odd_ones(coded, runs=1, seed=1)
    assert found == odd_ones(coded, runs=1, seed=1)
    assert found.wrong == len(POOL.tasks)
    assert found.recall >= 0.6  # who hides away hides as well
    assert found.precision is not None
    assert found.precision >= 0.75
    with pytest.raises(InputError, match=r"too few demonstrations.*make 16 or more of each task"):
        odd_ones(CODED, runs=1, seed=1)
