"""Relations of one moment: what any person would say, and laws that hold in every room."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.observe import (
    carried_by,
    direction,
    distance,
    distance_change,
    facing,
    gaze,
    joint_attention,
    looks_at,
    mutual_gaze,
    next_to,
    sight,
    touching,
)
from taskgist.perspective import visibility
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist.world.state import Hold
from tools.rooms import Person, Room, Thing, random_room, table, wall

ME = Person("P1", (0.0, 0.0))
YOU = Person("P2", (2.0, 0.0), math.pi)
CUP = Thing("cup", (0.04, 0.05), (0.7, 0.0, 0.77), "cylinder")
BALL = Thing("ball", (0.1,), (1.0, 0.0, 1.2), "sphere")


def room(*things: Thing, people: tuple[Person, ...] = (ME,)) -> Stage:
    return Room(things, people).stage()


# --- Lines of sight


def test_what_stands_in_the_open_is_in_free_sight_also_behind_ones_back() -> None:
    for place in ((1.0, 0.0, 1.2), (-1.0, 0.0, 1.2), (-0.5, 0.0, 0.05), (0.0, 1.0, 0.3)):
        seen = sight(room(replace(BALL, place=place)), "P1", "ball")
        assert seen is not None
        assert (seen.value, seen.share, seen.blockers) == ("free", 1.0, ())


def test_what_is_behind_a_wall_is_blocked_by_the_wall() -> None:
    seen = sight(room(wall("wall", 0.5), BALL), "P1", "ball")
    assert seen is not None
    assert (seen.value, seen.blockers) == ("blocked", (("wall", 1.0),))


def test_half_a_ball_above_a_wall_is_partly_in_sight() -> None:
    eye_m = float(room(BALL).eye(room(BALL).scene.agent("P1")).position[2])
    stage = room(wall("wall", 0.6, half=(0.001, 1.0, eye_m / 2)), replace(BALL, place=(1.1, 0.0, eye_m)))
    seen = sight(stage, "P1", "ball")
    assert seen is not None
    assert seen.value == "partly"
    assert seen.share == pytest.approx(0.5, abs=0.02)
    assert seen.share + sum(share for _, share in seen.blockers) == pytest.approx(1.0)


@pytest.mark.parametrize("number", range(8))
def test_sight_is_the_share_of_the_whole_sphere(number: int) -> None:
    """Its slow twin casts rays all around the eye, with no cone, and looks through the own body."""
    stage = random_room(number).stage()
    eye, own = stage.eye(stage.scene.agent("P1")), stage.scene.agent("P1").geoms
    rng = np.random.default_rng(number)
    directions = rng.normal(size=(400_000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    others = np.setdiff1d(np.flatnonzero(stage.seen), own)
    first, _ = stage.cast_at(others, eye.position, directions)
    for name in stage.scene.objects:
        shapes = stage.scene.seen_geoms(name)
        alone, _ = stage.cast_at(shapes, eye.position, directions)
        there = np.flatnonzero(alone >= 0)
        seen = sight(stage, "P1", name)
        assert seen is not None
        error = 4 * 0.5 / math.sqrt(len(there)) + 0.02
        assert seen.share == pytest.approx(np.isin(first[there], shapes).mean(), abs=error)


@pytest.mark.parametrize("number", range(8))
def test_sight_is_what_is_visible_where_the_thing_is_in_view(number: int) -> None:
    stage = random_room(number, (320, 240)).stage()
    for name in stage.scene.objects:
        seen, line = visibility(stage, "P1", name), sight(stage, "P1", name)
        assert line is not None
        assert seen is not None
        if seen.visible_px:
            assert line.value != "blocked"
        if seen.off_gaze_rad < math.radians(20) and not any(owner == "P1" for owner, _ in seen.occluders):
            assert line.share == pytest.approx(seen.visible_share, abs=0.06)


# --- Attention


def looking(at: str, angle_deg: float) -> Stage:
    person = replace(ME, joints_deg=((at, angle_deg),))
    return room(replace(BALL, place=(2.0, 0.0, 1.64)), people=(person,))


@pytest.mark.parametrize(("angle_deg", "looks"), [(0, True), (10, True), (-10, True), (35, False), (-60, False)])
def test_one_looks_at_what_the_head_points_to(angle_deg: float, looks: bool) -> None:
    assert looks_at(looking("head_pan", angle_deg), "P1", "ball") is looks


def test_of_two_things_the_one_nearer_to_the_gaze_is_looked_at() -> None:
    left = Thing("left", (0.05,), (1.0, 0.10, 1.62), "sphere")
    right = Thing("right", (0.05,), (1.0, -0.15, 1.62), "sphere")
    found = gaze(room(left, right), "P1")
    assert found is not None
    assert found.target == "left"
    assert looks_at(room(left, right), "P1", "right") is False


def test_what_is_behind_a_wall_is_not_looked_at() -> None:
    behind = replace(BALL, place=(1.5, 0.0, 1.6))
    found = gaze(room(wall("wall", 0.8), behind), "P1")
    assert found is not None
    assert found.target is None


def test_people_who_face_each_other_look_at_each_other() -> None:
    assert mutual_gaze(room(CUP, people=(ME, YOU)), "P1", "P2") is True
    assert mutual_gaze(room(CUP, people=(ME, replace(YOU, yaw=0.0))), "P1", "P2") is False


@pytest.mark.parametrize("number", range(8))
def test_mutual_gaze_is_symmetric(number: int) -> None:
    stage = random_room(number).stage()
    assert mutual_gaze(stage, "P1", "P2") is mutual_gaze(stage, "P2", "P1")
    assert joint_attention(stage, "P1", "P2", "cup") is joint_attention(stage, "P2", "P1", "cup")


def test_both_look_at_the_thing_between_them() -> None:
    down = (("head_tilt", -35.0),)
    people = (replace(ME, joints_deg=down), replace(YOU, place=(1.4, 0.0), joints_deg=down))
    stage = room(table(0.7), replace(CUP, place=(0.7, 0.0, 1.1)), people=people)
    assert joint_attention(stage, "P1", "P2", "cup") is True
    assert mutual_gaze(stage, "P1", "P2") is False


# --- Places


@pytest.mark.parametrize(
    ("x", "y", "sides"),
    [
        (1.0, 0.0, {"front"}),
        (-1.0, 0.0, {"behind"}),
        (0.0, 1.0, {"left"}),
        (0.0, -1.0, {"right"}),
        (1.0, 1.0, {"front", "left"}),
        (-1.0, -1.0, {"behind", "right"}),
        (0.02, 0.0, set()),
    ],
)
def test_my_left_and_right(x: float, y: float, sides: set[str]) -> None:
    found = direction(room(replace(BALL, place=(x, y, 2.2))), "P1", "ball")
    assert found is not None
    assert set(found.sides) == sides


def test_turning_the_chest_brings_left_to_the_front_and_leaning_changes_nothing() -> None:
    left = replace(BALL, place=(0.0, 1.0, 1.0))
    for joints, sides in (
        ((("torso_turn", 45.0),), ("left", "front")),
        ((("torso_lean", 50.0),), ("left",)),
    ):
        found = direction(room(left, people=(replace(ME, joints_deg=joints),)), "P1", "ball")
        assert found is not None
        assert found.sides == sides


OPPOSITE = {"left": "right", "right": "left", "front": "behind", "behind": "front"}


def sides(stage: Stage, agent: str, name: str, of: str | None = None) -> set[str]:
    found = direction(stage, agent, name, of=of)
    assert found is not None
    return set(found.sides)


def test_what_is_between_me_and_the_book_is_in_front_of_it() -> None:
    book = Thing("book", (0.1, 0.07, 0.02), (1.2, 0.0, 0.74))
    stage = room(book, replace(CUP, place=(0.9, 0.0, 0.77)), replace(BALL, place=(1.2, 0.5, 0.8)), people=(ME, YOU))
    assert sides(stage, "P1", "cup", "book") == {"front"}
    assert sides(stage, "P2", "cup", "book") == {"behind"}
    assert sides(stage, "P1", "ball", "book") == {"left"}
    assert sides(stage, "P2", "ball", "book") == {"right"}


@pytest.mark.parametrize("number", range(12))
def test_who_stands_opposite_sees_all_sides_swapped(number: int) -> None:
    rng = np.random.default_rng(number)
    cup, brick = (Thing(name, (0.03, 0.03, 0.03), (*rng.uniform(-0.6, 0.6, 2), 0.8)) for name in ("cup", "brick"))
    x, y, _ = brick.place
    away = np.array((math.cos(number), math.sin(number))) * 2.0
    people = (Person("P1", (x + away[0], y + away[1])), Person("P2", (x - away[0], y - away[1])))
    stage = room(cup, brick, people=people)
    assert {OPPOSITE[side] for side in sides(stage, "P1", "cup", "brick")} == sides(stage, "P2", "cup", "brick")
    turned = room(cup, people=(Person("P1", (1.5, 1.0), 0.3), Person("P2", (1.5, 1.0), 0.3 + math.pi)))
    assert {OPPOSITE[side] for side in sides(turned, "P1", "cup")} == sides(turned, "P2", "cup")


def all_of(stage: Stage) -> dict[str, object]:
    """Every relation of a room, but those numbers that are measured by rays."""
    found: dict[str, object] = {}
    for name in stage.scene.objects:
        far, where, seen = distance(stage, "P1", name), direction(stage, "P1", name), sight(stage, "P1", name)
        assert far is not None
        assert where is not None
        assert seen is not None
        found |= {
            f"{name} distance": (far.value, round(far.metres, 6)),
            f"{name} side": set(where.sides),
            f"{name} sight": seen.value,
            f"{name} faced": facing(stage, "P1", name),
            f"{name} touched": touching(stage, "P1", name),
            f"{name} carried": carried_by(stage, name),
        }
    found["side of the brick"] = sides(stage, "P1", "cup", "brick")
    found["gaze"] = gaze(stage, "P1") and gaze(stage, "P1").target  # type: ignore[union-attr]
    found["beside"] = next_to(stage, "cup", "brick")
    return found


@pytest.mark.parametrize("number", range(10))
def test_moving_and_turning_the_whole_room_changes_nothing(number: int) -> None:
    there = random_room(number)
    assert all_of(there.stage()) == all_of(there.moved(0.7 * number + 0.3, 1.5, -2.5).stage())


@pytest.mark.parametrize("number", range(10))
def test_a_mirror_swaps_left_and_right_alone(number: int) -> None:
    there = random_room(number)
    people = tuple(
        replace(p, joints_deg=tuple((j, a if j == "head_tilt" else -a) for j, a in p.joints_deg))
        for p in there.mirrored().people
    )
    mirror = {"left": "right", "right": "left", "front": "front", "behind": "behind"}
    before, after = all_of(there.stage()), all_of(replace(there.mirrored(), people=people).stage())
    for key, value in before.items():
        assert after[key] == ({mirror[each] for each in value} if isinstance(value, set) else value), key


def test_near_far_and_how_it_changes() -> None:
    near, nearer, far = (distance(room(replace(BALL, place=(x, 0.0, 1.0))), "P1", "ball") for x in (0.9, 0.6, 3.0))
    assert near is not None
    assert nearer is not None
    assert far is not None
    assert (near.value, far.value) == ("near", "far")
    assert near.metres == pytest.approx(0.9)
    assert distance_change(near, near) == "same"
    assert distance_change(far, near) == distance_change(near, nearer) == "nearer"
    assert distance_change(near, far) == "farther"
    lamp = distance(room(replace(BALL, place=(0.0, 0.0, 4.0))), "P1", "ball")
    assert lamp is not None
    assert lamp.value == "far", "what hangs high above somebody is not near"


def test_facing_is_the_chest_and_not_the_head() -> None:
    aside = (("head_pan", 70.0),)
    assert facing(room(BALL, people=(replace(ME, joints_deg=aside),)), "P1", "ball") is True
    assert (
        facing(room(replace(BALL, place=(0.0, 1.0, 1.2)), people=(replace(ME, joints_deg=aside),)), "P1", "ball")
        is False
    )
    assert facing(room(BALL, people=(ME, YOU)), "P2", "P1") is True


def test_things_that_stand_together_are_next_to_each_other_and_need_not_touch() -> None:
    stage = room(CUP, Thing("box", (0.1, 0.1, 0.05), (0.7, 0.24, 0.77)), replace(BALL, place=(0.7, -1.0, 0.8)))
    assert (next_to(stage, "cup", "box"), touching(stage, "cup", "box")) == (True, False)
    assert next_to(stage, "cup", "ball") is False
    leaning = room(CUP, Thing("box", (0.1, 0.1, 0.05), (0.7, 0.145, 0.77)))
    assert touching(leaning, "cup", "box") is touching(leaning, "box", "cup") is True


def in_hand(*things: Thing) -> Stage:
    """A room in which the first thing hangs at the palm of the right hand."""
    stage = room(*things)
    palm = stage.site(stage.scene.agent("P1").arm("right").palm_site).position
    at = stage.scene.object_slice(things[0].name)
    lifted = np.array(stage.state.qpos[at])
    lifted[:3] = palm
    return stage.show(stage.state.replace(at=at, to=lifted))


def test_what_is_in_a_hand_is_carried_and_touched() -> None:
    stage = in_hand(Thing("cup", (0.02, 0.02, 0.05), (1.0, 0.0, 0.8)))
    assert carried_by(stage, "cup") == ("P1",)
    assert touching(stage, "P1", "cup") is True
    assert carried_by(room(table(0.7), CUP), "cup") == ()


def test_what_stands_on_a_carried_tray_is_carried_too() -> None:
    tray = Thing("tray", (0.2, 0.15, 0.01), (1.0, 0.0, 0.8))
    stage = room(tray, Thing("cup", (0.03, 0.03, 0.05), (1.0, 0.0, 0.86)), people=(ME, YOU))
    held = stage.state.with_holding([Hold("P2", "left", "tray")])
    palm = stage.site(stage.scene.agent("P2").arm("left").palm_site).position
    for name, above in (("tray", 0.0), ("cup", 0.06)):
        at = stage.scene.object_slice(name)
        held = held.replace(at=at, to=(*(palm + (0.0, 0.0, above)), 1.0, 0.0, 0.0, 0.0))
    assert carried_by(stage.show(held), "tray") == ("P2",)
    assert carried_by(stage, "cup") == ("P2",)


# --- Unknown


def test_what_was_not_tracked_is_unknown() -> None:
    stage = room(CUP, BALL, people=(ME, YOU))
    without_cup = Stage(stage.scene, stage.state.without(["cup"]))
    for found in (
        sight(without_cup, "P1", "cup"),
        distance(without_cup, "P1", "cup"),
        direction(without_cup, "P1", "cup"),
        direction(without_cup, "P1", "ball", of="cup"),
        facing(without_cup, "P1", "cup"),
        looks_at(without_cup, "P1", "cup"),
        touching(without_cup, "P1", "cup"),
        carried_by(without_cup, "cup"),
    ):
        assert found is None
    without_head = Stage(stage.scene, stage.state.without(["P1/head"]))
    assert gaze(without_head, "P1") is None
    assert sight(without_head, "P1", "ball") is None
    assert looks_at(without_head, "P2", "P1") is None
    assert distance(without_head, "P1", "ball") == distance(stage, "P1", "ball")
    without_arm = Stage(stage.scene, stage.state.without(["P1/left_arm"]))
    assert touching(without_arm, "P1", "ball") is None


def test_nothing_looked_at_is_unknown_where_something_is_not_tracked() -> None:
    stage = room(CUP, people=(replace(ME, joints_deg=(("head_tilt", 50.0),)),))
    found = gaze(stage, "P1")
    assert found is not None
    assert found.target is None
    assert gaze(Stage(stage.scene, stage.state.without(["cup"])), "P1") is None


def test_names_that_are_not_there_are_refused() -> None:
    stage = room(CUP, people=(ME, YOU))
    for ask in (
        lambda: sight(stage, "P3", "cup"),
        lambda: sight(stage, "P1", "cap"),
        lambda: sight(stage, "P1", "P1"),
        lambda: direction(stage, "P1", "cup", of="cap"),
        lambda: direction(stage, "P1", "cup", of="cup"),
        lambda: touching(stage, "cup", "cup"),
        lambda: mutual_gaze(stage, "P1", "P3"),
        lambda: carried_by(stage, "P1"),
    ):
        with pytest.raises(UnknownNameError):
            ask()


def test_thresholds_of_relations_shape_no_fact_of_the_tree() -> None:
    wide = replace(DEFAULT, relations=replace(DEFAULT.relations, gaze_rad=1.0, near_m=3.0))
    assert wide.digest == DEFAULT.digest
    assert looks_at(looking("head_pan", 35), "P1", "ball", wide) is True
