"""The experiment on recognition: its scores are what they are called, and no recogniser sees what it is asked for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from taskgist.learning.evidence import Effects
from taskgist_lab.evaluation import recognition as experiment
from taskgist_lab.evaluation.clause_learning import neutral_effects
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.recognition import OURS, Answers, Asked, Kinds, Probabilities, peers, recognition
from taskgist_lab.evaluation.sheets import sheets_of
from tests.lab.evaluation.pools import study_pool

CODED = Coded.of(study_pool(9))
TASKS = CODED.pool.tasks
FEW = {name: rows[:4] for name, rows in neutral_effects(CODED).items()}


@pytest.fixture(autouse=True)
def _few_manipulations(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experiment, "neutral_effects", lambda _: FEW)


def certain(asked: Asked) -> Answers:
    """What somebody says who knows the truth."""
    none = {name: Probabilities(np.zeros((4, len(TASKS))), np.ones(4)) for name in asked.neutral}
    return Answers(Probabilities(asked.fulfilled.astype(float), np.zeros(len(asked.own))), none)


def test_who_knows_the_truth_has_the_best_scores() -> None:
    asked = Asked.of(CODED)
    row = asked.score("truth", 1, [certain(asked)])
    best = {"right": 1.0, "f1": 1.0, "log_loss": 0.0001, "brier": 0.0, "own_none": 0.0, "unknown_none": 1.0}
    for name, score in best.items():
        assert getattr(row, name).mean == pytest.approx(score, abs=1e-4), name
    curve = list(asked.reliability("truth", 1, [certain(asked)]))
    assert [(each.low, each.predicted, each.observed) for each in curve] == [(0.0, 0.0, 0.0), (0.9, 1.0, 1.0)]
    assert sum(each.share for each in curve) == pytest.approx(1.0, abs=1e-3)


def test_who_always_says_the_same_has_the_scores_of_that() -> None:
    asked = Asked.of(CODED)

    def half(count: int) -> Probabilities:
        return Probabilities(np.full((count, len(TASKS)), 0.5), np.full(count, 0.5))

    row = asked.score("half", 1, [Answers(half(len(asked.own)), {name: half(4) for name in asked.neutral})])
    assert row.log_loss.mean == pytest.approx(np.log(2.0), abs=1e-4)
    assert row.brier.mean == pytest.approx(0.25)
    assert (row.own_none.mean, row.unknown_none.mean) == (1.0, 1.0)  # where both are alike, none is said


def test_a_kind_is_never_known_when_it_is_asked_for() -> None:
    asked = Asked.of(CODED)
    seen: list[set[str]] = []

    def recognise(kinds: Kinds, tasks: tuple[str, ...], episodes: Sequence[Effects]) -> Probabilities:
        seen.append(set(asked.neutral) - set(kinds))
        return Probabilities(np.zeros((len(episodes), len(tasks))), np.ones(len(episodes)))

    asked.answers(recognise, {task: [] for task in TASKS})
    assert seen == [set(), *({name} for name in asked.neutral)]


def test_everything_is_measured_and_told() -> None:
    found = recognition(CODED, runs=1, seed=2)
    assert found.recognisers[0] == OURS
    assert set(found.recognisers[1:]) == set(peers(0))
    assert found.sizes == (1, 3, 5)
    assert found == recognition(CODED, runs=1, seed=2)
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
