"""Make accessible, give, lift, tap, drop, dump, throw and move: each way plays, and leads to the facts it is about."""

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest

from taskgist.pipeline import explain_recording
from taskgist.recording import Recording
from taskgist.world import Stage, hand_gap_m
from taskgist_lab.generator import WAYS, simulate

MOTION, PLACEMENT = ("motion.status.1", "motion.status.2"), ("placement.status.1", "placement.status.2")
ON, IN_HAND, IN_AIR, INSIDE = "On_Support", "In_Hand", "In_Air", "Inside_Container"
STILL, MOVING = "Static", "Moving"
ENDS: Mapping[str, tuple[str, str]] = {  # placement and motion in the end (9.10 of the paper)
    "make accessible": (ON, STILL),
    "give": (IN_HAND, STILL),
    "lift": (IN_HAND, STILL),
    "tap": (ON, MOVING),
    "drop": (IN_AIR, MOVING),
    "dump": (INSIDE, STILL),
    "throw": (IN_AIR, MOVING),
    "move": (ON, STILL),
}
SOME = [
    ("make accessible", "put-near"),
    ("make accessible", "take-off-cover"),
    ("give", "to-the-left-hand"),
    ("give", "from-the-hand-to-the-right-hand"),
    ("lift", "to-the-chest"),
    ("tap", "roll"),
    ("drop", "to-the-floor"),
    ("dump", "into-a-bin-on-the-table"),
    ("throw", "into-free-space"),
    ("move", "onto"),
    ("move", "closer"),
]
"""At least one means of each task; that all of them play is tested elsewhere."""
SEED = 11


@cache
def demonstration(task: str, means: str) -> Recording:
    return simulate(task, seed=SEED, number=0, means=means)


@pytest.mark.parametrize(("task", "means"), SOME)
def test_the_facts_are_those_of_the_task(task: str, means: str) -> None:
    values = explain_recording(demonstration(task, means)).values
    starts = IN_HAND if means.startswith("from-the-hand") else ON
    assert tuple(values[name] for name in PLACEMENT) == (starts, ENDS[task][0])
    assert tuple(values[name] for name in MOTION) == (STILL, ENDS[task][1])


@pytest.mark.parametrize(("task", "means"), SOME)
def test_the_label_and_the_notes_say_what_was_done(task: str, means: str) -> None:
    recording = demonstration(task, means)
    assert recording.label is not None
    assert recording.label.task == task
    assert f"means: {means}" in recording.provenance.notes
    assert recording.times_s[0] < recording.label.start_s < recording.label.end_s < recording.times_s[-1]


def test_every_task_has_means_and_is_tested() -> None:
    assert set(ENDS) <= set(WAYS)
    assert {task for task, _ in SOME} == set(ENDS)
    assert all(name in {way.name for way in WAYS[task]} for task, name in SOME)


def test_what_is_uncovered_is_not_touched() -> None:
    recording = demonstration("make accessible", "take-off-cover")
    assert recording.label is not None
    poses = recording.qpos[:, recording.scene.object_slice(recording.label.target_object)]
    assert np.all(poses == poses[0])
    moved = [
        name
        for name in recording.scene.objects
        if np.ptp(recording.qpos[:, recording.scene.object_slice(name)], axis=0).max() > 0.05
    ]
    assert len(moved) == 1


@pytest.mark.parametrize("means", [means for task, means in SOME if task == "give"])
def test_what_is_given_ends_in_the_hand_that_the_means_names(means: str) -> None:
    recording = demonstration("give", means)
    label, scene = recording.label, recording.scene
    assert label is not None
    stage, side = Stage(scene, recording.at(label.end_s)), "left" if "left" in means else "right"
    gaps = {
        arm.profile.side: hand_gap_m(stage, arm, label.target_object, limit_m=0.5)
        for arm in scene.agent(label.target_agent).arms
    }
    assert gaps.pop(side) < 0.02
    assert min(gaps.values()) > 0.05


def test_what_is_made_accessible_is_put_nearer() -> None:
    recording = demonstration("make accessible", "put-near")
    label, scene = recording.label, recording.scene
    assert label is not None
    base = recording.qpos[0, scene.agent(label.target_agent).base][:2]
    places = recording.qpos[:, scene.object_slice(label.target_object)][:, :2]
    before, after = (float(np.linalg.norm(place - base)) for place in (places[0], places[-1]))
    assert after < before - 0.2
