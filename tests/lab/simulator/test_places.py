from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.errors import SceneError, UnknownNameError
from taskgist.moving.steps import lift_m
from taskgist.world import Stage, object_points
from taskgist_lab.simulator import Person, Roles, Room, Thing, demonstrate, hold_up, put_behind
from taskgist_lab.simulator.places import BELOW_EYES_M, before_face, behind, on_top
from taskgist_lab.simulator.room import TABLE, left, on_table, right

Array = NDArray[np.float64]
PEOPLE = (left(1.80, 0.67), right(1.66, 0.67))


def _room(*things: Thing, people: tuple[Person, ...] = PEOPLE) -> Room:
    return Room("test", people, things, TABLE)


def _meets_box(eye: Array, points: Array, thing: Thing) -> NDArray[np.bool_]:
    """Whether segments from an eye to points (n, 3) meet a box: the slab test, written anew."""
    cos, sin = math.cos(thing.yaw_rad), math.sin(thing.yaw_rad)
    to_local = np.array([(cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)])
    middle = np.array(thing.position_m) + (0.0, 0.0, thing.height_m / 2)
    start, ends = to_local @ (eye - middle), (points - middle) @ to_local.T
    along = ends - start
    half = np.array(thing.size_m) / 2
    near, far = (-half - start) / along, (half - start) / along
    enter, leave = np.minimum(near, far).max(axis=1), np.maximum(near, far).min(axis=1)
    return np.asarray((enter <= leave) & (leave >= 0.0) & (enter <= 1.0))


@pytest.mark.parametrize("occluder", ["white_box", "screen"])
@pytest.mark.parametrize("yaw_deg", [-20.0, 0.0, 15.0])
def test_all_lines_of_sight_to_a_hidden_thing_meet_the_occluder(occluder: str, yaw_deg: float) -> None:
    box = on_table(occluder, 0.1, 0.0, yaw_deg)
    scene = _room(on_table("cup", -0.2, -0.5), box).scene()
    place = behind(scene, "cup", occluder, "P2")
    stage = Stage(scene)
    cup = object_points(stage, "cup", 0.01) - (-0.2, -0.5, TABLE.height_m) + place
    assert np.all(_meets_box(stage.eye(scene.agent("P2")).position, cup, box))
    assert place[2] == pytest.approx(TABLE.height_m)
    assert place[0] < 0.1


def test_nothing_is_hidden_behind_what_is_too_small() -> None:
    scene = _room(on_table("cup", -0.2, -0.5), on_table("tape", 0.1, 0.0)).scene()
    with pytest.raises(SceneError, match="no place behind 'tape' hides 'cup' from 'P2'"):
        behind(scene, "cup", "tape", "P2")


def test_hiding_places_are_free() -> None:
    things = (on_table("cup", -0.2, -0.5), on_table("screen", 0.2, 0.0))
    first = np.array(behind(_room(*things).scene(), "cup", "screen", "P2"))
    in_the_way = on_table("tape", first[0], first[1])
    second = np.array(behind(_room(*things, in_the_way).scene(), "cup", "screen", "P2"))
    assert np.linalg.norm(second - first) > (0.075 + 0.09) / 2


def test_hiding_places_are_on_the_table() -> None:
    at_the_edge = on_table("white_box", -0.25, 0.0)
    with pytest.raises(SceneError, match="take a larger occluder"):
        behind(_room(on_table("cup", 0.2, -0.5), at_the_edge).scene(), "cup", "white_box", "P2")


def test_a_thing_is_shown_on_the_line_of_sight() -> None:
    scene = _room(on_table("cup", 0.0, 0.3)).scene()
    stage = Stage(scene)
    own, other = (stage.eye(scene.agent(name)).position for name in ("P2", "P1"))
    place = np.array(before_face(scene, "P1", "P2", "right", 0.5)) + (0.0, 0.0, BELOW_EYES_M)
    assert np.linalg.norm(place - own) == pytest.approx(0.5, abs=0.05)
    assert np.cross(place - own, other - own) == pytest.approx(np.zeros(3), abs=1e-9)


def test_who_sits_far_away_shows_from_farther() -> None:
    near = before_face(_room().scene(), "P1", "P2", "right", 0.4)
    far = before_face(_room(people=(left(1.60, 1.2), right(1.66, 0.67))).scene(), "P1", "P2", "right", 0.4)
    assert far[0] < near[0] - 0.2


def test_carried_things_pass_over_what_stands_in_the_way_only() -> None:
    stage = Stage(_room(on_table("cup", -0.2, 0.0), on_table("bottle", 0.0, 0.0)).scene())
    start, end = np.array([-0.2, 0.0, 0.8]), np.array([0.2, 0.0, 0.8])
    bottle = on_table("bottle", 0.0, 0.0).height_m
    assert lift_m(stage, "cup", start=start, end=end) > bottle
    assert lift_m(stage, "cup", start=start, end=end + (0.0, 0.6, 0.0)) < bottle / 2


def test_the_top_of_a_thing_is_the_middle_of_its_upper_face() -> None:
    stage = Stage(_room(on_table("white_box", 0.1, 0.2, 30)).scene())
    assert on_top(stage, "white_box") == pytest.approx((0.1, 0.2, TABLE.height_m + 0.26))


def test_who_cannot_reach_says_so() -> None:
    room = _room(on_table("cup", 0.0, 0.0), people=(left(1.60, 1.6), right(1.66, 0.67)))
    scene = room.scene()
    with pytest.raises(SceneError, match="put the thing or its goal nearer to the performing agent"):
        demonstrate(hold_up(Roles("P1", "P2", "cup", "right"))(scene), scene, seed=0)


def test_unknown_things_are_named() -> None:
    scene = _room(on_table("cup", 0.0, 0.0), on_table("white_box", 0.2, 0.0)).scene()
    with pytest.raises(UnknownNameError, match="did you mean 'cup'"):
        put_behind(Roles("P1", "P2", "cap", "right"), occluder="white_box")(scene)
