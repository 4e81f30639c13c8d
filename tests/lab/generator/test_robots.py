"""Robots in generated rooms: they stand where there is room, look where they should, and are done something for."""

import math
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.moving.gaze import aimed
from taskgist.world import Scene, Stage, builtin_profiles
from taskgist.world.geometry.transforms import normalized
from taskgist_lab.generator import rooms as robots
from taskgist_lab.generator import simulate
from taskgist_lab.generator.arrangement import Arrangement
from taskgist_lab.generator.rooms import around_a_table
from taskgist_lab.simulator import Person, Room, Table, Thing


def draw(seed: int, *, target: bool = True) -> Arrangement:
    return around_a_table(np.random.default_rng(seed), robots=target)


@pytest.fixture
def only_robots(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(robots, "TARGET_SHARE", 1.0)
    monkeypatch.setattr(robots, "BYSTANDER_SHARE", 1.0)


def with_robot(profile: str) -> Scene:
    people = (Person("P1", 1.75, (-0.7, 0.0), 0.0, "standing"), robots.robot("P2", "jido", (0.85, 0.0), math.pi))
    changed = (people[0], replace(people[1], profile=profile))
    return Room("room", changed, (Thing("cup", (0.08, 0.1), (0.0, 0.1, 0.72)),), Table("table")).scene()


def test_only_robots_that_come_with_taskgist_are_drawn() -> None:
    assert set(robots.ROBOTS) <= set(builtin_profiles())
    for profile in robots.ROBOTS:
        with_robot(profile)


def test_about_as_many_robots_are_drawn_as_it_says() -> None:
    rooms = [draw(seed) for seed in range(150)]
    targets = np.mean([room.target.profile != "human" for room in rooms])
    assert targets == pytest.approx(robots.TARGET_SHARE, abs=0.08)
    assert all(room.performer.profile == "human" for room in rooms)
    assert all(draw(seed, target=False).target.profile == "human" for seed in range(30))


@pytest.mark.usefixtures("only_robots")
def test_robots_stand_by_away_from_people() -> None:
    rooms = [draw(seed, target=False) for seed in range(30)]
    standing_by = [(room, other) for room in rooms for other in room.others if other.profile != "human"]
    assert len(standing_by) > 15
    for room, other in standing_by:
        for person in (room.performer, room.target):
            assert math.dist(person.position_m, other.position_m) >= robots.FROM_PEOPLE_M


@pytest.mark.usefixtures("only_robots")
def test_something_is_done_for_a_robot_which_looks_at_it() -> None:
    recording = simulate("show", seed=2, number=1)
    label, scene = recording.label, recording.scene
    assert label is not None
    target = scene.agent(label.target_agent)
    assert target.profile.name in robots.ROBOTS
    columns = scene.joint_indices(label.target_agent)
    moved = np.ptp(recording.qpos[:, columns], axis=0) > 0.0
    head = {axis.joint for axis in (target.profile.pan, target.profile.tilt) if axis is not None}
    assert {name for name, moves in zip(scene.joints(label.target_agent), moved, strict=True) if moves} <= head
    assert np.any(moved)


@pytest.mark.parametrize("profile", ["jido", "hrp2", "human"])
def test_heads_of_all_kinds_turn_to_what_they_look_at(profile: str) -> None:
    scene = with_robot(profile)
    stage, agent = Stage(scene), scene.agent("P2")
    places = np.array([(-0.2, 0.1, 1.2), (-0.7, 0.2, 1.6), (-0.4, -0.5, 1.1)])
    frames = np.tile(scene.initial.qpos, (len(places), 1))
    angles = aimed(stage, agent, frames, places)
    assert agent.profile.pan is not None
    assert agent.profile.tilt is not None
    columns = [agent.joints[agent.profile.pan.joint], agent.joints[agent.profile.tilt.joint]]
    for place, pair in zip(places, angles, strict=True):
        eye = stage.show(scene.initial.replace(dict(zip(columns, pair, strict=True)))).eye(agent)
        cosine = float(eye.matrix[:, 0] @ normalized(place - eye.position))
        assert cosine > math.cos(math.radians(4.0))


def test_nobody_finds_a_neck_where_there_is_none() -> None:
    scene = with_robot("jido")
    agent = scene.agent("P2")
    neckless = replace(agent, profile=replace(agent.profile, pan=None))
    with pytest.raises(SceneError, match="a head that pans and tilts"):
        aimed(Stage(scene), neckless, scene.initial.qpos[None], np.zeros((1, 3)))
