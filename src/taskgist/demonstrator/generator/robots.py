"""Robots in rooms: as the one for whom something is done, or standing by.

Only robots that come with taskgist are drawn, so that what is drawn does not depend on what else is installed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.people import TURNED_RAD, distance_m, seat_at
from taskgist.demonstrator.generator.spots import to_the_edge_m
from taskgist.demonstrator.room import Person

TARGET_SHARE, BYSTANDER_SHARE = 0.12, 0.12
"""How often the target agent is a robot, and how often one stands by."""
GAP_M, FROM_TABLE_M = (0.03, 0.12), (0.10, 0.50)
"""Gap between what a robot takes up and the table: at the table, and standing by."""
FROM_PEOPLE_M = 0.85
"""How far robots that stand by are from people, at least."""
TRIES = 20


@dataclass(frozen=True)
class Robot:
    """What a room must know of a robot.

    Attributes:
        height_m: How tall it is.
        ahead_m: How far it extends before its middle, at rest.
    """

    height_m: float
    ahead_m: float


ROBOTS: Mapping[str, Robot] = {"jido": Robot(1.59, 0.42), "hrp2": Robot(1.54, 0.30)}
"""The robots that come with taskgist, by the names of their profiles."""


def let_robots_in(arrangement: Arrangement, *, target: bool) -> None:
    """Make the target agent a robot, let one stand by, or, mostly, neither.

    Args:
        arrangement: A room with its people, before it is furnished further.
        target: Whether the target agent may be a robot, which stands.
    """
    rng = arrangement.rng
    becomes, stands_by = rng.random() < TARGET_SHARE, rng.random() < BYSTANDER_SHARE
    profile = str(rng.choice(list(ROBOTS)))
    if becomes and target:
        arrangement.target = _instead_of(arrangement, arrangement.target, profile)
    elif stands_by:
        _stand_by(arrangement, profile)


def _instead_of(arrangement: Arrangement, person: Person, profile: str) -> Person:
    """A robot at the table where somebody was, farther back as far as it takes up more room."""
    gap = ROBOTS[profile].ahead_m + arrangement.rng.uniform(*GAP_M)
    back = gap - to_the_edge_m(person, arrangement.table)
    x, y = person.position_m
    place = (round(x - back * math.cos(person.yaw_rad), 4), round(y - back * math.sin(person.yaw_rad), 4))
    return robot(person.name, profile, place, person.yaw_rad)


def _stand_by(arrangement: Arrangement, profile: str) -> None:
    """Put a robot beside the table, away from people, if there is room for it."""
    rng, table = arrangement.rng, arrangement.table
    name = next(f"P{n}" for n in range(1, 9) if f"P{n}" not in {person.name for person in _people(arrangement)})
    for _ in range(TRIES):
        seat = seat_at(table, rng.uniform(-math.pi, math.pi))
        x, y = seat.behind(ROBOTS[profile].ahead_m + rng.uniform(*FROM_TABLE_M))
        yaw = seat.facing_rad + rng.uniform(-TURNED_RAD, TURNED_RAD)
        place = (round(x, 4), round(y, 4))
        if all(distance_m(person, np.array(place)) >= FROM_PEOPLE_M for person in _people(arrangement)):
            arrangement.others.append(robot(name, profile, place, round(yaw, 4)))
            return


def _people(arrangement: Arrangement) -> tuple[Person, ...]:
    return arrangement.performer, arrangement.target, *arrangement.others


def robot(name: str, profile: str, position_m: tuple[float, float], yaw_rad: float) -> Person:
    """A robot somewhere; every one of them stands."""
    return Person(name, ROBOTS[profile].height_m, position_m, yaw_rad, "standing", profile=profile)
