"""Every means of show, hide, put away and hide away: what is played is sound, and the intention is reached."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.perspective import Visibility, visibility
from taskgist.recording import Label, Recording
from taskgist.settings import DEFAULT
from taskgist.world import Stage, container_of, holding_of, overlaps, support_of
from taskgist_lab.generator import WAYS
from taskgist_lab.generator.outcomes import check_motion
from tests.moving.motions import assert_smooth, assert_through_nothing

Array = NDArray[np.float64]
Simulated = Callable[[str, str], Recording]
OURS = ("show", "hide", "put away", "hide away")
MEANS = [(task, way.name) for task in OURS for way in WAYS[task]]
OF_OTHERS = {"move-occluder": "occluder", "under-cover": "cover"}
HIDDEN = [each for each in MEANS if each[0].startswith("hide")]
AWAY = [each for each in MEANS if each[0].endswith("away")]


def label_of(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


def moved(recording: Recording, name: str) -> float:
    return float(np.ptp(recording.qpos[:, recording.scene.object_slice(name)], axis=0).max())


def seen(recording: Recording, time_s: float) -> Visibility:
    """What the engine that judges sees: another reckoning than the performer's."""
    label = label_of(recording)
    found = visibility(Stage(recording.scene, recording.at(time_s)), label.target_agent, label.target_object, DEFAULT)
    assert found is not None
    return found


def pixels(recording: Recording, time_s: float) -> float:
    return seen(recording, time_s).visible_px


def away_m(recording: Recording, time_s: float) -> float:
    label, scene = label_of(recording), recording.scene
    qpos = recording.at(time_s).qpos
    pelvis, thing = qpos[scene.base_slice(label.target_agent)], qpos[scene.object_slice(label.target_object)]
    return float(np.linalg.norm(thing[:2] - pelvis[:2]))


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_the_label_says_what_happens(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    assert label.task == task
    assert {label.performing_agent, label.target_agent} <= set(recording.scene.agents)
    assert 0.0 < label.start_s < label.end_s < recording.times_s[-1]
    assert np.diff(recording.times_s) == pytest.approx(np.full(len(recording) - 1, 1 / 30))


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_only_one_thing_is_moved_and_all_is_still_at_both_ends(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    acted_on = [name for name in recording.scene.objects if moved(recording, name) > 0.0]
    if means in OF_OTHERS:
        assert [name.partition("_")[0] for name in acted_on] in (["carton"], ["folder"], ["cover"])
        assert label.target_object not in acted_on
    elif means not in ("inside", "far-inside"):  # what falls into a bin may push it a little
        assert acted_on == [label.target_object]
    places = np.array([recording.qpos[:, recording.scene.object_slice(name)][:, :3] for name in acted_on])
    speed = np.linalg.norm(np.diff(places, axis=1), axis=2).max(axis=0) * 30
    times = recording.times_s[1:]
    assert speed[times < label.start_s + 0.4].max() == 0.0
    assert speed[np.abs(times - label.end_s) < 0.4].max() < DEFAULT.timing.static_m_s / 2


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_motions_are_smooth_and_through_nothing(simulated: Simulated, task: str, means: str) -> None:
    recording = simulated(task, means)
    assert_smooth(recording)
    check_motion(recording)
    on_a_sofa = f"sofa_{label_of(recording).performing_agent}" in recording.scene.bodies  # it sinks in
    if means not in OF_OTHERS and not on_a_sofa:
        assert_through_nothing(recording)


@pytest.mark.parametrize(("task", "means"), MEANS)
def test_at_first_nothing_overlaps_and_the_thing_lies_on_the_table(simulated: Simulated, task: str, means: str) -> None:
    recording = simulated(task, means)
    stage = Stage(recording.scene, recording.state(0))
    found = {pair: depth for pair, depth in overlaps(stage, deeper_than_m=0.002).items() if depth < 1.0}
    seats = {f"{kind}_{agent}" for kind in ("chair", "sofa") for agent in recording.scene.agents}
    assert all(set(pair) & seats for pair in found), found
    assert support_of(stage, label_of(recording).target_object, DEFAULT.contact) == "table"


@pytest.mark.parametrize(("task", "means"), HIDDEN)
def test_what_is_hidden_was_seen_and_is_not_seen_any_more(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    before = seen(recording, label.start_s)
    assert before.visible_px > 20 or before.off_gaze_rad > np.radians(45)  # somebody who looks elsewhere could have
    assert pixels(recording, label.end_s) == 0


@pytest.mark.parametrize("means", [way.name for way in WAYS["show"]])
def test_what_is_shown_is_seen_better_and_looked_at(simulated: Simulated, means: str) -> None:
    recording, label = simulated("show", means), label_of(simulated("show", means))
    assert pixels(recording, label.end_s) > 1.25 * pixels(recording, label.start_s)
    stage = Stage(recording.scene, recording.at(label.end_s))
    eye = stage.eye(recording.scene.agent(label.target_agent))
    line = stage.body_position(recording.scene.object_body(label.target_object)) - eye.position
    assert np.degrees(np.arccos(line @ eye.matrix[:, 0] / np.linalg.norm(line))) < 25.0


@pytest.mark.parametrize(("task", "means"), AWAY)
def test_what_is_put_away_is_farther_off(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    assert away_m(recording, label.end_s) > away_m(recording, label.start_s) + 0.15
    if task == "put away":
        assert pixels(recording, label.end_s) > 0


ENDS_ON = {
    ("show", "on-top"): ("box", "stand"),
    ("show", "turn"): ("table",),
    ("put away", "far-on-table"): ("table",),
    ("put away", "side-table"): ("side_table",),
    ("put away", "shelf"): ("shelf",),
    ("hide away", "cupboard"): ("shelf",),
    ("hide", "under-cover"): ("table",),
}


@pytest.mark.parametrize(("task", "means"), ENDS_ON)
def test_it_ends_where_the_means_puts_it(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    stage = Stage(recording.scene, recording.at(label.end_s))
    assert support_of(stage, label.target_object, DEFAULT.contact) in ENDS_ON[task, means]


@pytest.mark.parametrize(("task", "means"), [("hide", "inside"), ("hide away", "far-inside")])
def test_it_ends_in_the_bin(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    stage = Stage(recording.scene, recording.at(label.end_s))
    assert container_of(stage, label.target_object, DEFAULT.contact) == "bin"


@pytest.mark.parametrize(("task", "means"), [("show", "hold-up"), ("hide", "behind-back")])
def test_it_ends_in_the_performers_hand(simulated: Simulated, task: str, means: str) -> None:
    recording, label = simulated(task, means), label_of(simulated(task, means))
    holding = holding_of(Stage(recording.scene, recording.at(label.end_s)), label.target_object, DEFAULT.contact)
    assert holding is not None
    assert [agent for agent, _ in holding.hands] == [label.performing_agent]


def test_what_is_held_behind_the_back_is_outside_of_the_body(simulated: Simulated) -> None:
    recording, label = simulated("hide", "behind-back"), label_of(simulated("hide", "behind-back"))
    scene, stage = recording.scene, Stage(recording.scene, recording.at(label.end_s))
    performer = scene.agent(label.performing_agent)
    gap = stage.closest(scene.geoms_of(label.target_object), performer.core_geoms, limit_m=0.5)[0]
    assert 0.0 < gap < 0.3
