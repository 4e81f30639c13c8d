"""The simulated recordings of the study: plausible motions, and what the scripts promise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import SceneError
from taskgist.moving import HoldUp, PutDown, Take, Wait, Withdraw
from taskgist.recording import Label, Recording
from taskgist.settings import DEFAULT
from taskgist.world import Stage, hand_gap_m, holding_of, posture_of, rests_on, support_of
from taskgist_lab.paper import STUDY
from taskgist_lab.simulator import Script, demonstrate
from tests.moving.motions import assert_smooth, assert_through_nothing
from tests.shipped import recording as recorded

Array = NDArray[np.float64]
DEMONSTRATIONS = {d.name: d for task in ("show", "hide") for d in STUDY[task]}
NAMES = tuple(DEMONSTRATIONS)
HELD_UP = ("show_a", "show_b", "show_c")
ROUNDING = 1e-4
"""Files keep tenths of a millimetre."""
PUT_DOWN = tuple(name for name in NAMES if name not in HELD_UP)


def _label(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


def _thing(recording: Recording) -> Array:
    return recording.qpos[:, recording.scene.object_slice(_label(recording).target_object)]


def _speed_m_s(recording: Recording) -> Array:
    return np.asarray(np.linalg.norm(np.diff(_thing(recording)[:, :3], axis=0), axis=1) * 30)


def _carried(recording: Recording) -> slice:
    """Frames from the first movement of the thing to its last."""
    moving = np.flatnonzero(_speed_m_s(recording) > 1e-9)
    return slice(int(moving[0]) + 1, int(moving[-1]) + 1)


def _side(recording: Recording) -> str:
    """The hand that is nearest to the thing in the middle of the carrying."""
    frames = _carried(recording)
    stage = Stage(recording.scene, recording.state((frames.start + frames.stop) // 2))
    arms = recording.scene.agent(_label(recording).performing_agent).arms
    gaps = {a.profile.side: hand_gap_m(stage, a, _label(recording).target_object, limit_m=1.0) for a in arms}
    return min(gaps, key=lambda side: gaps[side])


def _off_rad(recording: Recording, time_s: float, name: str) -> float:
    """Angle between an agent's face and the thing."""
    stage = Stage(recording.scene, recording.at(time_s))
    eye = stage.eye(recording.scene.agent(name))
    line = stage.body_position(recording.scene.object_body(_label(recording).target_object)) - eye.position
    return float(np.arccos(line @ eye.matrix[:, 0] / np.linalg.norm(line)))


@pytest.mark.parametrize("name", NAMES)
def test_they_are_marked_as_simulated_and_labelled_within(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert recording.provenance.simulated
    assert recording.provenance.notes[0].startswith("means: ")
    assert np.diff(recording.times_s) == pytest.approx(np.full(len(recording) - 1, 1 / 30))
    assert label.task == name.partition("_")[0]
    assert 0.0 < label.start_s < label.end_s < recording.times_s[-1]
    assert "before the performer moves" in label.how


@pytest.mark.parametrize("name", NAMES)
def test_the_thing_is_still_at_both_ends_of_the_label(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    times, speed = recording.times_s[1:], _speed_m_s(recorded(name))
    assert speed[times < label.start_s + 0.4].max() == 0.0
    assert speed[np.abs(times - label.end_s) < 0.5].max() < DEFAULT.timing.static_m_s / 2
    assert speed.max() > 0.3


@pytest.mark.parametrize("name", NAMES)
def test_joints_move_within_limits_and_without_jerks(name: str) -> None:
    assert_smooth(recorded(name))


@pytest.mark.parametrize("name", NAMES)
def test_bodies_do_not_pass_through_what_is_around(name: str) -> None:
    assert_through_nothing(recorded(name))


@pytest.mark.parametrize("name", NAMES)
def test_the_hand_closes_around_the_thing_and_carries_it_rigidly(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene, frames = recording.scene, _carried(recorded(name))
    arm = scene.agent(label.performing_agent).arm(_side(recording))
    stage, poses = Stage(scene), []
    settling = 9 if name in PUT_DOWN else 0
    for index in range(frames.start, frames.stop - settling):
        stage.show(recording.state(index))
        assert -0.01 < hand_gap_m(stage, arm, label.target_object, limit_m=1.0) < 0.02
        thing, hand = stage.body(scene.object_body(label.target_object)), stage.body(arm.hand_body)
        poses.append(np.concatenate((hand.to_local(thing.position), (hand.matrix.T @ thing.matrix).ravel())))
    assert len(poses) > 15
    assert np.ptp(poses, axis=0).max() < 4 * ROUNDING


@pytest.mark.parametrize("name", NAMES)
def test_it_ends_as_the_script_says(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    stage = Stage(recording.scene, recording.at(label.start_s))
    assert support_of(stage, label.target_object, DEFAULT.contact) == "table"
    holding = holding_of(stage.show(recording.at(label.end_s)), label.target_object, DEFAULT.contact)
    assert holding is not None
    if name in HELD_UP:
        assert holding.hands == ((label.performing_agent, _side(recording)),)
    else:
        assert holding.hands == ()
        assert holding.support == ("white_box" if name == "show_d" else "table")


@pytest.mark.parametrize("name", PUT_DOWN)
def test_what_was_put_down_touches_its_support(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    stage = Stage(scene, recording.at(label.end_s))
    support = support_of(stage, label.target_object, DEFAULT.contact)
    assert support is not None
    gap = stage.closest(scene.geoms_of(label.target_object), scene.geoms_of(support), limit_m=0.1)[0]
    assert abs(gap) < 0.001
    hand = scene.agent(label.performing_agent).arm(_side(recording))
    assert hand_gap_m(stage, hand, label.target_object, limit_m=1.0) > 0.1


@pytest.mark.parametrize("name", NAMES)
def test_nothing_else_is_moved(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    for thing in scene.objects:
        if thing != label.target_object:
            assert np.ptp(recording.qpos[:, scene.object_slice(thing)], axis=0).max() == 0.0
    for agent in scene.agents:
        assert np.ptp(recording.qpos[:, scene.base_slice(agent)], axis=0).max() == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_people_sit_or_stand_with_empty_hands_in_the_air(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    wanted = "standing" if name == "show_d" else "sitting"
    target = scene.agent(label.target_agent)
    for time_s in (label.start_s, label.end_s):
        stage = Stage(scene, recording.at(time_s))
        assert [posture_of(stage, scene.agent(a), DEFAULT.contact) for a in scene.agents] == [wanted, wanted]
        assert [rests_on(stage, arm, DEFAULT.contact) for arm in target.arms] == [None, None]
    assert len({scene.agent(a).stature_m for a in scene.agents}) == 2


@pytest.mark.parametrize("name", NAMES)
def test_eyes_follow_what_happens(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    frames = _carried(recording)
    taken_s = float(recording.times_s[frames.start])
    assert _off_rad(recording, taken_s, label.performing_agent) < np.radians(30)
    times = recording.times_s[frames]
    nearest = min(_off_rad(recording, float(t), label.target_agent) for t in times[:: len(times) // 15])
    assert nearest < np.radians(15)


@pytest.mark.parametrize("name", [d.name for d in STUDY["show"]])
def test_who_is_shown_something_looks_at_it_in_the_end_only(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert _off_rad(recording, label.end_s, label.target_agent) < np.radians(20)
    assert _off_rad(recording, label.start_s, label.target_agent) > np.radians(25)


@pytest.mark.parametrize("name", [d.name for d in STUDY["hide"]])
def test_who_has_lost_sight_of_it_looks_up_again(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert _off_rad(recording, label.end_s, label.target_agent) > np.radians(25)


def test_a_seed_decides_everything() -> None:
    first, again, other = (DEMONSTRATIONS["show_a"].record(seed) for seed in (1, 1, 2))
    assert again.digest == first.digest
    assert other.digest != again.digest
    assert len(other) != len(again)


def test_displaced_arrangements_stay_close() -> None:
    scene = DEMONSTRATIONS["hide_c"].room.varied(np.random.default_rng(4), distance_m=0.03, angle_rad=0.08).scene()
    plain = recorded("hide_c").scene
    for name in (*scene.agents, *scene.objects):
        place = scene.base_slice if name in scene.agents else scene.object_slice
        moved = (scene.initial.qpos - plain.initial.qpos)[place(name)]
        assert 0.0 < np.abs(moved[:2]).max() <= 0.03
        assert np.abs(moved[2]) < 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_displaced_demonstrations_still_work(name: str) -> None:
    recording = DEMONSTRATIONS[name].record(seed=11, distance_m=0.03, angle_rad=np.radians(5))
    label = _label(recording)
    holding = holding_of(Stage(recording.scene, recording.at(label.end_s)), label.target_object, DEFAULT.contact)
    assert holding is not None
    assert bool(holding.hands) == (name in HELD_UP)


@pytest.mark.parametrize("name", NAMES)
def test_things_lie_on_the_table_apart_from_each_other(name: str) -> None:
    scene = recorded(name).scene
    stage = Stage(scene)
    for thing in scene.objects:
        others = [g for o in scene.objects if o != thing for g in scene.geoms_of(o)]
        assert stage.closest(scene.geoms_of(thing), others, limit_m=0.1)[0] > 0.02
        assert abs(stage.closest(scene.geoms_of(thing), scene.geoms_of("table"), limit_m=0.1)[0]) < 1e-6


@pytest.mark.parametrize("steps", [(), (Wait(0.5), Withdraw())])
def test_a_script_must_take_something(steps: tuple[Wait | Withdraw, ...]) -> None:
    script = Script("show", "P1", "P2", "cup", steps)
    with pytest.raises(SceneError, match="nothing has been taken; begin the script with Take"):
        demonstrate(script, recorded("show_a").scene, seed=0)


def test_steps_can_be_chained_with_either_hand() -> None:
    scene = recorded("show_a").scene
    steps = (
        Take("cup", "right"),
        HoldUp((-0.1, -0.2, 1.1), 0.5),
        PutDown((-0.2, -0.1, 0.72)),
        Withdraw(),
        Take("cup", "left"),
        PutDown((-0.15, 0.1, 0.72)),
        Withdraw(),
    )
    recording = demonstrate(Script("show", "P1", "P2", "cup", steps), scene, seed=0)
    assert _thing(recording)[-1, :3] == pytest.approx((-0.15, 0.1, 0.77), abs=1e-6)
    assert _thing(recording)[:, 2].max() == pytest.approx(1.1, abs=0.02)
    assert _thing(recording)[:, 2].min() > 0.77 - 0.001


def test_what_was_put_down_is_not_held_any_more() -> None:
    steps = (Take("cup", "right"), PutDown((-0.2, -0.1, 0.72)), HoldUp((-0.1, -0.2, 1.1), 0.5))
    with pytest.raises(SceneError, match="P1: cup: nothing is held any more; let a Take come before"):
        demonstrate(Script("show", "P1", "P2", "cup", steps), recorded("show_a").scene, seed=0)
