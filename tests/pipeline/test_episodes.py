"""What was done each time that a thing was handled: readings for each agent, and of things that come into view."""

from __future__ import annotations

from functools import cache

import pytest

from taskgist.learning import Knowledge
from taskgist.pipeline.episodes import RecognisedHandling, recognise_handlings
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist_lab.evaluation.episodes import FoundEpisode, judged, scores_of
from taskgist_lab.generator.simulation import simulate
from tests.learning.learning_samples import STUDY, study
from tests.shipped import label, observer, recording


@cache
def recogniser() -> TaskRecogniser:
    return TaskRecogniser.of(Knowledge().add(*(each for task in STUDY for each in study(task).explanations.values())))


@cache
def found(name: str) -> tuple[RecognisedHandling, ...]:
    return recognise_handlings(recogniser(), recording(name).with_label(None), observer=observer(name))


def test_a_handover_is_a_give_and_what_follows_is_none() -> None:
    given, put = found("handover_1")
    assert given.best is not None
    best = given.best.recognised.best
    assert best is not None
    assert best.task == "give"
    assert given.best.label.pairs == label("handover_1").pairs
    assert (put.handling.performing_agent, put.handling.target_agents) == ("P2", ("P1",))
    giving = {each.task: each.probability for each in put.readings[0].recognised.tasks}["give"]
    assert giving < 0.5 < best.probability


def test_the_label_plays_no_part() -> None:
    assert recognise_handlings(recogniser(), recording("handover_1"), observer=observer("handover_1")) == found(
        "handover_1"
    )


def test_who_moves_a_cover_does_something_with_what_is_under_it() -> None:
    played = simulate("hide", seed=3, number=2, means="under-cover")
    assert played.label is not None
    (handled,) = recognise_handlings(recogniser(), played.with_label(None))
    assert handled.handling.thing == "cover"
    pairs = {pair for each in handled.readings for pair in each.label.pairs}
    assert (played.label.target_agent, played.label.target_object) in pairs
    judgement = judged(recogniser(), played)
    assert judgement.found
    assert (judgement.start_off_s, judgement.end_off_s) == (None, None), "it is not the cover that the label names"


def test_what_is_found_is_held_against_the_label() -> None:
    real = judged(recogniser(), recording("handover_1"))
    assert (real.found, real.recognised, real.headline, real.further) == (True, True, True, 1)
    assert real.start_off_s is not None
    assert -0.6 < real.start_off_s < -0.2, "a label starts a little before the thing is moved"
    missed = FoundEpisode("none", "give", 1.0, False, None, None, 2, None, None)
    scores = scores_of([real, missed])
    assert (scores.recordings, scores.found, scores.recognised) == (2, 0.5, 1.0)
    assert scores.further_per_minute == pytest.approx(3 / (1.0 + real.minutes))
    assert scores.start_within == (1.0, 1.0)
