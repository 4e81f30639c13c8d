"""Make accessible and give: plausible motions of one and of two people, and what the scripts promise."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import SceneError
from taskgist.moving import HoldUp, PutDown, Take
from taskgist.moving.steps import HandOver, LayHand
from taskgist.recording import Label, Recording
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, hand_gap_m, holding_of, posture_of, rests_on, support_of
from taskgist_lab.paper import STUDY
from taskgist_lab.simulator import Roles, Room, Script, Thing, demonstrate
from taskgist_lab.simulator.means import held_out, near
from taskgist_lab.simulator.room import TABLE, left, on_table, right
from tests.shipped import recording as recorded

Array = NDArray[np.float64]
DEMONSTRATIONS = {d.name: d for task in ("make accessible", "give") for d in STUDY[task]}
NAMES = tuple(DEMONSTRATIONS)
GIVEN = {"give_a": "left", "give_b": "left", "give_c": "right"}
PUT = tuple(d.name for d in STUDY["make accessible"])
STANDING = ("accessible_d", "accessible_e", "give_b")
PEOPLE = (left(1.80, 0.67), right(1.66, 0.67))


def _label(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


def _thing(recording: Recording) -> Array:
    return recording.qpos[:, recording.scene.object_slice(_label(recording).target_object)]


def _off_rad(recording: Recording, time_s: float) -> float:
    """Angle between the target agent's face and the thing."""
    stage, label = Stage(recording.scene, recording.at(time_s)), _label(recording)
    eye = stage.eye(recording.scene.agent(label.target_agent))
    line = stage.body_position(recording.scene.object_body(label.target_object)) - eye.position
    return float(np.arccos(line @ eye.matrix[:, 0] / np.linalg.norm(line)))


def _gaps_m(recording: Recording, agent: str, side: str) -> Array:
    """Gap between a hand and the thing in every frame."""
    arm, stage = recording.scene.agent(agent).arm(side), Stage(recording.scene)
    states = (recording.state(index) for index in range(len(recording)))
    return np.array([hand_gap_m(stage.show(s), arm, _label(recording).target_object, limit_m=1.0) for s in states])


@pytest.mark.parametrize("name", NAMES)
def test_the_thing_lies_still_before_and_is_still_in_the_end(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    speed = np.linalg.norm(np.diff(_thing(recording)[:, :3], axis=0), axis=1) * 30
    times = recording.times_s[1:]
    assert label.task == ("give" if name in GIVEN else "make accessible")
    assert speed[times < label.start_s + 0.4].max() == 0.0
    assert speed[np.abs(times - label.end_s) < 0.5].max() < DEFAULT.timing.static_m_s / 2
    assert 0.3 < speed.max() < 2.0


@pytest.mark.parametrize("name", NAMES)
def test_both_people_move_within_limits_and_without_jerks(name: str) -> None:
    recording = recorded(name)
    scene, rate = recording.scene, 30.0
    for agent in scene.agents:
        ranges = np.array([scene.model.joint(f"{agent}/{joint}").range for joint in scene.joints(agent)])
        angles = recording.qpos[:, scene.joint_indices(agent)]
        assert np.all(angles > ranges[:, 0] - 0.01)
        assert np.all(angles < ranges[:, 1] + 0.01)
        assert np.abs(np.diff(angles, axis=0)).max() * rate < 8.0
        assert np.abs(np.diff(angles, 2, axis=0)).max() * rate**2 < 150.0


@pytest.mark.parametrize("name", NAMES)
def test_bodies_do_not_pass_through_what_is_around_or_through_each_other(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    stage = Stage(scene)
    for agent in (scene.agent(label.performing_agent), scene.agent(label.target_agent)):
        own = {agent.name, label.target_object, "floor", f"chair_{agent.name}"}
        around = [g for g in stage.solid_geoms() if scene.owners[g] not in own]
        arms = np.concatenate([arm.geoms for arm in agent.arms])
        for index in range(0, len(recording), 6):
            stage.show(recording.state(index))
            assert stage.closest(arms, around, limit_m=0.1)[0] > -0.01
            assert stage.closest(agent.core_geoms, around, limit_m=0.1)[0] > -0.01
    still = [g for g in stage.solid_geoms() if scene.owners[g] not in {*scene.agents, label.target_object}]
    for index in range(0, len(recording), 6):
        stage.show(recording.state(index))
        assert stage.closest(scene.geoms_of(label.target_object), still, limit_m=0.1)[0] > -0.001


@pytest.mark.parametrize("name", PUT)
def test_what_was_made_accessible_rests_nearer_to_the_target_agent(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    stage = Stage(recording.scene, recording.at(label.end_s))
    support = "white_box" if name in ("accessible_d", "accessible_e") else "table"
    assert support_of(stage, label.target_object, DEFAULT.contact) == support
    base = recording.scene.initial.qpos[recording.scene.agent(label.target_agent).base][:2]
    away = np.linalg.norm(_thing(recording)[[0, -1], :2] - base, axis=1)
    assert away[1] < away[0] - 0.25


@pytest.mark.parametrize(("name", "side"), GIVEN.items())
def test_what_is_given_passes_from_hand_to_hand(name: str, side: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    taker, giver = label.target_agent, label.performing_agent
    stage = Stage(recording.scene, recording.at(label.end_s))
    holding = holding_of(stage, label.target_object, DEFAULT.contact)
    assert holding is not None
    assert holding.hands == ((taker, side),)
    near = [_gaps_m(recording, agent, side) < DEFAULT.contact.grip_m for agent in (giver, taker)]
    assert near[0].sum() > 60
    assert (near[0] & near[1]).sum() >= 10, "both hold it for a while"
    in_the_air = _thing(recording)[:, 2] > _thing(recording)[0, 2] + 0.01
    assert np.all((near[0] | near[1])[in_the_air]), "it never hangs in the air"


@pytest.mark.parametrize("name", GIVEN)
def test_the_hands_carry_it_without_a_jump(name: str) -> None:
    recording = recorded(name)
    steps = np.linalg.norm(np.diff(_thing(recording)[:, :3], 2, axis=0), axis=1)
    assert steps.max() * 900 < 15.0


@pytest.mark.parametrize("name", NAMES)
def test_who_gets_it_looks_at_it_in_the_end(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert _off_rad(recording, label.end_s) < np.radians(25)


@pytest.mark.parametrize("name", NAMES)
def test_the_target_agent_sits_or_stands_with_hands_at_rest(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    target = recording.scene.agent(label.target_agent)
    stage = Stage(recording.scene, recording.at(label.start_s))
    assert posture_of(stage, target, DEFAULT.contact) == ("standing" if name in STANDING else "sitting")
    resting = [rests_on(stage, arm, DEFAULT.contact) for arm in target.arms]
    assert resting == ([None, "table"] if name == "give_c" else [None, None])


@pytest.mark.parametrize("name", NAMES)
def test_displaced_demonstrations_still_work(name: str) -> None:
    recording = DEMONSTRATIONS[name].record(seed=11, distance_m=0.03, angle_rad=np.radians(5))
    label = _label(recording)
    holding = holding_of(Stage(recording.scene, recording.at(label.end_s)), label.target_object, DEFAULT.contact)
    assert holding is not None
    assert [agent for agent, _ in holding.hands] == (["P2"] if name in GIVEN else [])


def _scene(*things: Thing) -> Scene:
    return Room("test", PEOPLE, things, TABLE).scene()


@pytest.mark.parametrize("distance_m", [0.45, 0.60, 0.80])
def test_a_near_place_is_at_its_distance_on_the_table_and_free(distance_m: float) -> None:
    free = near(_scene(on_table("cup", -0.2, -0.4)), "cup", "P1", "P2", distance_m)
    scene = _scene(on_table("cup", -0.2, -0.4), on_table("book", *free[:2]))
    place = near(scene, "cup", "P1", "P2", distance_m)
    shoulders = np.mean([Stage(scene).shoulder(arm).position for arm in scene.agent("P2").arms], axis=0)
    for x, y, z in (free, place):
        assert np.hypot(x - shoulders[0], y - shoulders[1]) == pytest.approx(distance_m, abs=0.101)
        assert abs(x) < 0.35
        assert z == pytest.approx(TABLE.height_m)
    assert np.hypot(place[0] - free[0], place[1] - free[1]) > 0.11


def test_a_near_place_is_in_sight() -> None:
    scene = _scene(on_table("cup", -0.2, -0.4), on_table("screen", 0.1, 0.0))
    x, y, _ = near(scene, "cup", "P1", "P2", 0.80)
    assert abs(y) > 0.25 or x > 0.1


def test_where_there_is_no_table_nothing_is_put() -> None:
    with pytest.raises(SceneError, match="no place 3 m from 'P2' for 'cup'; clear the support before that agent"):
        near(_scene(on_table("cup", -0.2, -0.4)), "cup", "P1", "P2", 3.0)


@pytest.mark.parametrize("taking", ["left", "right"])
def test_things_are_held_out_between_the_two_before_the_chest(taking: str) -> None:
    scene = _scene(on_table("cup", -0.2, -0.4))
    place = np.array(held_out(scene, Roles("P1", "P2", "cup", taking), taking, 0.55))
    shoulder = Stage(scene).shoulder(scene.agent("P2").arm(taking)).position
    assert -0.1 < place[0] < 0.3
    assert 0.1 < shoulder[2] - place[2] < 0.3


def test_nothing_can_be_handed_over_that_was_put_down() -> None:
    steps = (Take("cup", "right"), PutDown((-0.2, -0.1, 0.72)), HandOver("right"))
    with pytest.raises(SceneError, match="P1: cup: nothing is held any more; let a Take come before"):
        demonstrate(Script("give", "P1", "P2", "cup", steps), _scene(on_table("cup", -0.2, -0.2)), seed=0)


def test_what_was_handed_over_is_not_the_performers_any_more() -> None:
    steps = (Take("cup", "right"), HoldUp((0.1, 0.1, 0.85), 0.5), HandOver("right"), PutDown((0.2, 0.0, 0.72)))
    with pytest.raises(SceneError, match="P1: cup: nothing is held any more"):
        demonstrate(Script("give", "P1", "P2", "cup", steps), _scene(on_table("cup", -0.2, -0.2)), seed=0)


def test_what_is_held_out_too_far_away_cannot_be_taken() -> None:
    steps = (Take("cup", "right"), HoldUp((-0.45, -0.3, 1.1), 0.5), HandOver("right"))
    with pytest.raises(SceneError, match=r"P2: right_palm: the right hand ends .* nearer to the target agent"):
        demonstrate(Script("give", "P1", "P2", "cup", steps), _scene(on_table("cup", -0.2, -0.2)), seed=0)


def test_hands_lie_down_before_anything_happens() -> None:
    steps = (Take("cup", "right"), LayHand("P2", "right", (0.2, 0.2, 0.72)))
    with pytest.raises(SceneError, match="P1: it has begun already; say first how everybody is at rest"):
        demonstrate(Script("give", "P1", "P2", "cup", steps), _scene(on_table("cup", -0.2, -0.2)), seed=0)
