"""Random rooms: a table of some kind, two people at it who have to do with each other, and who and what is around."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from taskgist.demonstrator.furniture import Table
from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.bystanders import add_bystanders
from taskgist.demonstrator.generator.furnishing import RoundTable, Sofa
from taskgist.demonstrator.generator.people import FROM_CORNER_M, LOW_M, bearings, person_at, seat_at
from taskgist.demonstrator.generator.robots import let_robots_in
from taskgist.demonstrator.room import Person
from taskgist.world import Posture

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
        rng: Source of everything that is drawn.
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
