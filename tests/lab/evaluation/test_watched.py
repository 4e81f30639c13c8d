"""What is said of held-out recordings, under way and without their labels: scores are what they are called."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from taskgist.errors import InputError
from taskgist_lab.evaluation import replayed
from taskgist_lab.evaluation.episodes import episodes
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.sheets import sheets_of
from taskgist_lab.evaluation.under_way import FORESEEN, NOW, SHARES, Said, scores_of, under_way
from taskgist_lab.evaluation.values import Sample
from tests.lab.evaluation.pools import study_pool

POOL = study_pool(6)
TWO = POOL.of("show", held_out=True)[:1] + POOL.of("hide", held_out=True)[:1]


@pytest.fixture
def _few(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replayed, "LEARNED", 4)
    monkeypatch.setattr(replayed.Replayed.of, "__defaults__", (1,))


def said(sample: Sample, how: str, of_own: float, of_other: float) -> list[Said]:
    other = "hide" if sample.task == "show" else "show"
    probability = {sample.task: of_own, other: of_other}
    best = max(probability, key=lambda task: probability[task])
    return [Said(sample, share, how, probability, best) for share in SHARES]


def test_who_knows_the_truth_has_the_best_scores_and_who_says_the_reverse_the_worst() -> None:
    knows = [each for sample in TWO for each in said(sample, NOW, 1.0, 0.0)]
    errs = [each for sample in TWO for each in said(sample, FORESEEN, 0.1, 0.9)]
    found = scores_of([*knows, *errs], len(TWO))
    for row in found.rows:
        good = row.how == NOW
        assert row.right_of_known == row.right
        assert (row.right, row.as_played, row.brier) == ((1.0, 1.0, 0.0) if good else (0.0, 0.0, 0.81))
        assert row.log_loss == pytest.approx(0.0001 if good else -math.log(0.1), abs=1e-4)
    assert found.untold == 0
    assert found.reliability == ((0.1, 1.0, 2), (0.9, 0.0, 2))
    assert scores_of(knows, len(TWO)).untold == len(TWO) * len(SHARES)


def test_who_says_none_is_wrong_and_may_know_which_one_it_would_be() -> None:
    silent = [replace(each, best=None) for sample in TWO for each in said(sample, NOW, 0.4, 0.1)]
    assert {(row.right, row.right_of_known) for row in scores_of(silent, len(TWO)).rows} == {(0.0, 1.0)}


@pytest.mark.usefixtures("_few")
def test_held_out_recordings_are_watched() -> None:
    some = [each for each in POOL.samples if each.task in {"give", "hide", "show"}]
    coded = Coded.of(replace(POOL, samples=tuple(some)))
    found, ended = under_way(coded, processes=1), episodes(coded, processes=1)
    assert found.demonstrations == ended.recordings == 3
    rows = {(each.share, each.how): each for each in found.rows}
    assert rows[0.9, FORESEEN].right >= rows[0.25, FORESEEN].right
    assert rows[0.9, NOW].right >= 0.5
    assert ended.found >= 0.8
    assert ended.recognised >= 0.5
    titles = [sheet.title for result in (found, ended) for sheet in sheets_of(result)]
    assert titles[0] == "Tasks under way, by the share of their time"
    assert titles[-1] == "Episodes found in recordings without their labels"


def test_too_few_demonstrations_are_refused_with_what_to_do() -> None:
    with pytest.raises(InputError, match=r"too few demonstrations.*make \d+ or more of each task"):
        under_way(Coded.of(POOL))
