"""Random rooms: who and what is in them, and that nobody and nothing is where something else is."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from taskgist.errors import SceneError
from taskgist.settings import DEFAULT
from taskgist.world import Stage, posture_of, support_of
from taskgist_lab.generator.arrangement import EDGE_M, Arrangement, apart, both, handy, nearer_to, off_the_way
from taskgist_lab.generator.furnishing import (
    STATURES_M,
    RoundTable,
    Shelf,
    Sofa,
    any_place,
    bearing_of,
    distance_m,
    on_top,
)
from taskgist_lab.generator.outcomes import check_room
from taskgist_lab.generator.rooms import DINING, HIGH, LOW, ROUND, around_a_table
from taskgist_lab.generator.things import LARGE, SMALL, MeshThing, any_of, radius_m
from taskgist_lab.simulator import Person, Room, Table
from taskgist_lab.simulator.room import Chair

SEEDS = range(60)
PERSON = Person("P1", 1.70, (-0.7, 0.0), 0.0)


@cache
def furnished(seed: int) -> Arrangement:
    arrangement = around_a_table(np.random.default_rng(seed))
    arrangement.put(any_of(arrangement.rng, SMALL))
    arrangement.add_distractors(6)
    return arrangement


def people(arrangement: Arrangement) -> list[Person]:
    return [arrangement.performer, arrangement.target, *arrangement.others]


def test_rooms_differ_in_everything() -> None:
    rooms = [furnished(seed) for seed in SEEDS]
    assert {type(room.table) for room in rooms} == {Table, RoundTable}
    heights = [room.table.height_m for room in rooms]
    assert min(heights) < 0.5
    assert max(heights) > 0.9
    assert {type(piece) for room in rooms for piece in room.furniture} >= {Sofa, Chair}
    assert {person.posture for room in rooms for person in (room.performer, room.target)} == {"sitting", "standing"}
    assert {len(people(room)) for room in rooms} >= {2, 3, 4}
    assert any(isinstance(thing, MeshThing) for room in rooms for thing in room.things)
    assert len({thing.rgba for room in rooms for thing in room.things}) > 5
    assert {room.performer.name for room in rooms} >= {"P1", "P2", "P3"}


def test_a_seed_decides_everything() -> None:
    again = around_a_table(np.random.default_rng(3))
    again.put(any_of(again.rng, SMALL))
    again.add_distractors(6)
    assert (again.things, people(again), again.furniture) == (
        furnished(3).things,
        people(furnished(3)),
        furnished(3).furniture,
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_people_have_peoples_sizes_and_names_of_their_own(seed: int) -> None:
    everybody = people(furnished(seed))
    assert len({person.name for person in everybody}) == len(everybody)
    for person in everybody:
        assert STATURES_M[0] <= person.stature_m <= STATURES_M[1]


@pytest.mark.parametrize("seed", SEEDS)
def test_things_lie_on_the_table_apart_from_each_other(seed: int) -> None:
    room = furnished(seed)
    for thing in room.things:
        place, radius = np.array(thing.position_m), radius_m(thing)
        assert place[2] == pytest.approx(room.table.height_m, abs=1e-3)
        assert on_top(room.table, place, radius + EDGE_M - 1e-3)
        for other in room.things:
            apart_m = math.dist(other.position_m[:2], thing.position_m[:2])
            assert other is thing or apart_m > radius + radius_m(other) + 0.04


def test_most_rooms_are_sound_and_compile_to_what_was_drawn() -> None:
    refused = 0
    for seed in range(12):
        room = furnished(seed)
        setting = room.setting(room.roles(room.things[0], "left", watches=1.0))
        scene = setting.room.scene()
        try:
            check_room(scene)
        except SceneError:
            refused += 1
            continue
        stage = Stage(scene)
        assert set(scene.agents) == {person.name for person in people(room)}
        for person in people(room):
            assert posture_of(stage, scene.agent(person.name), DEFAULT.contact) == person.posture
        for thing in room.things:
            assert support_of(stage, thing.name, DEFAULT.contact) == "table"
    assert refused <= 3


def test_a_room_in_which_somebody_stands_in_something_is_refused() -> None:
    inside = Room("room", (Person("P1", 1.7, (0.0, 0.0), 0.0, "standing"),), (), Table("table"))
    with pytest.raises(SceneError, match="'P1' and 'table' overlap"):
        check_room(inside.scene())


def test_a_room_in_which_furniture_overlaps_is_refused() -> None:
    shelf = Shelf("shelf", (0.2, 0.1), 0.0, (0.3, 0.5), (0.1, 0.7, 1.1))
    with pytest.raises(SceneError, match=r"'(shelf|table)' and '(shelf|table)' overlap"):
        check_room(Room("room", (), (), Table("table"), (shelf,)).scene())


def test_what_finds_no_place_is_refused() -> None:
    with pytest.raises(SceneError, match="no place for 'box'"):
        furnished(0).put(LARGE["box"](np.random.default_rng(0)), lambda _: False)


def test_postures_and_tables_are_as_asked_for() -> None:
    for seed in range(30):
        rng = np.random.default_rng(seed)
        room = around_a_table(rng, tables=(HIGH, ROUND), performer=("standing",), target=("standing",))
        assert {room.performer.posture, room.target.posture} == {"standing"}
        low = around_a_table(rng, tables=(LOW,), target=("sitting",))
        assert low.table.height_m < 0.55
        assert low.target.posture == "sitting"
        assert not low.target.chair
    dining = around_a_table(np.random.default_rng(0), tables=(DINING,))
    assert 0.70 <= dining.table.height_m <= 0.76


def test_two_at_a_table_look_across_it() -> None:
    for seed in SEEDS:
        room = furnished(seed)
        middle = np.array([*room.table.centre_m, 0.0])
        for person in (room.performer, room.target):
            assert abs(bearing_of(person, middle)) < math.radians(50)
            assert distance_m(person, middle) < 1.6


def test_bystanders_leave_the_performer_room_and_look_at_something() -> None:
    standing_by = [(furnished(seed), other) for seed in SEEDS for other in furnished(seed).others]
    humans = [(room, other) for room, other in standing_by if other.profile == "human"]
    assert len(humans) > 25
    assert any(other.head_deg != (0.0, 0.0) for _, other in humans)
    for room, other in humans:
        assert distance_m(room.performer, np.array(other.position_m)) > 1.0
        assert abs(other.head_deg[0]) <= 55


def test_the_hand_is_that_on_the_things_side() -> None:
    room = furnished(0)
    room.performer = PERSON
    left, right = (any_of(room.rng, SMALL) for _ in range(2))
    left, right = room.put_at(left, np.array([0.0, 0.5, 0.7])), room.put_at(right, np.array([0.0, -0.5, 0.7]))
    assert (room.hand_for(left), room.hand_for(right)) == ("left", "right")
    assert (room.hand_past(left, right), room.hand_past(right, left)) == ("right", "left")


def test_zones() -> None:
    before, far, aside = np.array([0.0, 0.0, 0.7]), np.array([0.8, 0.0, 0.7]), np.array([-0.7, 0.5, 0.7])
    assert handy(PERSON)(before)
    assert not handy(PERSON)(far)
    assert not handy(PERSON)(aside)
    assert apart(PERSON, 0.6, 0.8)(before)
    assert not apart(PERSON, 0.6, 0.8)(far)
    other = Person("P2", 1.7, (0.7, 0.0), math.pi)
    assert nearer_to(other, PERSON)(far)
    assert not nearer_to(PERSON, other)(far)
    assert not nearer_to(other, PERSON, by_m=0.2)(before)
    assert both(handy(PERSON), apart(PERSON, 0.6))(before)
    thing = furnished(0).put_at(any_of(np.random.default_rng(0), SMALL), far)
    assert not off_the_way(PERSON, thing)(np.array([0.2, 0.1, 0.7]))
    assert off_the_way(PERSON, thing)(np.array([0.2, 0.3, 0.7]))


@pytest.mark.parametrize("table", [Table("table", (0.3, -0.2), (0.6, 1.2, 0.7), 0.7), RoundTable("table", (1.0, 0.0))])
def test_places_on_a_table_are_on_it(table: Table) -> None:
    rng = np.random.default_rng(0)
    stage = Stage(Room("room", (), (), table, ()).scene())
    for _ in range(40):
        place = any_place(table, rng, 0.05)
        _, (distance,) = stage.cast(place + (0.0, 0.0, 0.1), [(0.0, 0.0, -1.0)])
        assert (distance == pytest.approx(0.1)) == on_top(table, place, 0.0)


@pytest.mark.parametrize("closed", [False, True])
def test_a_place_in_a_shelf_is_on_its_board(closed: bool) -> None:
    shelf = Shelf("shelf", (0.4, 0.3), 0.8, (0.3, 0.5), (0.1, 0.7, 1.1), closed)
    stage = Stage(Room("room", (), (), Table("table", (3.0, 0.0)), (shelf,)).scene())
    place = np.array(shelf.place(1, in_m=0.1, aside_m=-0.2))
    _, distances = stage.cast(place + (0.0, 0.0, 0.1), [(0.0, 0.0, -1.0), (0.0, 0.0, 1.0)])
    assert distances == pytest.approx([0.1, 0.4 - 0.02 - 0.1])
    front = np.array([math.cos(0.8), math.sin(0.8), 0.0])
    geoms, _ = stage.cast(place + (0.0, 0.0, 0.1), [front, -front])
    assert geoms[0] < 0
    assert (geoms[1] >= 0) == closed
