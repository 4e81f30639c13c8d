"""Put away and hide away: plausible motions, and what the scripts promise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import SceneError, UnknownNameError
from taskgist.recording import Label, Recording
from taskgist.settings import DEFAULT
from taskgist.world import Stage, hand_gap_m, holding_of, posture_of, rests_on, support_of
from taskgist_lab.paper import STUDY
from taskgist_lab.simulator import Person, Roles, Room, Thing, demonstrate
from taskgist_lab.simulator.means import FARTHER_M, far_from, put_behind_far, put_far_from
from taskgist_lab.simulator.room import TABLE, left, on_table, right
from tests.moving.motions import assert_smooth, assert_through_nothing
from tests.shipped import recording as recorded

Array = NDArray[np.float64]
DEMONSTRATIONS = {d.name: d for task in ("put away", "hide away") for d in STUDY[task]}
NAMES = tuple(DEMONSTRATIONS)
PUT_AWAY = STUDY["put away"]
STANDING = ("put_away_b", "put_away_c", "hide_away_b")
BUSY = ("put_away_b", "put_away_d")
WATCHING = ("put_away_a", "put_away_c")
PEOPLE = (left(1.80, 0.67), right(1.66, 0.67))
ROLES = Roles("P1", "P2", "cup", "right")


def _room(*things: Thing, people: tuple[Person, ...] = PEOPLE) -> Room:
    return Room("test", people, things, TABLE)


def _label(recording: Recording) -> Label:
    assert recording.label is not None
    return recording.label


def _thing(recording: Recording) -> Array:
    return recording.qpos[:, recording.scene.object_slice(_label(recording).target_object)]


def _speed_m_s(recording: Recording) -> Array:
    return np.asarray(np.linalg.norm(np.diff(_thing(recording)[:, :3], axis=0), axis=1) * 30)


def _sight(recording: Recording, time_s: float) -> tuple[Array, Array, Array]:
    """The target agent's eye, where it looks, and where the thing is."""
    label = _label(recording)
    stage = Stage(recording.scene, recording.at(time_s))
    eye = stage.eye(recording.scene.agent(label.target_agent))
    return eye.position, eye.matrix[:, 0], stage.body_position(recording.scene.object_body(label.target_object))


def _off_rad(recording: Recording, time_s: float) -> float:
    """Angle between the target agent's face and the thing."""
    eye, ahead, thing = _sight(recording, time_s)
    return float(np.arccos((thing - eye) @ ahead / np.linalg.norm(thing - eye)))


def _from_pelvis_m(recording: Recording, time_s: float) -> float:
    label, state = _label(recording), recording.at(time_s)
    pelvis = state.qpos[recording.scene.base_slice(label.target_agent)][:2]
    return float(np.linalg.norm(state.qpos[recording.scene.object_slice(label.target_object)][:2] - pelvis))


@pytest.mark.parametrize("name", NAMES)
def test_they_are_labelled_while_everything_is_still(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    times, speed = recording.times_s[1:], _speed_m_s(recording)
    assert recording.provenance.simulated
    assert label.task == " ".join(name.split("_")[:2])
    assert speed[times < label.start_s + 0.4].max() == 0.0
    assert speed[np.abs(times - label.end_s) < 0.5].max() == 0.0
    assert speed.max() > 0.3


@pytest.mark.parametrize("name", NAMES)
def test_joints_move_within_limits_and_without_jerks(name: str) -> None:
    assert_smooth(recorded(name))


@pytest.mark.parametrize("name", NAMES)
def test_bodies_do_not_pass_through_what_is_around(name: str) -> None:
    assert_through_nothing(recorded(name))


@pytest.mark.parametrize("name", NAMES)
def test_it_lies_on_the_table_before_and_after_and_nobody_holds_it(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    for time_s in (label.start_s, label.end_s):
        stage = Stage(scene, recording.at(time_s))
        assert support_of(stage, label.target_object, DEFAULT.contact) == "table"
        holding = holding_of(stage, label.target_object, DEFAULT.contact)
        assert holding is not None
        assert holding.hands == ()
        gap = stage.closest(scene.geoms_of(label.target_object), scene.geoms_of("table"), limit_m=0.1)[0]
        assert abs(gap) < 0.001
        gaps = [
            hand_gap_m(stage, a, label.target_object, limit_m=1.0) for n in scene.agents for a in scene.agent(n).arms
        ]
        assert min(gaps) > 0.1


@pytest.mark.parametrize("name", NAMES)
def test_the_target_agent_sits_or_stands_with_empty_hands(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    target = recording.scene.agent(label.target_agent)
    for time_s in (label.start_s, label.end_s):
        stage = Stage(recording.scene, recording.at(time_s))
        assert posture_of(stage, target, DEFAULT.contact) == ("standing" if name in STANDING else "sitting")
        assert [rests_on(stage, arm, DEFAULT.contact) for arm in target.arms] == [None, None]


@pytest.mark.parametrize("name", NAMES)
def test_things_end_farther_off(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert _from_pelvis_m(recording, label.end_s) > _from_pelvis_m(recording, label.start_s) + FARTHER_M


@pytest.mark.parametrize("name", WATCHING)
def test_who_watches_has_it_before_the_eyes_at_both_ends(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    assert _off_rad(recording, label.start_s) < np.radians(29)
    assert _off_rad(recording, label.end_s) < np.radians(10)


@pytest.mark.parametrize("name", BUSY)
def test_who_is_busy_looks_up_only_while_it_moves(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    moving = recording.times_s[1:][_speed_m_s(recording) > 0.1]
    assert _off_rad(recording, label.start_s) > np.radians(32)
    assert min(_off_rad(recording, float(t)) for t in moving[::5]) < np.radians(15)
    assert _off_rad(recording, label.end_s) > np.radians(32)


@pytest.mark.parametrize("name", NAMES)
def test_straight_lines_say_whether_it_is_hidden(name: str) -> None:
    recording, label = recorded(name), _label(recorded(name))
    scene = recording.scene
    stage = Stage(scene, recording.at(label.end_s))
    eye, _, thing = _sight(recording, label.end_s)
    line = thing - eye
    body = scene.agent(label.target_agent).eye_exclude_body
    geoms, _ = stage.cast(eye, (line / np.linalg.norm(line))[None], exclude_body=body)
    expected = {label.target_object} if label.task == "put away" else {"screen", "white_box"}
    assert scene.owners[geoms[0]] in expected


@pytest.mark.parametrize("name", NAMES)
def test_displaced_demonstrations_find_a_place_and_arms_get_there(name: str) -> None:
    recording = DEMONSTRATIONS[name].record(seed=11, distance_m=0.03, angle_rad=np.radians(5))
    label = _label(recording)
    assert (
        support_of(Stage(recording.scene, recording.at(label.end_s)), label.target_object, DEFAULT.contact) == "table"
    )


@pytest.mark.parametrize("distance_m", [0.8, 0.9, 1.0])
def test_the_nearest_place_that_is_far_enough_is_taken(distance_m: float) -> None:
    scene = _room(on_table("cup", 0.1, -0.1), on_table("book", -0.1, 0.4)).scene()
    place = np.array(far_from(scene, ROLES, distance_m))
    away = float(np.linalg.norm(place[:2] - (0.67, 0.0)))
    assert distance_m <= away < distance_m + 0.1
    assert place[2] == pytest.approx(TABLE.height_m)
    assert np.all(np.abs(place[:2]) < np.array(TABLE.size_m[:2]) / 2)


def test_places_are_free_and_in_view() -> None:
    bare = _room(on_table("cup", 0.1, -0.1)).scene()
    first = np.array(far_from(bare, ROLES, 0.9))
    taken = _room(on_table("cup", 0.1, -0.1), on_table("tape", first[0], first[1])).scene()
    assert np.linalg.norm(np.array(far_from(taken, ROLES, 0.9)) - first) > (0.075 + 0.09) / 2
    covered = _room(on_table("cup", 0.1, -0.1), on_table("screen", first[0] + 0.2, first[1])).scene()
    assert np.linalg.norm(np.array(far_from(covered, ROLES, 0.9)) - first) > 0.1


def test_places_that_nobody_gets_to_are_not_found() -> None:
    scene = _room(on_table("cup", 0.1, -0.1)).scene()
    with pytest.raises(SceneError, match="cup: no free place 3 m from 'P2' that 'P1' gets to; ask for less"):
        put_far_from(ROLES, distance_m=3.0)(scene)


def test_what_is_hidden_must_be_farther_off_too() -> None:
    scene = _room(on_table("cup", -0.2, -0.45), on_table("screen", 0.1, 0.0)).scene()
    with pytest.raises(SceneError, match=r"the place behind 'screen' is not 0.15 m farther from 'P2'"):
        put_behind_far(ROLES, occluder="screen")(scene)


def test_nobody_can_be_busy_with_what_is_not_there() -> None:
    scene = PUT_AWAY[0].room.scene()
    script = replace(PUT_AWAY[0].means(scene), target_returns_to="boook")
    with pytest.raises(UnknownNameError, match="did you mean 'book'"):
        demonstrate(script, scene, seed=0)
