"""What any person would say: who gets at what in an ordinary room. From the room's plan alone, by published body sizes.

An able adult gets up, walks, bends, crouches and reaches. So a thing is got at where there is a free place on the floor
that leads to it, from where it is within a comfortable arm's length at its height, and nothing stands in between::

    truth = Truths(room)
    truth.of("P1", placed)      # Truth.ABLE, Truth.NOBODY or Truth.DEBATABLE

Nobody gets at what is shut in, or in a room without a way. What lies between the two (a narrow way, a long arm, a thing
above everyone's head) is debatable and not judged. The lengths are cautious: a person of that stature, not the longest
arm, does it with ease. Sources: [Pheasant 2003], forward grip reach 0.44 to 0.45 and vertical grip reach 1.18 to 1.19
of the stature; hips at a table's edge, trunk and arm come 0.75 m over it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from enum import Enum
from functools import cache

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist_lab.ordinary.furniture import Piece, Point
from taskgist_lab.ordinary.rooms import LENGTH_M, SECOND_M, WIDTH_M, FurnishedRoom, Placed, distance_m
from taskgist_lab.ordinary.things import KINDS
from taskgist_lab.simulator.room import Person


class Truth(Enum):
    """What any person would say."""

    ABLE = "an able adult gets at it"
    NOBODY = "nobody gets at it"
    DEBATABLE = "debatable"


GRID_M = 0.05
BODY_M = 0.25
"""Somebody who walks and stands at ease has so much space all round: half of the shoulders' breadth."""
BESIDE_M = 0.30
"""So far from the middle of others."""
UP_M = {"chair": 0.75, "sofa": 1.3, "bench": 0.75}
"""From a seat people get to a free place that is so near: the chair goes back; from a sofa one sidles out."""
LOW_M, HIGH, OVERHEAD = 0.45, 0.66, 0.95
"""Middles of things below this are bent or crouched for; above these shares of the stature, arms are raised."""
OVER_MOST = 1.10
"""Share of the stature up to which everybody grips at ease; 1.18 is the mean [Pheasant 2003]."""
AT_EASE_M = {"low": 0.60, "middle": 0.80, "high": 0.72, "overhead": 0.58}
"""How far from the middle of the feet things are taken at ease, at a stature of ``MEAN_M``. The middle: 0.25 m to the
edge of a table and 0.55 m over it."""
MEAN_M = 1.75
AT_HAND_M = (0.40, 1.15, 0.70)
"""Between these heights, and so far from the middle of the hips, things are taken sitting."""
FRONT_RAD = math.radians(50.0)
"""What is open at the front only is got at from so far aside."""
EYES = 0.88
"""Share of the stature up to which shelves are looked into."""
PASS_M = (0.10, 0.45)
"""Hands pass over what is no higher than this above the thing's underside, and beneath what is so high above it."""
FAR_M = 2.0
"""Walks longer than this are told as such."""
Cells = NDArray[np.bool_]
"""A truth for each cell of a grid over the floor."""


class Truths:
    """What any person would say of a room.

    Args:
        room: The room.
    """

    def __init__(self, room: FurnishedRoom) -> None:
        self.room = room
        x, y = np.arange(0.0, LENGTH_M + SECOND_M, GRID_M), np.arange(0.0, WIDTH_M, GRID_M)
        self._grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
        self._stands = cache(self._standing_places)
        self._about = cache(self._pieces_about)
        self._gets = cache(self._got)

    def of(self, person: Person, placed: Placed, ability: str = "reach") -> Truth:
        """Whether a person gets at a thing, or sees it.

        Args:
            person: Somebody in the room.
            placed: A thing in it.
            ability: ``see``, ``reach`` or ``grasp``. What somebody gets at is grasped, for all kinds of things here can
                be; and is seen, unless it may lie deep on a board over the eyes.
        """
        if placed.spot.shut or self._walled_off(placed):
            return Truth.NOBODY
        if ability == "see" and placed.thing.position_m[2] > EYES * person.stature_m:
            return Truth.DEBATABLE
        return self._gets(person.name, placed)

    def _got(self, name: str, placed: Placed) -> Truth:
        person = self._person(name)
        if placed.middle_m[2] > OVER_MOST * person.stature_m:
            return Truth.DEBATABLE
        if self._at_hand(person, placed):
            return Truth.ABLE
        places = self._stands(name)
        away_m = np.hypot(*(places - np.array(placed.middle_m[:2])).T)
        nearest_first = np.argsort(away_m, kind="stable")[: int((away_m <= _at_ease_m(person, placed)).sum())]
        return Truth.ABLE if any(self._gets_at(place, placed) for place in places[nearest_first]) else Truth.DEBATABLE

    def _at_hand(self, person: Person, placed: Placed) -> bool:
        """Whether somebody who sits has a thing beside or before the body, within the length of an arm."""
        seat, (x, y, z) = self.room.seats.get(person.name), placed.middle_m
        if seat is None or not AT_HAND_M[0] <= z <= AT_HAND_M[1]:
            return False
        near = math.dist(person.position_m, (x, y)) <= AT_HAND_M[2] * person.stature_m / MEAN_M
        return near and (placed.piece is seat or self._gets_at(person.position_m, placed))

    def _person(self, name: str) -> Person:
        return next(each for each in self.room.people if each.name == name)

    def _walled_off(self, placed: Placed) -> bool:
        """Whether it is in a room to which no door leads; everybody is in the living room."""
        return not self.room.door and placed.middle_m[0] > LENGTH_M

    def _standing_places(self, name: str) -> Array:
        """Free places on the floor that somebody gets to, (n, 2)."""
        person = self._person(name)
        seat = self.room.seats.get(name)
        free = self._free(person, seat)
        start = np.array(person.position_m)
        first = np.hypot(*np.moveaxis(self._grid - start, -1, 0)) <= (UP_M[seat.kind] if seat else BODY_M)
        reached = free & first & (self._grid[..., 0] < LENGTH_M)
        return np.asarray(self._grid[_flooded(reached, free)])

    def _free(self, person: Person, seat: Piece | None) -> Cells:
        """Where somebody stands at ease, by cells of the grid; the own chair is pushed away."""
        free = np.ones(self._grid.shape[:2], dtype=bool)
        for piece in self.room.pieces:
            if piece is seat and piece.kind == "chair":
                continue
            for box in piece.boxes:
                if box.top_m > 0.03 and box.under_m < 1.9:
                    gaps = np.abs(_local(piece, self._grid) - np.array(box.centre_m[:2])) - np.array(box.size_m[:2]) / 2
                    free &= np.hypot(*np.moveaxis(np.maximum(gaps, 0.0), -1, 0)) > BODY_M
        for other in self.room.people:
            if other is not person:
                away = self._grid - np.array(other.position_m)
                free &= np.hypot(away[..., 0], away[..., 1]) > BODY_M + BESIDE_M
        return free

    def _pieces_about(self, placed: Placed) -> tuple[Piece, ...]:
        """The other pieces that may stand between a thing and who is within arm's length of it."""
        most_m = max(AT_EASE_M.values()) * max(person.stature_m for person in self.room.people) / MEAN_M
        others = (piece for piece in self.room.pieces if piece is not placed.piece)
        return tuple(piece for piece in others if distance_m(piece, placed.middle_m[:2]) < most_m)

    def _gets_at(self, place: Point, placed: Placed) -> bool:
        """Whether a thing that is near enough is got at from a place: from its front, with nothing in between."""
        x, y, _ = placed.middle_m
        piece = placed.piece
        if piece is not None and placed.spot.front_only:
            ahead, aside = (a - b for a, b in zip(piece.local(*place), piece.local(x, y), strict=True))
            if abs(math.atan2(aside, ahead)) > FRONT_RAD:
                return False
        return not any(self._in_between(place, placed))

    def _in_between(self, place: Point, placed: Placed) -> Iterator[bool]:
        """Of every other piece and person, whether they stand between a place and a thing."""
        x, y, _ = placed.middle_m
        way = [(place[0] + (x - place[0]) * s, place[1] + (y - place[1]) * s) for s in np.linspace(0.0, 1.0, 15)]
        over_m, below_m = (placed.thing.position_m[2] + pass_m for pass_m in PASS_M)
        for piece in self._about(placed):
            yield any(distance_m(piece, point, over_m=over_m, below_m=below_m) < 0.03 for point in way[:-1])
        for person in self.room.people:
            if math.dist(person.position_m, place) > BODY_M:
                yield any(math.dist(person.position_m, point) < BESIDE_M for point in way)


def needs(room: FurnishedRoom, person: Person, placed: Placed) -> tuple[str, ...]:
    """What it takes somebody to get at a thing, beside an arm, in words: causes where it is called impossible."""
    found = []
    seat = room.seats.get(person.name)
    if seat is not None:
        found.append("getting up from a chair" if seat.kind == "chair" else f"getting up from a {seat.kind}")
    if math.dist(person.position_m, placed.middle_m[:2]) > FAR_M:
        found.append("walking more than 2 m")
    band = _band(person, placed)
    if band != "middle":
        found.append("bending or crouching" if band == "low" else "reaching up")
    taken = KINDS[placed.kind].taken
    if taken != "one hand":
        found.append("two hands" if taken == "two hands" else "taking a flat thing")
    return tuple(found) or ("an arm",)


def _band(person: Person, placed: Placed) -> str:
    z = placed.middle_m[2]
    if z < LOW_M:
        return "low"
    share = z / person.stature_m
    return "middle" if share <= HIGH else "high" if share <= OVERHEAD else "overhead"


def _at_ease_m(person: Person, placed: Placed) -> float:
    """How far from the middle of the feet a thing at that height is taken at ease."""
    return AT_EASE_M[_band(person, placed)] * person.stature_m / MEAN_M


def _local(piece: Piece, points: Array) -> Array:
    """Floor points (..., 2) in a piece's frame."""
    cos, sin = math.cos(piece.yaw_rad), math.sin(piece.yaw_rad)
    return np.asarray((points - np.array(piece.centre_m)) @ np.array([[cos, -sin], [sin, cos]]))


def _flooded(reached: Cells, free: Cells) -> Cells:
    """All free cells that hang together with those that are reached."""
    while True:
        grown = reached.copy()
        grown[1:] |= reached[:-1]
        grown[:-1] |= reached[1:]
        grown[:, 1:] |= reached[:, :-1]
        grown[:, :-1] |= reached[:, 1:]
        grown &= free
        if (grown == reached).all():
            return grown
        reached = grown
