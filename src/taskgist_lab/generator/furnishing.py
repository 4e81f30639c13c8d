"""Furniture of random rooms: round tables, shelves, cupboards, sofas; tops of tables; and who sits or stands there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.profile import Posture
from taskgist_lab.simulator.room import GREY, OAK, WHITE, Colour, Person, Table, add_box, add_cylinder, add_furniture

BOARD_M = 0.02
"""Thickness of the boards of shelves and cupboards."""
POST_M = 0.03
"""Thickness of a shelf's posts."""
COLUMN_M, FOOT_M = 0.05, (0.08, 0.02)
"""Radius of a round table's column; radius and thickness of its foot, beside which feet have room."""
CLOTH: Colour = (0.40, 0.45, 0.52, 1.0)
SOFA_SEAT_M, SOFA_DEPTH_M, ARM_M = 0.43, 0.60, 0.14
"""Height and depth of a sofa's seat, and the breadth of its arms and back."""


@dataclass(frozen=True)
class RoundTable(Table):
    """A round table on a column; its size is (diameter, diameter, height)."""

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        radius, height, (foot, thick) = self.size_m[0] / 2, self.size_m[2], FOOT_M
        under = height - self.board_m
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        add_cylinder(body, radius, self.board_m, (0, 0, height - self.board_m / 2), OAK)
        add_cylinder(body, COLUMN_M, under, (0, 0, under / 2), GREY)
        add_cylinder(body, foot, thick, (0, 0, thick / 2), GREY)


@dataclass(frozen=True)
class Shelf:
    """Boards one above the other, on posts (open on all sides) or between side walls with a back (a cupboard).

    Attributes:
        name: Its name.
        centre_m: Floor point beneath its middle, (2,).
        yaw_rad: Where its open front faces.
        size_m: Depth and width.
        boards_m: Heights of the upper faces of its boards, from below.
        closed: Whether it has side walls and a back.
    """

    name: str
    centre_m: tuple[float, float]
    yaw_rad: float
    size_m: tuple[float, float]
    boards_m: tuple[float, ...]
    closed: bool = False

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        depth, width = self.size_m
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        for height in self.boards_m:
            add_box(body, (depth, width, BOARD_M), (0, 0, height - BOARD_M / 2), OAK)
        self._add_uprights(body)

    def place(self, board: int, *, in_m: float = 0.0, aside_m: float = 0.0) -> tuple[float, float, float]:
        """A point of a board, metres, (3,).

        Args:
            board: Which board, from below.
            in_m: How far behind the board's middle.
            aside_m: How far to its left.
        """
        cos, sin = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        x, y = -in_m, aside_m
        return self.centre_m[0] + cos * x - sin * y, self.centre_m[1] + sin * x + cos * y, self.boards_m[board]

    def _add_uprights(self, body: mujoco.MjsBody) -> None:
        depth, width = self.size_m
        top = self.boards_m[-1]
        if not self.closed:
            for x in (-1, 1):
                for y in (-1, 1):
                    place = (x * (depth - POST_M) / 2, y * (width - POST_M) / 2, top / 2)
                    add_box(body, (POST_M, POST_M, top), place, GREY)
            return
        for y in (-1, 1):
            add_box(body, (depth, BOARD_M, top), (0, y * (width + BOARD_M) / 2, top / 2), WHITE)
        add_box(body, (BOARD_M, width + 2 * BOARD_M, top), (-(depth + BOARD_M) / 2, 0, top / 2), WHITE)


@dataclass(frozen=True)
class Sofa:
    """A sofa with arms and a back.

    Attributes:
        name: Its name.
        centre_m: Floor point beneath the middle of its seat, (2,).
        yaw_rad: Where those who sit on it look.
        width_m: Breadth of the seat.
    """

    name: str
    centre_m: tuple[float, float]
    yaw_rad: float
    width_m: float = 0.60

    def add_to(self, room: mujoco.MjSpec) -> None:
        """Put it into a room."""
        body = add_furniture(room, self.name, self.centre_m, self.yaw_rad)
        add_box(body, (SOFA_DEPTH_M, self.width_m, SOFA_SEAT_M), (0, 0, SOFA_SEAT_M / 2), CLOTH)
        tall, wide = SOFA_SEAT_M + 0.40, self.width_m + 2 * ARM_M
        add_box(body, (ARM_M, wide, tall), (-(SOFA_DEPTH_M + ARM_M) / 2, 0, tall / 2), CLOTH)
        arm_height = SOFA_SEAT_M + 0.12
        across = (self.width_m + ARM_M) / 2
        for y in (-1, 1):
            add_box(body, (SOFA_DEPTH_M, ARM_M, arm_height), (0, y * across, arm_height / 2), CLOTH)


def on_top(table: Table, place: Array, margin_m: float) -> bool:
    """Whether a place (2,) is on a table's top, at least so far from its edge."""
    x, y = place[:2] - table.centre_m
    if isinstance(table, RoundTable):
        return bool(math.hypot(x, y) <= table.size_m[0] / 2 - margin_m)
    cos, sin = math.cos(table.yaw_rad), math.sin(table.yaw_rad)
    along, across = cos * x + sin * y, cos * y - sin * x
    return bool(abs(along) <= table.size_m[0] / 2 - margin_m and abs(across) <= table.size_m[1] / 2 - margin_m)


def any_place(table: Table, rng: np.random.Generator, margin_m: float) -> Array:
    """A place (3,) anywhere on a table's top, evenly; for a round one maybe off it."""
    half = np.maximum(np.array(table.size_m[:2]) / 2 - margin_m, 0.0)
    x, y = rng.uniform(-half, half)
    cos, sin = math.cos(table.yaw_rad), math.sin(table.yaw_rad)
    middle = table.centre_m
    return np.array([middle[0] + cos * x - sin * y, middle[1] + sin * x + cos * y, table.height_m])


# --- People of random rooms: who sits or stands where at a table, and looks where.

STATURES_M = (1.50, 1.95)
BACK_M = {"sitting": (0.29, 0.36), "standing": (0.26, 0.36)}
"""How far a pelvis is from the edge of the table: sitting with the thighs under it, or standing at it."""
SITS_BACK_M = (0.52, 0.64)
"""The same for somebody who sits back, with the knees before the table."""
SITS_LOW_M = (0.60, 0.66)
"""The same before a low table, under which no thighs go."""
CORNER_SHARE = 0.2
"""How often somebody is at the end of a table rather than opposite."""
TURNED_RAD = math.radians(8.0)
"""How far people are turned from the table, to either side."""
FROM_CORNER_M = 0.35
"""How far people sit or stand from the corners of tables, at least, where there is room for that."""
LOW_M, HIGH_M = 0.60, 0.85
"""Tables lower than this are sofa tables, higher ones are stood at."""


@dataclass(frozen=True)
class Seat:
    """A place at a table: the point of its edge, metres, (2,), and where somebody there faces."""

    edge_m: tuple[float, float]
    facing_rad: float

    def behind(self, back_m: float) -> tuple[float, float]:
        """The floor point so far back from the edge, (2,)."""
        x, y = self.edge_m
        return x - back_m * math.cos(self.facing_rad), y - back_m * math.sin(self.facing_rad)


def seat_at(table: Table, bearing_rad: float, along_m: float = 0.0) -> Seat:
    """The place at a table in a direction from its middle, moved along the edge to the left of who is there.

    Args:
        table: The table.
        bearing_rad: Direction from the table's middle in which its edge is looked for.
        along_m: How far the place is moved along the edge.
    """
    facing = bearing_rad + math.pi
    inward = np.array([math.cos(facing), math.sin(facing)])
    middle = np.array(table.centre_m) + along_m * np.array([-inward[1], inward[0]])
    out = 0.0
    while on_top(table, middle - out * inward, 0.0):
        out += 0.005
    edge = middle - out * inward
    return Seat((float(edge[0]), float(edge[1])), facing)


def person_at(rng: np.random.Generator, name: str, seat: Seat, table: Table, posture: Posture, *, back: bool) -> Person:
    """Somebody at a table.

    Args:
        rng: Source of stature, distance and turn.
        name: Name of the agent.
        seat: The place.
        table: The table.
        posture: Sitting or standing.
        back: Whether somebody who sits does so with the knees before the table.
    """
    distances = SITS_BACK_M if back and posture == "sitting" else BACK_M[posture]
    if table.height_m < LOW_M and posture == "sitting":
        distances = SITS_LOW_M
    place = seat.behind(rng.uniform(*distances))
    yaw = seat.facing_rad + rng.uniform(-TURNED_RAD, TURNED_RAD)
    stature = rng.uniform(*STATURES_M)
    return Person(name, round(stature, 3), (round(place[0], 4), round(place[1], 4)), round(yaw, 4), posture)


def bearings(rng: np.random.Generator, table: Table) -> tuple[float, float]:
    """Directions from the middle of a table to where two people are who have to do with each other."""
    first = math.pi + table.yaw_rad
    if isinstance(table, RoundTable):
        return first, first + rng.choice((-1, 1)) * rng.uniform(math.radians(100), math.pi)
    if rng.random() < CORNER_SHARE:
        return first, first + rng.choice((-1, 1)) * math.pi / 2
    return first, first + math.pi


def any_seat(rng: np.random.Generator, table: Table) -> Seat:
    """Any place at a table, at one of its sides."""
    if isinstance(table, RoundTable):
        return seat_at(table, rng.uniform(-math.pi, math.pi))
    quarter = int(rng.integers(4))
    most = max(0.0, table.size_m[0 if quarter % 2 else 1] / 2 - FROM_CORNER_M)
    return seat_at(table, table.yaw_rad + quarter * math.pi / 2, rng.uniform(-most, most))


def bearing_of(person: Person, place: Array) -> float:
    """Direction of a place from somebody, radians to the left of where the person faces, from −π to π."""
    x, y = place[:2] - np.array(person.position_m)
    return math.remainder(math.atan2(y, x) - person.yaw_rad, math.tau)


def distance_m(person: Person, place: Array) -> float:
    """How far a place is from somebody's pelvis, over the floor."""
    return float(np.linalg.norm(place[:2] - np.array(person.position_m)))
