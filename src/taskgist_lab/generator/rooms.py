"""Random rooms: a table of some kind, two people at it who have to do with each other, and who and what is around."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from taskgist.world.bodies.profile import Posture
from taskgist_lab.generator.arrangement import Arrangement, add_bystanders, to_the_edge_m
from taskgist_lab.generator.furnishing import (
    FROM_CORNER_M,
    LOW_M,
    TURNED_RAD,
    RoundTable,
    Sofa,
    bearings,
    distance_m,
    person_at,
    seat_at,
)
from taskgist_lab.simulator.room import Person, Table

# --- Robots in rooms: as the one for whom something is done, or standing by.
#
# Only robots that come with taskgist are chosen, so that what is chosen does not depend on what else is installed.

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


DINING, ROUND, HIGH, LOW = "dining", "round", "high", "low"
TABLES = (DINING, ROUND, HIGH, LOW)
"""Kinds of tables: to dine at, round ones, those that people stand at, and sofa tables."""
SIZES_M = {
    DINING: ((0.65, 1.10, 0.70), (0.80, 1.70, 0.76)),
    ROUND: ((0.90, 0.90, 0.70), (1.10, 1.10, 0.76)),
    HIGH: ((0.60, 1.00, 0.92), (0.72, 1.50, 1.05)),
    LOW: ((0.45, 0.90, 0.42), (0.55, 1.20, 0.50)),
}
"""Least and largest size (x, y) of their tops, and height."""
EITHER: tuple[Posture, ...] = ("sitting", "standing")
BACK_SHARE, STANDING_SHARE = 0.35, 0.35
"""How often the target agent sits back, and how often somebody stands at a table to sit at."""
ASIDE_M = 0.25
"""How far people at a table are from straight opposite each other, each to either side."""


def around_a_table(
    rng: np.random.Generator,
    *,
    tables: Sequence[str] = TABLES,
    performer: Sequence[Posture] = EITHER,
    target: Sequence[Posture] = EITHER,
    robots: bool = True,
) -> Arrangement:
    """A room with a table and two people at it, and maybe others.

    Args:
        rng: Source of everything that is chosen.
        tables: Kinds of tables that will do.
        performer: Postures of the performing agent that will do.
        target: Those of the target agent.
        robots: Whether the target agent may be a robot.
    """
    table = _table(rng, str(rng.choice(tables)))
    names = rng.permutation(["P1", "P2", "P3", "P4"][: int(rng.integers(2, 5))]).tolist()
    acting, watching = _two_people(rng, table, names[:2], performer, target)
    arrangement = Arrangement(rng, table, acting, watching)
    add_bystanders(arrangement, names[2:])
    let_robots_in(arrangement, target=robots and "standing" in target)
    _add_seats(arrangement)
    return arrangement


def _table(rng: np.random.Generator, kind: str) -> Table:
    low, high = (np.array(size) for size in SIZES_M[kind])
    deep, wide, tall = rng.uniform(low, high).round(3).tolist()
    if kind == ROUND:
        return RoundTable("table", size_m=(deep, deep, tall))
    return Table("table", size_m=(deep, wide, tall))


def _posture(rng: np.random.Generator, table: Table, allowed: Sequence[Posture]) -> Posture:
    if table.height_m > 0.85 or "sitting" not in allowed:
        return "standing"
    if table.height_m < LOW_M or "standing" not in allowed:
        return "sitting"
    return "standing" if rng.random() < STANDING_SHARE else "sitting"


def _two_people(
    rng: np.random.Generator,
    table: Table,
    names: Sequence[str],
    performer: Sequence[Posture],
    target: Sequence[Posture],
) -> tuple[Person, Person]:
    """The performing and the target agent, opposite each other or at a corner of the table."""
    first, second = bearings(rng, table)
    aside = _asides(rng, table, at_the_end=abs(math.remainder(second - first, math.tau)) < 0.75 * math.pi)
    aside = -aside if math.remainder(second - first, math.tau) > 0.0 else aside
    acting = person_at(
        rng, names[0], seat_at(table, first, aside[0]), table, _posture(rng, table, performer), back=False
    )
    posture = _posture(rng, table, target)
    back = bool(rng.random() < BACK_SHARE)
    watching = person_at(rng, names[1], seat_at(table, second, aside[1]), table, posture, back=back)
    return acting, watching


def _asides(rng: np.random.Generator, table: Table, *, at_the_end: bool) -> np.ndarray:
    """How far the two are moved along their edges: a little; or the first one towards the second, at an end."""
    if isinstance(table, RoundTable):
        return np.zeros(2)
    most = max(0.0, min(ASIDE_M, table.size_m[1] / 2 - FROM_CORNER_M))
    if at_the_end:
        return np.array([rng.uniform(0.0, most), 0.0])
    return np.asarray(rng.uniform(-most, most, 2))


def _add_seats(arrangement: Arrangement) -> None:
    """Sofas under those who sit at a low table."""
    if arrangement.table.height_m >= LOW_M:
        return
    for person in (each for each in (arrangement.performer, arrangement.target) if each.posture == "sitting"):
        arrangement.furniture.append(Sofa(f"sofa_{person.name}", person.position_m, person.yaw_rad))
    arrangement.performer = replace(arrangement.performer, chair=False)
    arrangement.target = replace(arrangement.target, chair=False)
