"""People of random rooms: who sits or stands where at a table, and looks where."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.furniture import Table
from taskgist.demonstrator.generator.furnishing import RoundTable, on_top
from taskgist.demonstrator.room import Person
from taskgist.world import Posture

Array = NDArray[np.float64]

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
