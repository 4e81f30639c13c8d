"""Ordinary furnished rooms at random: who sits and stands where, and things where people leave them.

A living room of 7 × 6 m: a dining table with people on chairs in its middle, and along its walls some of sofa with
low table, bookshelf, closed cupboard, kitchen counter, desk with a drawer, bench, bed with night table. Behind one
wall is a second room, with a door open between them or with none::

    room = furnished(seed=7, number=3)
    scene = room.scene()

A room follows from seed and number alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.world.bodies.profile import Posture
from taskgist_lab.ordinary.furniture import (
    EDGE_M,
    Piece,
    Point,
    Spot,
    bed,
    bench,
    cabinet,
    chair,
    drawer,
    sofa,
    table,
    wall,
)
from taskgist_lab.ordinary.rooms import LENGTH_M, SECOND_M, WIDTH_M, FurnishedRoom, Placed, distance_m
from taskgist_lab.ordinary.things import KINDS, TWO_HANDS, thing_of
from taskgist_lab.simulator.room import Person

DOOR_M = 0.95
STATURES_M = (1.55, 1.90)
FEWEST, MOST_SEATED = 3, 6
"""People in a room at least, and most of them who sit."""
AT_TABLE_M = (0.28, 0.34)
"""How far the pelvis of somebody who sits at a table is from its edge: the thighs are under it."""
APART_M = 0.02
"""Free space between two things on one spot."""
TRIES = 60
ON_DINING_TABLE, LARGE_M2, ON_SMALL = 3, 0.1, 0.55
"""Things on a dining table; one lies on every other spot of that area and more, and on that share of smaller ones."""


def furnished(seed: int, number: int) -> FurnishedRoom:
    """A furnished room.

    Args:
        seed: Seed of all rooms.
        number: Which of them.
    """
    rng = np.random.default_rng((seed, number))
    door = bool(rng.random() < 0.5)
    furnisher = _Furnisher(rng)
    furnisher.pieces += _walls(rng, door)
    furnisher.dine()
    furnisher.fill_walls()
    furnisher.stand()
    furnisher.lay()
    return FurnishedRoom(
        f"ordinary-{seed}-{number:04d}",
        tuple(furnisher.pieces),
        tuple(furnisher.people),
        tuple(furnisher.placed),
        MappingProxyType(furnisher.seats),
        door,
    )


def _walls(rng: np.random.Generator, door: bool) -> Iterator[Piece]:
    far = LENGTH_M + SECOND_M
    yield wall("west wall", (0, 0), (0, WIDTH_M))
    yield wall("south wall", (0, 0), (far, 0))
    yield wall("north wall", (0, WIDTH_M), (far, WIDTH_M))
    yield wall("east wall", (far, 0), (far, WIDTH_M))
    if door:
        start = float(rng.uniform(1.2, WIDTH_M - 1.2 - DOOR_M))
        yield wall("inner wall", (LENGTH_M, 0), (LENGTH_M, start))
        yield wall("inner wall beyond", (LENGTH_M, start + DOOR_M), (LENGTH_M, WIDTH_M))
    else:
        yield wall("inner wall", (LENGTH_M, 0), (LENGTH_M, WIDTH_M))


@dataclass(frozen=True)
class Along:
    """A wall to furnish: its start, where its right end is seen from the room, and which way pieces before it face."""

    start_m: Point
    along_rad: float
    length_m: float

    def place(self, along_m: float, out_m: float) -> tuple[Point, float]:
        """Floor point so far along it and so far before it, and the heading of a piece there."""
        facing = self.along_rad + math.pi / 2
        x = self.start_m[0] + along_m * math.cos(self.along_rad) + out_m * math.cos(facing)
        y = self.start_m[1] + along_m * math.sin(self.along_rad) + out_m * math.sin(facing)
        return (x, y), facing


SIDES = (
    Along((0.9, 0.0), 0.0, LENGTH_M - 1.8),
    Along((LENGTH_M - 0.9, WIDTH_M), math.pi, LENGTH_M - 1.8),
    Along((0.0, WIDTH_M - 0.9), -math.pi / 2, WIDTH_M - 1.8),
)
"""South, north and west wall; nothing stands before the inner wall, where the door may be."""
OFF_WALL_M = 0.07
"""Backs of furniture are so far from the middle of a wall."""


class _Furnisher:
    """Puts furniture, people and things into a room, one after the other, where there is space for them."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.pieces: list[Piece] = []
        self.people: list[Person] = []
        self.placed: list[Placed] = []
        self.seats: dict[str, Piece] = {}

    def dine(self) -> None:
        """A table in the middle, chairs at its long sides, most of them taken."""
        rng = self.rng
        size = (rng.uniform(0.75, 0.95), rng.uniform(1.3, 1.6), rng.uniform(0.72, 0.76))
        yaw = math.pi / 2 * int(rng.integers(2))
        centre = (LENGTH_M / 2 + rng.uniform(-0.2, 0.2), WIDTH_M / 2 + rng.uniform(-0.15, 0.15))
        dining = table("dining table", centre, yaw, size_m=size, kind="dining table")
        self.pieces.append(dining)
        for number, (side, along) in enumerate(((-1, -1), (-1, 1), (1, -1), (1, 1))):
            taken, there = rng.random() < 0.55, rng.random() < 0.85
            if taken or there:
                back = rng.uniform(*AT_TABLE_M) if taken else 0.12
                place = dining.point(side * (size[0] / 2 + back), along * size[1] / 4)
                facing = yaw + (0.0 if side < 0 else math.pi)
                seat = chair(f"chair {number}", place, facing)
                self.pieces.append(seat)
                if taken:
                    self.seat(seat, place, facing)

    def fill_walls(self) -> None:
        """Some of the other furniture along the walls, from their left to their right."""
        groups = list(GROUPS)
        self.rng.shuffle(groups)
        for side in SIDES:
            along = float(self.rng.uniform(0.0, 0.3))
            while groups and along + groups[-1][0] <= side.length_m:
                breadth, put = groups.pop()
                put(self, side, along + breadth / 2)
                along += breadth + float(self.rng.uniform(0.25, 0.7))

    def stand(self) -> None:
        """People who stand about, one or two, or more where few sit."""
        for _ in range(max(int(self.rng.integers(1, 3)), FEWEST - len(self.people))):
            for _ in range(TRIES):
                place = (float(self.rng.uniform(0.8, LENGTH_M - 0.8)), float(self.rng.uniform(0.8, WIDTH_M - 0.8)))
                if self.is_free(place, 0.45):
                    self.add_person(place, float(self.rng.uniform(-math.pi, math.pi)), "standing")
                    break

    def is_free(self, place: Point, radius_m: float) -> bool:
        """Whether nothing and nobody stands within a circle on the floor."""
        clear = all(distance_m(piece, place) > radius_m for piece in self.pieces)
        return clear and all(math.dist(place, person.position_m) > radius_m + 0.25 for person in self.people)

    def seat(self, seat: Piece, place: Point, facing_rad: float) -> None:
        """Somebody on a seat, unless enough people are there."""
        if len(self.people) < MOST_SEATED:
            person = self.add_person(place, facing_rad, "sitting")
            self.seats[person.name] = seat

    def add_person(self, place: Point, yaw_rad: float, posture: Posture) -> Person:
        """Somebody, who looks a little down and aside."""
        name, stature = f"P{len(self.people) + 1}", float(self.rng.uniform(*STATURES_M))
        head = (float(self.rng.uniform(-25, 25)), float(self.rng.uniform(-20, 0)))
        self.people.append(Person(name, stature, place, yaw_rad, posture, head, chair=False))
        return self.people[-1]

    def lay(self) -> None:
        """One or two things on most spots, some on the floor, some in the second room."""
        for piece in self.pieces:
            for spot in piece.spots:
                self._lay_on(piece, spot)
        for area, count in ((((0.6, LENGTH_M - 0.6), (0.6, WIDTH_M - 0.6)), 3), (SECOND_ROOM, 2)):
            for _ in range(count):
                self._drop(area)

    def _lay_on(self, piece: Piece, spot: Spot) -> None:
        if piece.kind == "chair" and piece in self.seats.values():
            return
        large = spot.half_m[0] * spot.half_m[1] > LARGE_M2 / 4
        count = ON_DINING_TABLE if spot.name == "dining table top" else int(large or self.rng.random() < ON_SMALL)
        for _ in range(count):
            kind = self._kind(spot)
            if kind is None:
                return
            half = [max(0.0, edge + EDGE_M - KINDS[kind].radius_m) for edge in spot.half_m]
            for _ in range(TRIES):
                aside = [float(self.rng.uniform(-edge, edge)) for edge in half]
                place = piece.point(spot.at_m[0] + aside[0], spot.at_m[1] + aside[1])
                if self._put(kind, (*place, spot.at_m[2]), spot, piece):
                    break

    def _kind(self, spot: Spot) -> str | None:
        """A kind of thing that finds room on a spot with a hand beside and above it."""
        fitting = [
            name
            for name, kind in KINDS.items()
            if kind.height_m + (0.12 if kind.taken == TWO_HANDS else 0.07) < spot.clear_m
            and kind.radius_m < min(spot.half_m) + EDGE_M
            and (kind.taken != TWO_HANDS or kind.radius_m + 0.08 < max(spot.half_m))
        ]
        return str(self.rng.choice(fitting)) if fitting else None

    def _drop(self, area: tuple[Point, Point]) -> None:
        for _ in range(TRIES):
            place = (float(self.rng.uniform(*area[0])), float(self.rng.uniform(*area[1])))
            if self.is_free(place, 0.3):
                kind = str(self.rng.choice(list(KINDS)))
                self._put(kind, (*place, 0.0), Spot("floor", (*place, 0.0), (0.0, 0.0)), None)
                return

    def _bodies(self) -> Iterator[tuple[float, float, float, float]]:
        """Where people are: floor points (x, y), up to which height, and how far around. Who sits has feet ahead."""
        for person in self.people:
            x, y = person.position_m
            yield x, y, 2.0, 0.22
            if person.posture == "sitting":
                cos, sin = math.cos(person.yaw_rad), math.sin(person.yaw_rad)
                yield x, y, 0.6, 0.40
                yield x + 0.45 * cos, y + 0.45 * sin, 0.5, 0.30

    def _put(self, kind: str, place: tuple[float, float, float], spot: Spot, piece: Piece | None) -> bool:
        """Put a thing down where it touches neither another nor anybody."""
        radius = KINDS[kind].radius_m
        if any(math.dist(place[:2], part[:2]) < radius + part[3] and place[2] < part[2] for part in self._bodies()):
            return False
        for other in self.placed:
            near = math.dist(place[:2], other.thing.position_m[:2]) < radius + KINDS[other.kind].radius_m + APART_M
            if near and abs(place[2] - other.thing.position_m[2]) < 0.3:
                return False
        name = f"{kind} {len(self.placed)}"
        yaw = float(self.rng.uniform(-math.pi, math.pi))
        self.placed.append(Placed(thing_of(kind, name, place, yaw), kind, spot, piece))
        return True


SECOND_ROOM = ((LENGTH_M + 0.5, LENGTH_M + SECOND_M - 0.5), (0.5, WIDTH_M - 0.5))
"""Where things lie in the second room, by x and y."""


# --- What stands along walls: how broad, and who puts it there.


def _put_sofa(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.44)
    piece = sofa("sofa", place, facing)
    gap = float(room.rng.uniform(0.30, 0.45))
    low = table(
        "low table",
        piece.point(0.30 + gap + 0.25, 0.0),
        facing,
        size_m=(0.5, 0.9, room.rng.uniform(0.38, 0.46)),
        kind="low table",
    )
    room.pieces += [piece, low]
    if room.rng.random() < 0.7:
        room.seat(piece, piece.point(0.05, float(room.rng.uniform(-0.45, 0.45))), facing)


def _put_bookshelf(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.15)
    boards = np.cumsum(room.rng.uniform(0.32, 0.40, 4)) + 0.02
    room.pieces.append(cabinet("bookshelf", place, facing, boards_m=boards.tolist(), high_m=float(boards[-1]) + 0.36))


def _put_cupboard(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.2)
    room.pieces.append(
        cabinet(
            "cupboard", place, facing, kind="cupboard", size_m=(0.4, 0.9), boards_m=(0.5, 1.0), high_m=1.5, shut=True
        )
    )


def _put_open_cupboard(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.2)
    room.pieces.append(
        cabinet(
            "open cupboard", place, facing, kind="open cupboard", size_m=(0.4, 0.8), boards_m=(0.45, 0.9), high_m=1.3
        )
    )


def _put_counter(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.3)
    above, _ = side.place(along_m, OFF_WALL_M + 0.16)
    shut = bool(room.rng.random() < 0.5)
    room.pieces += [
        cabinet("counter", place, facing, kind="counter", size_m=(0.6, 1.6), high_m=0.87, shut=True, top_m=0.04),
        cabinet(
            "wall cupboard", above, facing, kind="wall cupboard", size_m=(0.32, 1.4), low_m=1.42, high_m=1.95, shut=shut
        ),
    ]


def _put_desk(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.35)
    desk = table("desk", place, facing, size_m=(0.7, 1.2, 0.74), kind="desk")
    beside = desk.point(-0.12, 0.84)
    out = 0.3 if room.rng.random() < 0.6 else 0.0
    seat = chair("desk chair", desk.point(0.35 + float(room.rng.uniform(*AT_TABLE_M)), 0.0), facing + math.pi)
    room.pieces += [desk, drawer("drawer unit", beside, facing, height_m=0.6, out_m=out), seat]
    if room.rng.random() < 0.6:
        room.seat(seat, seat.centre_m, seat.yaw_rad)


def _put_bench(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m, OFF_WALL_M + 0.22)
    piece = bench("bench", place, facing)
    room.pieces.append(piece)
    if room.rng.random() < 0.5:
        room.seat(piece, piece.point(0.02, float(room.rng.uniform(-0.3, 0.3))), facing)


def _put_bed(room: _Furnisher, side: Along, along_m: float) -> None:
    place, facing = side.place(along_m - 0.25, OFF_WALL_M + 0.48)
    piece = bed("bed", place, facing)
    beside, _ = side.place(along_m + 1.02, OFF_WALL_M + 0.22)
    out = 0.3 if room.rng.random() < 0.5 else 0.0
    room.pieces += [piece, drawer("night table", beside, facing, kind="night table", height_m=0.5, out_m=out)]


GROUPS: Sequence[tuple[float, Callable[[_Furnisher, Along, float], None]]] = (
    (1.9, _put_sofa),
    (0.9, _put_bookshelf),
    (0.9, _put_cupboard),
    (0.8, _put_open_cupboard),
    (1.6, _put_counter),
    (2.2, _put_desk),
    (1.2, _put_bench),
    (2.5, _put_bed),
)
"""Furniture along walls: its breadth in metres, and who puts it there."""
