"""Rooms to perform in, at random: furniture, somebody for whom, a robot in free floor, and things, some of which hide.

A table with somebody at it, who sits or stands; one or two more pieces around it (a second table, a shelf, a closed
sideboard); a robot that stands where there is floor for it; and three to eight things on all of these, among them what
hides (boxes, screens, crates), a bin, and the small thing that the task is about::

    room = room_to_perform_in(seed=1000, number=3)
    scene = room.scene("pr2")

A room follows from seed, number and attempt alone, and is the same for every robot: none is asked what it can do.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.profile import Posture
from taskgist.world.scene import Scene
from taskgist_lab.generator.furnishing import RoundTable, Shelf, any_place, bearings, on_top, person_at, seat_at
from taskgist_lab.generator.rooms import DINING, HIGH, ROUND, SIZES_M
from taskgist_lab.generator.things import LARGE, OCCLUDERS, SMALL, any_of, at, bin_of, radius_m
from taskgist_lab.simulator.room import Furniture, Person, Room, Sideboard, Table, Thing

ROBOT, TARGET, THING = "R", "P2", "it"
"""Names of the performer, of the target agent, and of the thing."""
HEIGHT_M = 1.5
"""What a robot's profile says of its height is not asked for; people's values need some."""
ROOM_FOR_ROBOT_M = 0.55
"""Radius of the free floor on which a robot stands at the start: what the bases of both robots need, and their arms."""
FROM_TABLE_M = (1.0, 1.9)
"""How far another piece's middle is from that of the table, beyond half of the table's longer side."""
ROBOT_FROM_M = (0.9, 2.4)
"""How far the robot is from the table's middle, beyond half of its shorter side."""
MARGIN_M, APART_M = 0.02, 0.03
"""How far things are from edges, and from each other, at least."""
NEAR_M = 0.8
"""A thing no farther from somebody's middle is before that one."""
FEWEST, MOST = 3, 8
"""Things in a room, that which is acted with among them."""
SHELF_M, BOARDS_M = (0.30, 0.80), (0.38, 0.78, 1.18)
"""Depth and width of shelves, and heights of their boards: what fits between them is lower than 35 cm."""
CLEAR_M = 0.06
"""Free height above what stands between boards, at least."""
SIDEBOARD_M = (0.40, 1.60, 0.80)
LATER_ROBOT_TRIES, TRIES = 400, 60


class Surface(NamedTuple):
    """Something level on which things are put: a table's top, or a board's, as a table without legs."""

    top: Table
    clear_m: float


@dataclass(frozen=True)
class RoomToPerformIn:
    """A room in which a task is performed.

    Attributes:
        name: Its name.
        table: The table at which the target agent is.
        pieces: The other furniture.
        target: The target agent.
        robot_at: Where the robot stands: x and y in metres, yaw in radians.
        things: All things; that which is acted with is called ``THING``.
    """

    name: str
    table: Table
    pieces: tuple[Furniture, ...]
    target: Person
    robot_at: tuple[float, float, float]
    things: tuple[Thing, ...]

    def scene(self, profile: str) -> Scene:
        """The room with a robot in it, called ``ROBOT``, as a scene.

        Args:
            profile: The robot's.
        """
        x, y, yaw = self.robot_at
        robot = Person(ROBOT, HEIGHT_M, (x, y), yaw, "standing", profile=profile)
        return Room(self.name, (robot, self.target), self.things, self.table, self.pieces).scene()


def room_to_perform_in(seed: int, number: int, attempt: int = 0, *, near: bool = False) -> RoomToPerformIn:
    """A room.

    Args:
        seed: Seed of all rooms.
        number: Which of them.
        attempt: The same room with its things elsewhere: a task makes no sense with every arrangement.
        near: Whether the thing is on the table before the target agent, as where it is to be taken away; else anywhere.
    """
    rng = np.random.default_rng((seed, number))
    while True:
        table = _table(rng)
        toward, _ = bearings(rng, table)
        seat = seat_at(table, toward)
        stands = table.height_m > SIZES_M[DINING][1][2] or rng.random() < STANDING_SHARE
        posture: Posture = "standing" if stands else "sitting"
        target = person_at(rng, TARGET, seat, table, posture, back=bool(rng.random() < BACK_SHARE))
        pieces = _pieces(rng, table, target)
        robot_at = _free_floor(rng, table, pieces, target)
        if pieces and robot_at is not None:
            break
    beside = np.array(target.position_m) if near else None
    things = _things(np.random.default_rng((seed, number, attempt)), table, pieces, beside)
    name = f"perform-{seed}-{number:04d}-{attempt}{'-near' if near else ''}"
    return RoomToPerformIn(name, table, pieces, target, robot_at, things)


STANDING_SHARE, BACK_SHARE = 0.35, 0.35
"""How often somebody stands at a table to sit at, and sits back from it."""


# --- Furniture, and where it and the robot stand.


def _table(rng: np.random.Generator) -> Table:
    kind = str(rng.choice((DINING, ROUND, HIGH), p=(0.6, 0.2, 0.2)))
    deep, wide, tall = rng.uniform(*(np.array(size) for size in SIZES_M[kind])).round(3).tolist()
    if kind == ROUND:
        return RoundTable("table", size_m=(deep, deep, tall))
    return Table("table", size_m=(deep, wide, tall))


def _pieces(rng: np.random.Generator, table: Table, target: Person) -> tuple[Furniture, ...]:
    """One or two other pieces that face the table, not where the target agent is, and not in each other."""
    kinds = rng.permutation(["second table", "shelf", "sideboard"])[: int(rng.integers(1, 3))]
    found: list[Furniture] = []
    for kind in kinds.tolist():
        for _ in range(TRIES):
            bearing = float(rng.uniform(-math.pi, math.pi))
            away = max(table.size_m[:2]) / 2 + float(rng.uniform(*FROM_TABLE_M))
            centre = (round(away * math.cos(bearing), 3), round(away * math.sin(bearing), 3))
            piece = _piece(rng, kind, centre, round(bearing + math.pi, 4))
            floor = footprint(piece)
            others = [footprint(table), *map(footprint, found)]
            if _gap_m(floor, np.array(target.position_m)) > 0.75 and all(_apart(floor, each) for each in others):
                found.append(piece)
                break
    return tuple(found)


def _piece(rng: np.random.Generator, kind: str, centre: tuple[float, float], yaw_rad: float) -> Furniture:
    if kind == "shelf":
        return Shelf("shelf", centre, yaw_rad, SHELF_M, BOARDS_M, closed=bool(rng.random() < 0.5))
    if kind == "sideboard":
        return Sideboard("sideboard", centre, yaw_rad)
    deep, wide, tall = rng.uniform((0.5, 0.7, 0.55), (0.7, 1.2, 0.80)).round(3).tolist()
    return Table("second table", centre, (deep, wide, tall), yaw_rad)


def footprint(piece: Furniture) -> Table:
    """The rectangle of floor that a piece takes up, as a table of no height."""
    if isinstance(piece, Shelf):
        return Table(piece.name, piece.centre_m, (*piece.size_m, 0.0), piece.yaw_rad)
    if isinstance(piece, Sideboard):
        return Table(piece.name, piece.centre_m, (*SIDEBOARD_M[:2], 0.0), piece.yaw_rad)
    assert isinstance(piece, Table)
    return piece


def _gap_m(floor: Table, place: Array) -> float:
    """How far a place is from a rectangle of floor; 0 within."""
    x, y = place - floor.centre_m
    cos, sin = math.cos(floor.yaw_rad), math.sin(floor.yaw_rad)
    out = (abs(cos * x + sin * y) - floor.size_m[0] / 2, abs(cos * y - sin * x) - floor.size_m[1] / 2)
    return math.hypot(*(max(each, 0.0) for each in out))


def _apart(floor: Table, other: Table) -> bool:
    """Whether there is a step of floor between two rectangles, by their middle and corners."""
    return min(_gap_m(other, each) for each in _corners(floor)) > 0.15 and all(
        _gap_m(floor, each) > 0.15 for each in _corners(other)
    )


def _corners(floor: Table) -> Array:
    cos, sin = math.cos(floor.yaw_rad), math.sin(floor.yaw_rad)
    shares = np.array([(x, y) for x in (-0.5, 0, 0.5) for y in (-0.5, 0, 0.5)]) * floor.size_m[:2]
    return np.asarray(floor.centre_m + shares @ np.array([(cos, sin), (-sin, cos)]))


def _free_floor(
    rng: np.random.Generator, table: Table, pieces: Sequence[Furniture], target: Person
) -> tuple[float, float, float] | None:
    """Where the robot stands, and faces roughly the table; None if there is no room."""
    floors = [footprint(table), *map(footprint, pieces)]
    for _ in range(LATER_ROBOT_TRIES):
        bearing = float(rng.uniform(-math.pi, math.pi))
        away = min(table.size_m[:2]) / 2 + float(rng.uniform(*ROBOT_FROM_M))
        place = away * np.array([math.cos(bearing), math.sin(bearing)])
        from_target = float(np.linalg.norm(place - target.position_m))
        if from_target > 1.1 and all(_gap_m(floor, place) > ROOM_FOR_ROBOT_M for floor in floors):
            yaw = bearing + math.pi + float(rng.uniform(-0.6, 0.6))
            x, y = place.round(3).tolist()
            return x, y, round(math.remainder(yaw, math.tau), 4)
    return None


# --- Things, and where they are.


def surfaces(table: Table, pieces: Sequence[Furniture]) -> tuple[Surface, ...]:
    """What things can be put on, each with the free height above it."""
    found = [Surface(table, math.inf)]
    for piece in pieces:
        if isinstance(piece, Shelf):
            heights = (*piece.boards_m[1:], math.inf)
            for height, above in zip(piece.boards_m, heights, strict=True):
                board = Table(piece.name, piece.centre_m, (*piece.size_m, height), piece.yaw_rad)
                found.append(Surface(board, above - 0.02 - height))
        elif isinstance(piece, Sideboard):
            found.append(Surface(Table(piece.name, piece.centre_m, SIDEBOARD_M, piece.yaw_rad), math.inf))
        elif isinstance(piece, Table):
            found.append(Surface(piece, math.inf))
    return tuple(found)


def _things(
    rng: np.random.Generator, table: Table, pieces: Sequence[Furniture], beside: Array | None
) -> tuple[Thing, ...]:
    """The thing, something that hides, a bin, and others; what finds no room is left out.

    Args:
        rng: Source of all.
        table: The table.
        pieces: The other furniture.
        beside: The thing is on the table, not far from there, (2,); None: anywhere.
    """
    count = int(rng.integers(FEWEST, MOST + 1))
    kinds = [any_of(rng, OCCLUDERS), replace(any_of(rng, SMALL), name=THING), bin_of(rng)]
    while len(kinds) < count:
        group = (OCCLUDERS, LARGE, SMALL)[int(rng.choice(3, p=(0.2, 0.3, 0.5)))]
        kinds.append(any_of(rng, group))
    placed: list[Thing] = []
    for number, thing in enumerate(kinds):
        named = thing if thing.name in (THING, "bin") else replace(thing, name=f"{thing.name} {number}")
        at_hand = beside is not None and named.name == THING
        put = _put(rng, named, surfaces(table, pieces)[: 1 if at_hand else None], placed, beside if at_hand else None)
        if put is None and named.name == THING:
            return _things(rng, table, pieces, beside)
        placed += [] if put is None else [put]
    return tuple(placed)


def _put(
    rng: np.random.Generator,
    thing: Thing,
    places: Sequence[Surface],
    placed: Sequence[Thing],
    beside: Array | None = None,
) -> Thing | None:
    """A thing somewhere; half of them on the table; None if no room was found."""
    for _ in range(TRIES):
        surface = places[0] if rng.random() < 0.5 else places[int(rng.integers(len(places)))]
        if thing.height_m + CLEAR_M > surface.clear_m:
            continue
        radius = radius_m(thing)
        place, yaw = any_place(surface.top, rng, MARGIN_M), float(rng.uniform(-math.pi, math.pi))
        if beside is not None and np.linalg.norm(place[:2] - beside) > NEAR_M:
            continue
        if surface.clear_m < math.inf or min(surface.top.size_m[:2]) < 2 * radius:
            yaw = surface.top.yaw_rad
        if all(on_top(surface.top, corner, MARGIN_M) for corner in _outline(thing, place, yaw)) and all(
            abs(other.position_m[2] - place[2]) > 0.3 + other.height_m
            or math.dist(other.position_m[:2], place[:2]) > radius + radius_m(other) + APART_M
            for other in placed
        ):
            return at(thing, place, yaw)
    return None


def _outline(thing: Thing, place: Array, yaw_rad: float) -> list[Array]:
    """Points of the floor beneath a thing's edge."""
    if len(thing.size_m) == 2:
        angles = np.arange(8) * math.pi / 4
        return [place[:2] + thing.size_m[0] / 2 * np.array([math.cos(a), math.sin(a)]) for a in angles]
    return list(
        _corners(Table("", (float(place[0]), float(place[1])), (thing.size_m[0], thing.size_m[1], 0.0), yaw_rad))
    )
