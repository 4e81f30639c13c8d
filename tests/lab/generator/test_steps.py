"""Steps and looks of the generator's performers, one by one."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.moving import Take
from taskgist.moving.hand_pose import upright
from taskgist.moving.steps_from_above import LiftAway, PutInto, TakeFromAbove, Turn, cornered
from taskgist.recording import Recording
from taskgist.settings import DEFAULT
from taskgist.world import Scene, Stage, object_points, support_of
from taskgist.world.geometry.transforms import yaw_of
from taskgist_lab.generator.furnishing import Shelf
from taskgist_lab.generator.hiding_means import DrawBack, PutOnBoard, inside
from taskgist_lab.generator.offering_means import turn_towards
from taskgist_lab.generator.outcomes import (
    check_before_eyes,
    check_farther,
    check_hidden,
    check_shown,
    seen_first,
    share_in_view,
    would_be_hidden,
)
from taskgist_lab.generator.things import OpenBox
from taskgist_lab.simulator import Person, Roles, Room, Script, Step, Table, Thing, demonstrate, hold_up

TABLE = Table("table", size_m=(0.70, 1.40, 0.74))
SHELF = Shelf("shelf", (-0.55, -0.72), math.radians(95), (0.26, 0.44), (0.12, 1.0, 1.4))
CUBE = Thing("cube", (0.06, 0.06, 0.06), (-0.15, -0.15, 0.74))
PICTURE = Thing("picture", (0.014, 0.18, 0.22), (-0.12, 0.0, 0.74), math.pi / 2)
BIN = OpenBox("bin", (0.2, 0.2, 0.16), (-0.12, -0.45, 0.74))
PEOPLE = (Person("P1", 1.78, (-0.65, 0.0), 0.0, "standing"), Person("P2", 1.66, (0.68, 0.0), math.pi))
ROLES = Roles("P1", "P2", "cube", "right")


@cache
def scene(*things: Thing) -> Scene:
    return Room("room", PEOPLE, things, TABLE, (SHELF,)).scene()


def played(script: Script, *things: Thing) -> Recording:
    return demonstrate(script, scene(*things), seed=0, name="played")


def script(*steps: Step, thing: str = "cube") -> Script:
    return Script("put away", "P1", "P2", thing, steps)


def last(recording: Recording, thing: str) -> np.ndarray:
    return np.array(recording.qpos[-1, recording.scene.object_slice(thing)])


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_picture_is_turned_with_its_face_to_the_other(side: str) -> None:
    roles = Roles("P1", "P2", "picture", side)
    recording = played(turn_towards(roles)(scene(PICTURE)), PICTURE)
    pose = last(recording, "picture")
    eye = Stage(recording.scene).eye(recording.scene.agent("P2")).position
    towards = math.atan2(eye[1] - pose[1], eye[0] - pose[0])
    assert abs(math.sin(yaw_of(pose[3:]) - towards)) < 1e-6
    assert pose[:3] == pytest.approx((-0.12, 0.0, 0.85), abs=1e-6)


def test_too_far_a_turn_is_refused() -> None:
    turned = Thing("picture", (0.014, 0.18, 0.22), (-0.12, 0.0, 0.74), math.radians(-20.0))
    roles = Roles("P1", "P2", "picture", "left")
    with pytest.raises(SceneError, match="too far to be turned"):
        turn_towards(roles)(scene(turned))


def test_a_hand_from_above_points_down_and_puts_straight_down() -> None:
    goal = (-0.12, -0.45, 0.748)
    steps = (TakeFromAbove("cube", "right", math.radians(60)), PutInto(goal), LiftAway(0.2))
    recording = played(script(*steps), CUBE, BIN)
    assert last(recording, "cube")[:3] == pytest.approx((*goal[:2], goal[2] + 0.03), abs=1e-6)
    cube, frames = recording.scene.object_slice("cube"), recording.qpos
    low = frames[:, cube][:, 2] < 0.74 + 0.16
    inside_bin = np.abs(frames[:, cube][:, :2] - goal[:2]).max(axis=1) < 0.09
    away = np.linalg.norm(frames[:, cube][:, :2] - CUBE.position_m[:2], axis=1) > 0.1
    assert np.all(inside_bin[low & away])


def test_what_is_put_on_a_board_comes_from_the_front() -> None:
    place = SHELF.place(1, in_m=-0.04)
    recording = played(script(Take("cube", "right"), PutOnBoard(place, SHELF.yaw_rad), DrawBack()), CUBE)
    stage = Stage(recording.scene, recording.state(len(recording) - 1))
    assert support_of(stage, "cube", DEFAULT.contact) == "shelf"
    assert last(recording, "cube")[:3] == pytest.approx((*place[:2], place[2] + 0.03), abs=1e-6)


def test_corners_are_kept() -> None:
    way = [upright("right", np.array(place), (1.0, 0.0)) for place in ((0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0))]
    kept = np.array([hand.palm for hand in cornered(way)])
    assert len(kept) == 2 + 2 * 3
    assert kept[2] == pytest.approx((0, 0, 1))
    assert kept[1] == pytest.approx((0, 0, 0.95))
    assert kept[3] == pytest.approx((0.05, 0, 1))


def test_lines_of_sight() -> None:
    screen = Thing("screen", (0.04, 0.4, 0.3), (0.0, -0.15, 0.74))
    assert share_in_view(Stage(scene(CUBE)), "P2", "cube") == 1.0
    assert share_in_view(Stage(scene(CUBE, screen)), "P2", "cube") == 0.0
    stage = Stage(scene(CUBE, screen))
    points = object_points(stage, "cube", 0.02)
    assert would_be_hidden(stage, "P2", "cube", points)
    assert not would_be_hidden(stage, "P2", "cube", points, but=("screen",))
    assert not would_be_hidden(stage, "P2", "cube", points + (0.0, 0.0, 0.5))
    with pytest.raises(SceneError, match="'cube' is not in view in the beginning"):
        seen_first(ROLES, hold_up(ROLES))(scene(CUBE, screen))
    assert seen_first(ROLES, hold_up(ROLES))(scene(CUBE)).task == "show"


def test_a_bin_hides_what_is_low_enough() -> None:
    deep = OpenBox("bin", (0.24, 0.24, 0.25), (-0.12, -0.45, 0.74))
    place, rim_m = inside(scene(CUBE, deep), ROLES, "bin")
    assert rim_m == pytest.approx(0.99)
    assert np.abs(np.array(place[:2]) - (-0.12, -0.45)).max() < 0.09
    flat = OpenBox("bin", (0.24, 0.24, 0.05), (-0.12, -0.45, 0.74))
    with pytest.raises(SceneError, match="'bin' does not hide 'cube' from 'P2'"):
        inside(scene(CUBE, flat), ROLES, "bin")


def test_outcomes_are_looked_at() -> None:
    shown = played(hold_up(ROLES, distance_m=0.5)(scene(CUBE)), CUBE)
    check_shown(shown)
    check_before_eyes(shown)
    with pytest.raises(SceneError, match="played: 'cube' is not hidden in the end"):
        check_hidden(shown)
    with pytest.raises(SceneError, match="'cube' is not farther off in the end"):
        check_farther(shown)
    away = played(script(Take("cube", "right"), PutInto((-0.25, -0.35, 0.74)), LiftAway(0.1)), CUBE)
    with pytest.raises(SceneError, match="is not brought before the eyes"):
        check_before_eyes(away)


def test_turning_back_and_forth_ends_where_it_began() -> None:
    take = TakeFromAbove("picture", "right", math.radians(50))
    again = (take, Turn(0.6), LiftAway(0.25), take, Turn(-0.6), LiftAway(0.25))
    recording = played(script(*again, thing="picture"), PICTURE)
    before, after = recording.qpos[0, recording.scene.object_slice("picture")], last(recording, "picture")
    assert after[:3] == pytest.approx(before[:3], abs=1e-6)
    assert abs(after[3:] @ before[3:]) == pytest.approx(1.0, abs=1e-9)
