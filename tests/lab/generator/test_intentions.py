"""Which tasks a demonstration fulfils, by geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from taskgist.recording import Recording
from taskgist_lab.generator.intentions import CHECKS, fulfilled

FULFILLED = {
    ("hide", "under-cover"): {"hide"},
    ("hide away", "far-inside"): {"hide", "hide away"},
    ("put away", "far-on-table"): {"put away"},
    ("make accessible", "take-off-cover"): {"make accessible", "show"},
    ("show", "turn"): {"show"},
    ("lift", "straight-up"): {"lift"},
}


@pytest.mark.parametrize(("task", "means"), FULFILLED)
def test_tasks_entail_others_and_are_told_from_the_rest(
    simulated: Callable[[str, str], Recording], task: str, means: str
) -> None:
    assert set(fulfilled(simulated(task, means))) == FULFILLED[task, means]


def test_what_is_given_is_in_a_hand_that_it_was_not_in(simulated: Callable[[str, str], Recording]) -> None:
    recording = simulated("give", "to-the-right-hand")
    assert "give" in fulfilled(recording)
    assert recording.label is not None
    end_s = recording.label.end_s
    already = recording.with_label(replace(recording.label, start_s=end_s - 0.1, end_s=end_s, task="hold"))
    assert "give" not in fulfilled(already)


def test_every_task_of_the_paper_is_checked() -> None:
    assert set(CHECKS) == {"show", "hide", "make accessible", "give", "put away", "hide away"}
