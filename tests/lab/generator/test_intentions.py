"""Which tasks a demonstration fulfils, by geometry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.recording import Recording
from taskgist_lab.generator import WAYS
from taskgist_lab.generator.intentions import CHECKS, check_shows, fulfilled
from taskgist_lab.generator.outcomes import check_before_eyes, check_keeps_distance, check_turned_to_eyes
from taskgist_lab.generator.reaching import WITHIN_M, check_accessible

FULFILLED = {
    ("hide", "under-cover"): {"hide"},
    ("hide away", "far-inside"): {"hide", "hide away"},
    ("put away", "far-on-table"): {"put away"},
    ("make accessible", "take-off-cover"): {"make accessible", "show"},
    ("show", "turn"): {"show"},
    ("show", "hold-up"): {"show"},
    ("hide", "behind"): {"hide"},
    ("lift", "straight-up"): {"lift"},
}


@pytest.mark.parametrize(("task", "means"), FULFILLED)
def test_tasks_entail_others_and_are_told_from_the_rest(
    simulated: Callable[[str, str], Recording], task: str, means: str
) -> None:
    assert set(fulfilled(simulated(task, means))) == FULFILLED[task, means]


@pytest.mark.parametrize("means", [way.name for way in WAYS["show"]])
def test_each_way_to_show_shows_by_geometry_alone(simulated: Callable[[str, str], Recording], means: str) -> None:
    recording = simulated("show", means)
    check_shows(recording)
    assert recording.label is not None
    early = recording.with_label(replace(recording.label, end_s=recording.label.start_s + 0.1))
    with pytest.raises(SceneError):
        check_shows(early)


def test_what_only_comes_nearer_does_not_turn(simulated: Callable[[str, str], Recording]) -> None:
    with pytest.raises(SceneError, match="is not turned to the eyes"):
        check_turned_to_eyes(simulated("show", "hold-up"))
    check_turned_to_eyes(simulated("show", "turn"))


def test_what_lies_before_somebody_is_not_before_the_eyes(simulated: Callable[[str, str], Recording]) -> None:
    recording = simulated("show", "hold-up")
    check_before_eyes(recording)
    low = at_the_end(recording, (0.0, 0.0, -0.45))
    with pytest.raises(SceneError, match=r"is below the eyes|is not brought before the eyes|is not in view"):
        check_before_eyes(low)


def at_the_end(recording: Recording, offset_m: tuple[float, float, float]) -> Recording:
    """The recording, but in the end the thing is elsewhere."""
    assert recording.label is not None
    late = recording.times_s >= recording.label.end_s - 0.5
    start = recording.scene.object_slice(recording.label.target_object).start
    qpos = np.array(recording.qpos)
    qpos[late, start : start + 3] += offset_m
    return replace(recording, qpos=qpos)


@pytest.mark.parametrize("means", [way.name for way in WAYS["make accessible"]])
def test_each_way_to_make_accessible_does_so_for_arms(simulated: Callable[[str, str], Recording], means: str) -> None:
    recording = simulated("make accessible", means)
    check_accessible(recording)
    label = recording.label
    assert label is not None
    for spoilt in (
        recording.with_label(replace(label, end_s=label.start_s + 0.1)),
        at_the_end(recording, (0.0, 0.0, 2 * WITHIN_M)),
    ):
        with pytest.raises(SceneError, match=r"is not made accessible|is not in view"):
            check_accessible(spoilt)


def test_what_is_held_is_not_left_to_be_taken(simulated: Callable[[str, str], Recording]) -> None:
    with pytest.raises(SceneError, match="is not made accessible"):
        check_accessible(simulated("show", "hold-up"))
    with pytest.raises(SceneError, match="is not made accessible"):
        check_accessible(simulated("give", "to-the-right-hand"))


@pytest.mark.parametrize("means", ["behind", "inside"])
def test_what_is_only_hidden_keeps_its_distance(simulated: Callable[[str, str], Recording], means: str) -> None:
    check_keeps_distance(simulated("hide", means))
    assert "hide away" not in fulfilled(simulated("hide", means))
    with pytest.raises(SceneError, match="is farther off in the end"):
        check_keeps_distance(simulated("put away", "far-on-table"))


def test_what_is_given_is_in_a_hand_that_it_was_not_in(simulated: Callable[[str, str], Recording]) -> None:
    recording = simulated("give", "to-the-right-hand")
    assert "give" in fulfilled(recording)
    assert recording.label is not None
    end_s = recording.label.end_s
    already = recording.with_label(replace(recording.label, start_s=end_s - 0.1, end_s=end_s, task="hold"))
    assert "give" not in fulfilled(already)


def test_every_task_of_the_paper_is_checked() -> None:
    assert set(CHECKS) == {"show", "hide", "make accessible", "give", "put away", "hide away"}
