"""The experiment on recognition: its scores are what they are called, and no recogniser sees what it is asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from taskgist.learning.evidence import Effects
from taskgist_lab.evaluation import recognition as experiment
from taskgist_lab.evaluation.clause_learning import neutral_kinds
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.pool import JUDGING_ONLY, NODES, UNFAMILIAR, Pool, empty_pool
from taskgist_lab.evaluation.recognition import OURS, Answers, Asked, Kinds, Probabilities, peers, recognition
from taskgist_lab.evaluation.sheets import sheets_of
from taskgist_lab.evaluation.values import CLEAN, Sample
from tests.lab.evaluation.pools import study_pool

CODED = Coded.of(study_pool(9))
TASKS = CODED.pool.tasks
FEW = {name: rows[:4] for name, rows in neutral_kinds(CODED).items()}


def unfamiliar() -> Pool:
    """Shipped manipulations under the names of kinds that nobody knows; of each, one fulfils a task all the same."""
    samples = [
        Sample(kind, number, CLEAN, "", tuple(map(rows[number].get, NODES)), (kind, *(["hide"] if number == 3 else [])))
        for kind, rows in zip(JUDGING_ONLY, FEW.values(), strict=False)
        for number in range(4)
    ]
    return empty_pool(UNFAMILIAR, 0).with_more(samples)


ASKED = Asked.of(CODED, unfamiliar())


@pytest.fixture(autouse=True)
def _few_manipulations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiment, "neutral_kinds", lambda _: FEW)


def certain(asked: Asked) -> Answers:
    """What somebody says who knows the truth."""
    none = {name: Probabilities(np.zeros((3, len(TASKS))), np.ones(3)) for name in asked.unknown}
    return Answers(Probabilities(asked.fulfilled.astype(float), np.zeros(len(asked.own))), none)


def test_who_knows_the_truth_has_the_best_scores() -> None:
    asked = ASKED
    row = asked.score("truth", 1, [certain(asked)])
    best = {"right": 1.0, "f1": 1.0, "log_loss": 0.0001, "brier": 0.0, "own_none": 0.0, "unknown_none": 1.0}
    for name, score in best.items():
        assert getattr(row, name).mean == pytest.approx(score, abs=1e-4), name
    curve = list(asked.reliability("truth", 1, [certain(asked)]))
    assert [(each.low, each.predicted, each.observed) for each in curve] == [(0.0, 0.0, 0.0), (0.9, 1.0, 1.0)]
    assert sum(each.share for each in curve) == pytest.approx(1.0, abs=1e-3)


def test_who_always_says_the_same_has_the_scores_of_that() -> None:
    asked = ASKED

    def half(count: int) -> Probabilities:
        return Probabilities(np.full((count, len(TASKS)), 0.5), np.full(count, 0.5))

    row = asked.score("half", 1, [Answers(half(len(asked.own)), {name: half(3) for name in asked.unknown})])
    assert row.log_loss.mean == pytest.approx(np.log(2.0), abs=1e-4)
    assert row.brier.mean == pytest.approx(0.25)
    assert (row.own_none.mean, row.unknown_none.mean) == (1.0, 1.0)  # where both are alike, none is said


def test_no_unknown_kind_is_known_and_what_fulfils_a_task_is_not_unknown() -> None:
    asked, seen = ASKED, list[set[str]]()

    def recognise(kinds: Kinds, tasks: tuple[str, ...], episodes: Sequence[Effects]) -> Probabilities:
        seen.append(set(kinds))
        numbers = np.arange(len(episodes), dtype=float)
        return Probabilities(np.tile(numbers[:, None], len(tasks)), numbers)

    found = asked.answers(recognise, {task: [] for task in TASKS})
    assert seen == [{*asked.neutral, *TASKS}]
    assert {kind: len(rows) for kind, rows in asked.unknown.items()} == dict.fromkeys(JUDGING_ONLY, 3)
    parts = [found.own, *found.unknown.values()]
    assert np.concatenate([each.none for each in parts]).tolist() == list(range(len(asked.own) + 9))


def test_everything_is_measured_and_told() -> None:
    found = recognition(CODED, unfamiliar(), runs=1, seed=2)
    assert found.recognisers[0] == OURS
    assert set(found.recognisers[1:]) == set(peers(0))
    assert found.sizes == (1, 3, 5)
    assert found == recognition(CODED, unfamiliar(), runs=1, seed=2)
    last = found.row(OURS, 5)
    assert last.right.mean is not None
    assert last.right.mean > 0.8
    for name in found.recognisers:
        assert sum(each.share for each in found.curve(name, 5)) == pytest.approx(1.0, abs=1e-2)
    told = [sheet.title for sheet in sheets_of(found)]
    assert told == [
        "What is recognised, by demonstrations",
        "How good the probabilities are, by demonstrations",
        "What is called none of the tasks, by demonstrations",
    ]
