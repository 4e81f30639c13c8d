"""Furniture as values: tables, chairs, sofas, cabinets with and without doors, drawers, beds; and the spots for things.

Every piece stands on the floor, its frame beneath its middle, and faces along its x axis. A spot is a patch on which
things lie, and says from where it is got at and whether it is shut, for whoever decides who gets at what::

    shelf = cabinet("bookshelf", (3.0, 0.2), math.pi / 2, boards_m=(0.4, 0.8, 1.2), high_m=1.6)
    [spot.at_m[2] for spot in shelf.spots]  # 0.02, 0.4, 0.8, 1.2: the bottom and three boards

"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco

from taskgist_lab.simulator.room import (
    CHAIR_M,
    FURNITURE_BACK_M,
    GREY,
    OAK,
    SEAT_M,
    WHITE,
    Colour,
    Vector,
    add_box,
    add_furniture,
)

Point = tuple[float, float]
"""A point of the floor, metres."""
CLOTH: Colour = (0.40, 0.45, 0.52, 1.0)
LINEN: Colour = (0.85, 0.86, 0.90, 1.0)
BOARD_M = 0.02
"""Thickness of the boards of cabinets."""
EDGE_M = 0.02
"""Things lie so far from the edges of what they lie on, at least."""
UNDER_M = 0.20
"""How far within a table's edge things lie that lie beneath it."""
OPEN_SKY_M = math.inf


@dataclass(frozen=True)
class Box:
    """A box of a piece of furniture: its full size and its middle, in the piece's frame, and its colour."""

    size_m: Vector
    centre_m: Vector
    rgba: Colour = OAK

    @property
    def top_m(self) -> float:
        """Height of its upper face."""
        return self.centre_m[2] + self.size_m[2] / 2

    @property
    def under_m(self) -> float:
        """Height of its lower face."""
        return self.centre_m[2] - self.size_m[2] / 2


@dataclass(frozen=True)
class Spot:
    """A level patch on which things lie.

    Attributes:
        name: What people call it.
        at_m: Its middle, in the piece's frame, (3,).
        half_m: Half of its size, (2,).
        clear_m: Free height above it.
        shut: Nobody gets in without opening something.
        front_only: Things are got at from the piece's front only.
    """

    name: str
    at_m: Vector
    half_m: Point
    clear_m: float = OPEN_SKY_M
    shut: bool = False
    front_only: bool = False


@dataclass(frozen=True)
class Piece:
    """A piece of furniture.

    Attributes:
        name: Its name.
        kind: What people call it.
        centre_m: Floor point beneath its middle, (2,).
        yaw_rad: Where its front faces.
        boxes: What it is made of.
        spots: Where things lie.
    """

    name: str
    kind: str
    centre_m: Point
    yaw_rad: float
    boxes: tuple[Box, ...]
    spots: tuple[Spot, ...] = ()

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        for box in self.boxes:
            add_box(body, box.size_m, box.centre_m, box.rgba)

    def point(self, x: float, y: float) -> Point:
        """The floor point at a place in its frame."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        return self.centre_m[0] + cos * x - sin * y, self.centre_m[1] + sin * x + cos * y

    def local(self, x: float, y: float) -> Point:
        """A floor point in its frame."""
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y = x - self.centre_m[0], y - self.centre_m[1]
        return cos * x + sin * y, cos * y - sin * x


def table(
    name: str, centre_m: Point, yaw_rad: float = 0.0, *, size_m: Vector = (0.8, 1.2, 0.74), kind: str = "table"
) -> Piece:
    """A table on four legs: full size of its top, and the height of its upper face."""
    depth, width, height = size_m
    under = height - 0.03
    top = Box((depth, width, 0.03), (0, 0, height - 0.015))
    half = (depth / 2, width / 2)
    spots = [Spot(f"{kind} top", (0, 0, height), (half[0] - EDGE_M, half[1] - EDGE_M))]
    if under > 0.5:
        spots.append(Spot(f"beneath {kind}", (half[0] - UNDER_M, 0, 0), (0.05, half[1] - 0.15), clear_m=under))
    return Piece(name, kind, centre_m, yaw_rad, (top, *_legs(depth, width, under)), tuple(spots))


def chair(name: str, centre_m: Point, yaw_rad: float = 0.0, *, back: bool = True) -> Piece:
    """A chair on four legs, or a stool."""
    depth, width, board = CHAIR_M
    seat = Box((depth, width, board), (0, 0, SEAT_M - board / 2), GREY)
    behind = Box((board, width, FURNITURE_BACK_M), (-(depth + board) / 2, 0, SEAT_M + FURNITURE_BACK_M / 2), GREY)
    boxes = (seat, *((behind,) if back else ()), *_legs(depth, width, SEAT_M - board))
    spot = Spot("chair", (0, 0, SEAT_M), (depth / 2 - EDGE_M, width / 2 - EDGE_M))
    return Piece(name, "chair", centre_m, yaw_rad, boxes, (spot,))


def sofa(name: str, centre_m: Point, yaw_rad: float = 0.0, *, width_m: float = 1.6) -> Piece:
    """A sofa with arms and a back, solid down to the floor; its frame is beneath the middle of its seat."""
    depth, seat, arm = 0.60, 0.43, 0.14
    boxes = (
        Box((depth, width_m, seat), (0, 0, seat / 2), CLOTH),
        Box((arm, width_m + 2 * arm, seat + 0.40), (-(depth + arm) / 2, 0, (seat + 0.40) / 2), CLOTH),
        *(Box((depth, arm, seat + 0.15), (0, y * (width_m + arm) / 2, (seat + 0.15) / 2), CLOTH) for y in (-1, 1)),
    )
    spot = Spot("sofa seat", (0.05, 0, seat), (depth / 2 - 0.1, width_m / 2 - 0.05), front_only=True)
    return Piece(name, "sofa", centre_m, yaw_rad, boxes, (spot,))


def bench(name: str, centre_m: Point, yaw_rad: float = 0.0, *, width_m: float = 1.2) -> Piece:
    """A bench without a back, on legs."""
    depth = 0.38
    top = Box((depth, width_m, 0.04), (0, 0, SEAT_M - 0.02))
    spot = Spot("bench", (0, 0, SEAT_M), (depth / 2 - EDGE_M, width_m / 2 - EDGE_M))
    return Piece(name, "bench", centre_m, yaw_rad, (top, *_legs(depth, width_m, SEAT_M - 0.04)), (spot,))


def bed(name: str, centre_m: Point, yaw_rad: float = 0.0) -> Piece:
    """A single bed, one long side at the front."""
    depth, width, height = 0.95, 2.0, 0.50
    box = Box((depth, width, height), (0, 0, height / 2), LINEN)
    spot = Spot("bed", (0, 0, height), (depth / 2 - 0.05, width / 2 - 0.05), front_only=True)
    return Piece(name, "bed", centre_m, yaw_rad, (box,), (spot,))


def cabinet(
    name: str,
    centre_m: Point,
    yaw_rad: float = 0.0,
    *,
    kind: str = "bookshelf",
    size_m: Point = (0.30, 0.90),
    low_m: float = 0.0,
    high_m: float = 1.8,
    boards_m: Iterable[float] = (),
    shut: bool = False,
    top_m: float | None = None,
) -> Piece:
    """Boards between side walls with a back, with a door before them or open: shelf, cupboard, kitchen counter.

    Args:
        name: Its name.
        centre_m: Floor point beneath its middle, (2,).
        yaw_rad: Where its front faces.
        kind: What people call it.
        size_m: Depth and width.
        low_m: Height of its lower end: on the floor, or on the wall.
        high_m: Height of its upper end.
        boards_m: Heights of the upper faces of the boards within.
        shut: Whether a door closes its front.
        top_m: Thickness of a worktop upon it; without one, nothing lies on top.
    """
    depth, width = size_m
    tall, middle = high_m - low_m, (high_m + low_m) / 2
    inner = (depth - BOARD_M, width - 2 * BOARD_M)
    levels = [low_m + BOARD_M, *boards_m]
    boxes = [Box((depth, BOARD_M, tall), (0, y * (width - BOARD_M) / 2, middle), WHITE) for y in (-1, 1)]
    boxes.append(Box((BOARD_M, width, tall), (-(depth - BOARD_M) / 2, 0, middle), WHITE))
    boxes += [Box((*inner, BOARD_M), (BOARD_M / 2, 0, z - BOARD_M / 2), OAK) for z in (*levels, high_m)]
    if shut:
        boxes.append(Box((BOARD_M, width, tall), ((depth + BOARD_M) / 2, 0, middle), WHITE))
    ceilings = [*(z - BOARD_M for z in boards_m), high_m - BOARD_M]
    name_of = f"in closed {kind}" if shut else kind
    spots = [
        Spot(name_of, (0.02, 0, z), (depth / 2 - 0.06, inner[1] / 2 - 0.05), above - z, shut=shut, front_only=True)
        for z, above in zip(levels, ceilings, strict=True)
    ]
    if top_m is not None:
        boxes.append(Box((depth + 0.02, width, top_m), (0.01, 0, high_m + top_m / 2), GREY))
        half = (depth / 2 - EDGE_M, width / 2 - EDGE_M)
        spots.append(Spot(f"{kind} top", (0, 0, high_m + top_m), half, front_only=True))
    return Piece(name, kind, centre_m, yaw_rad, tuple(boxes), tuple(spots))


def drawer(
    name: str, centre_m: Point, yaw_rad: float = 0.0, *, kind: str = "drawer", height_m: float = 0.5, out_m: float = 0.0
) -> Piece:
    """A small cabinet with one drawer: pulled out so far, or closed.

    Args:
        name: Its name.
        centre_m: Floor point beneath its middle, (2,).
        yaw_rad: Where its front faces.
        kind: What people call it.
        height_m: Height of its upper face.
        out_m: How far the drawer is pulled out.
    """
    depth, width, deep = 0.42, 0.42, 0.14
    bottom = height_m - BOARD_M - deep - 0.01
    boxes = [
        Box((depth, width, BOARD_M), (0, 0, height_m - BOARD_M / 2), OAK),
        Box((depth, width, bottom - 0.01), (0, 0, (bottom - 0.01) / 2), OAK),
        Box((BOARD_M, width, height_m), (-(depth - BOARD_M) / 2, 0, height_m / 2), OAK),
        *(Box((depth, BOARD_M, height_m), (0, y * (width - BOARD_M) / 2, height_m / 2), OAK) for y in (-1, 1)),
    ]
    long, wide, board = depth - BOARD_M, width - 2 * BOARD_M - 0.01, 0.01
    x = out_m + BOARD_M / 2
    boxes += [
        Box((long, wide, board), (x, 0, bottom + board / 2), WHITE),
        Box(
            (BOARD_M, width, height_m - bottom + 0.01),
            (x + (long + BOARD_M) / 2, 0, (height_m + bottom - 0.01) / 2),
            WHITE,
        ),
        Box((board, wide, deep), (x - long / 2, 0, bottom + deep / 2), WHITE),
        *(Box((long, board, deep), (x, y * wide / 2, bottom + deep / 2), WHITE) for y in (-1, 1)),
    ]
    shut = out_m < 0.05
    inside = (x, 0.0) if shut else (depth / 2 + out_m / 2, 0.0)
    half = ((long / 2 if shut else out_m / 2) - 0.04, wide / 2 - 0.04)
    told = f"in closed {kind}" if shut else f"in open {kind}"
    spots = (
        Spot(told, (*inside, bottom + board), half, deep - board if shut else OPEN_SKY_M, shut=shut, front_only=True),
        Spot(f"{kind} top", (0, 0, height_m), (depth / 2 - EDGE_M, width / 2 - EDGE_M)),
    )
    return Piece(name, kind, centre_m, yaw_rad, tuple(boxes), spots)


def wall(name: str, start_m: Point, end_m: Point, *, height_m: float = 2.5, thick_m: float = 0.10) -> Piece:
    """A wall between two points of the floor."""
    dx, dy = end_m[0] - start_m[0], end_m[1] - start_m[1]
    middle = ((start_m[0] + end_m[0]) / 2, (start_m[1] + end_m[1]) / 2)
    box = Box((math.hypot(dx, dy), thick_m, height_m), (0, 0, height_m / 2), WHITE)
    return Piece(name, "wall", middle, math.atan2(dy, dx), (box,))


def _legs(depth_m: float, width_m: float, height_m: float) -> Iterable[Box]:
    thick = 0.04
    for x in (-1, 1):
        for y in (-1, 1):
            place = (x * (depth_m - thick) / 2, y * (width_m - thick) / 2, height_m / 2)
            yield Box((thick, thick, height_m), place, GREY)
