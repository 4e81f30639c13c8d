"""Ordinary rooms: they are the same for the same seed, nothing in them overlaps, and truth is what a plan shows."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import mujoco
import pytest

from taskgist.perspective.effort import ABILITIES
from taskgist_lab.evaluation import ordinary_rooms
from taskgist_lab.evaluation.ordinary_rooms import Answer, Pair, RoomsFound, sheets, spot_of
from taskgist_lab.ordinary.furnishing import furnished
from taskgist_lab.ordinary.furniture import Spot, cabinet, drawer, table, wall
from taskgist_lab.ordinary.rooms import FurnishedRoom, Placed, distance_m
from taskgist_lab.ordinary.things import KINDS, thing_of
from taskgist_lab.ordinary.truth import Truth, Truths, needs
from taskgist_lab.simulator.room import Person
from taskgist_lab.view import ordinary_room_picture
from tests.lab.ordinary import judged

ROOMS = range(4)
FLOOR = Spot("floor", (0, 0, 0), (0, 0))
STANDING = Person("P", 1.75, (2.0, 2.0), 0.0, "standing")


def plain_room(*pieces, placed: Placed, person: Person = STANDING, door: bool = True) -> FurnishedRoom:  # type: ignore[no-untyped-def]
    return FurnishedRoom("plain", pieces, (person,), (placed,), {}, door)


def placed(place: tuple[float, float, float], spot: Spot = FLOOR, piece=None, kind: str = "cup") -> Placed:  # type: ignore[no-untyped-def]
    return Placed(thing_of(kind, "thing", place), kind, spot, piece)


def truth(room: FurnishedRoom) -> Truth:
    return Truths(room).of(room.people[0], room.placed[0])


@pytest.mark.parametrize("number", ROOMS)
def test_seed_and_number_make_a_room(number: int) -> None:
    first, again = furnished(3, number), furnished(3, number)
    assert first == again
    assert first.scene().bundle == again.scene().bundle
    assert first != furnished(4, number)


@pytest.mark.parametrize("number", ROOMS)
def test_people_and_things_do_not_touch_what_they_should_not(number: int) -> None:
    room = furnished(3, number)
    scene = room.scene()
    data = mujoco.MjData(scene.model)
    data.qpos[:] = scene.initial.qpos
    mujoco.mj_forward(scene.model, data)
    for contact in data.contact:
        owners = {scene.owners[geom] for geom in contact.geom}
        if owners & set(scene.objects):
            assert contact.dist > -0.002, owners
        elif len(owners) == 2 and not owners & {"floor"}:
            assert contact.dist > -0.06, owners  # upholstery and clothes give way


@pytest.mark.parametrize("number", ROOMS)
def test_things_rest_on_their_spots(number: int) -> None:
    for each in furnished(3, number).placed:
        x, y, z = each.thing.position_m
        assert z == pytest.approx(each.spot.at_m[2])
        if each.piece is not None:
            local = each.piece.local(x, y)
            for off, middle, half in zip(local, each.spot.at_m, each.spot.half_m, strict=False):
                assert abs(off - middle) <= half + 1e-9
            assert each.thing.height_m < each.spot.clear_m


@pytest.mark.parametrize("number", ROOMS)
def test_only_what_is_shut_in_or_walled_off_is_for_nobody(number: int) -> None:
    room = furnished(3, number)
    truths = Truths(room)
    for person in room.people:
        for each in room.placed:
            beyond = each.middle_m[0] > 7.0 and not room.door
            assert (truths.of(person, each) is Truth.NOBODY) == (each.spot.shut or beyond)


def test_most_pairs_are_judged() -> None:
    room = furnished(3, 0)
    truths = Truths(room)
    told = [truths.of(person, each) for person in room.people for each in room.placed]
    assert told.count(Truth.DEBATABLE) < len(told) / 4


@pytest.mark.parametrize(
    ("place", "right"),
    [
        ((2.6, 2.0, 0.0), Truth.ABLE),
        ((6.0, 5.0, 0.0), Truth.ABLE),  # a walk
        ((2.5, 2.0, 1.8), Truth.ABLE),
        ((2.5, 2.0, 2.1), Truth.DEBATABLE),  # on tiptoe
    ],
)
def test_height_and_walks(place: tuple[float, float, float], right: Truth) -> None:
    assert truth(plain_room(placed=placed(place))) is right


@pytest.mark.parametrize(("from_edge", "right"), [(0.1, Truth.ABLE), (0.5, Truth.ABLE), (1.0, Truth.DEBATABLE)])
def test_a_table_is_reached_over_by_an_arm_and_a_lean(from_edge: float, right: Truth) -> None:
    board = table("table", (4.0, 3.0), size_m=(2.0, 2.0, 0.74))
    cup = placed((3.0 + from_edge, 3.0, 0.74), board.spots[0], board)
    assert truth(plain_room(board, placed=cup)) is right


def test_closed_is_closed_and_open_is_open() -> None:
    for shut, right in ((True, Truth.NOBODY), (False, Truth.ABLE)):
        piece = cabinet("cupboard", (4.0, 0.3), math.pi / 2, low_m=0.8, high_m=1.3, shut=shut)
        cup = placed((4.0, 0.3, 0.82), piece.spots[0], piece)
        assert truth(plain_room(piece, placed=cup)) is right
    for out_m, right in ((0.0, Truth.NOBODY), (0.3, Truth.ABLE)):
        piece = drawer("drawer", (4.0, 0.3), math.pi / 2, out_m=out_m)
        x, y, z = piece.spots[0].at_m
        cup = placed((*piece.point(x, y), z), piece.spots[0], piece)
        assert truth(plain_room(piece, placed=cup)) is right


def test_a_shelf_whose_front_is_at_the_wall_is_not_got_at() -> None:
    piece = cabinet("shelf", (4.0, 0.3), -math.pi / 2, low_m=0.8, high_m=1.3)
    fence = wall("fence", (2.0, 0.05), (6.0, 0.05))
    cup = placed((4.0, 0.3, 0.82), piece.spots[0], piece)
    assert truth(plain_room(piece, fence, placed=cup)) is Truth.DEBATABLE


def test_what_stands_in_between_is_in_the_way() -> None:
    walls = [wall(f"wall {n}", *ends) for n, ends in enumerate(((((4.0, 0.0), (4.0, 6.0))),))]
    near = placed((4.3, 2.0, 0.0))
    assert truth(plain_room(*walls, placed=near, person=replace(STANDING, position_m=(3.7, 2.0)))) is Truth.DEBATABLE


def test_needs_are_told() -> None:
    room = plain_room(placed=placed((6.0, 5.0, 0.0), kind="book"))
    assert needs(room, STANDING, room.placed[0]) == (
        "walking more than 2 m",
        "bending or crouching",
        "taking a flat thing",
    )
    room = plain_room(placed=placed((2.3, 2.0, 1.0)))
    assert needs(room, STANDING, room.placed[0]) == ("an arm",)


def test_every_kind_of_thing_has_a_size_and_a_scene() -> None:
    for kind, told in KINDS.items():
        thing = thing_of(kind, kind, (0, 0, 0))
        assert thing.height_m == told.height_m
        assert told.radius_m <= math.hypot(*told.size_m)


def test_a_closed_cupboard_has_no_gap() -> None:
    """Rays from the middle of each shut spot, in all directions, meet the piece itself."""
    for piece in (
        cabinet("box", (0, 0), low_m=0.5, high_m=1.5, boards_m=(1.0,), shut=True),
        drawer("unit", (0, 0)),
        cabinet("counter", (0, 0), size_m=(0.6, 1.6), high_m=0.87, shut=True, top_m=0.04),
    ):
        room = mujoco.MjSpec()
        piece.add_to(room)
        model = room.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        for spot in (each for each in piece.spots if each.shut):
            start = (*piece.point(*spot.at_m[:2]), spot.at_m[2] + 0.03)
            for turn in range(0, 360, 3):
                for rise in range(-88, 89, 4):
                    a, b = math.radians(turn), math.radians(rise)
                    way = (math.cos(a) * math.cos(b), math.sin(a) * math.cos(b), math.sin(b))
                    assert mujoco.mj_ray(model, data, start, way, None, 1, -1, None) > 0, (piece.name, turn, rise)


def test_distance_to_furniture_minds_heights() -> None:
    hung = cabinet("hung", (0.0, 0.0), low_m=1.4, high_m=1.9)
    assert distance_m(hung, (1.0, 0.0)) == pytest.approx(1.0 - 0.15)
    assert distance_m(hung, (0.0, 0.0)) == pytest.approx(0.0)
    assert distance_m(hung, (0.0, 0.0), below_m=1.3) == math.inf


# --- The measure.


def pair(truth: Truth, level: int | None, spot: str = "table") -> Pair:
    return Pair("room", "P", "cup", spot, ("an arm",), dict.fromkeys(ABILITIES, Answer(truth, level, "why", 1.0)))


def test_what_is_wrong_and_what_is_not() -> None:
    assert Answer(Truth.ABLE, 5).is_wrong
    assert not Answer(Truth.ABLE, 4).is_wrong
    assert Answer(Truth.NOBODY, 4).is_wrong
    assert not Answer(Truth.NOBODY, 5).is_wrong
    assert not any(Answer(Truth.DEBATABLE, level).is_wrong for level in (0, 5, None))
    assert not any(Answer(truth, None).is_wrong for truth in Truth)


def test_shares_are_counted() -> None:
    pairs = (pair(Truth.ABLE, 5), pair(Truth.ABLE, 1, "floor"), pair(Truth.NOBODY, 2), pair(Truth.DEBATABLE, 5))
    found = RoomsFound(0, 1, pairs)
    assert found.missed("reach").text == "1 of 2 (50.0 %)"
    assert found.invented("grasp").plain == {"wrong": 1, "of": 1, "share": 1.0}
    assert {name: shares["see"].text for name, shares in found.by(spot_of).items()} == {
        "floor": "0 of 1 (0.0 %)",
        "table": "1 of 1 (100.0 %)",
    }
    assert found.levels("see") == {"0": 0, "1": 1, "2": 0, "3": 0, "4": 0, "5": 1, "unknown": 0}
    assert found.reasons("see") == {"why": 1}


def test_rooms_are_told_in_their_order(monkeypatch: pytest.MonkeyPatch) -> None:
    rooms = [furnished(judged.SEED, number) for number in range(3)]
    answered = {room.name: [pair(Truth.ABLE, number), pair(Truth.NOBODY, 5)] for number, room in enumerate(rooms)}
    monkeypatch.setattr(ordinary_rooms, "judged_room", lambda room: iter(answered[room.name]))
    found = ordinary_rooms.judged_rooms(count=3, seed=judged.SEED, processes=2)
    assert found.pairs == tuple(each for room in rooms for each in answered[room.name])


def test_times_are_those_of_a_truth() -> None:
    found = RoomsFound(0, 1, (pair(Truth.ABLE, 5), pair(Truth.NOBODY, 5)))
    assert found.times_ms(Truth.ABLE, "see") == (1.0, 1.0, 1.0)
    assert math.isnan(found.times_ms(Truth.DEBATABLE, "see")[0])
    assert set(found.to_json()["abilities"]["see"]["taken_ms"]) == {"able", "nobody"}


def test_an_unknown_level_is_counted_apart() -> None:
    assert RoomsFound(0, 1, (pair(Truth.ABLE, None),)).levels("see")["unknown"] == 1


def test_a_room_is_judged_drawn_and_told(tmp_path) -> None:  # type: ignore[no-untyped-def]
    room, found = furnished(judged.SEED, 0), judged.found()
    pairs = found.pairs
    assert len(pairs) == len(room.people) * len(room.placed)
    assert all(bool(each.reason) == each.is_wrong for pair in pairs for each in pair.answers.values())
    document = json.loads(json.dumps(found.to_json()))
    assert document["abilities"]["reach"]["able_called_impossible"] == found.missed("reach").plain
    assert all(len(row) == len(sheet.header) for sheet in sheets(found) for row in sheet.rows)
    assert ordinary_room_picture(room, pairs, "reach", tmp_path / "plan.png").stat().st_size > 10_000
