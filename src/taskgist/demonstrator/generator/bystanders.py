"""Bystanders: who else is in a room, at the table, standing about or on a sofa, and looks on."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.furnishing import EmptyChair, Sofa
from taskgist.demonstrator.generator.people import (
    HIGH_M,
    LOW_M,
    STATURES_M,
    any_seat,
    bearing_of,
    distance_m,
    person_at,
)
from taskgist.demonstrator.room import Person

Array = NDArray[np.float64]

TRIES = 20
FROM_PERFORMER_M, FROM_OTHERS_M = 1.05, 0.80
"""How far bystanders are from the performer, whose arms need room, and from everybody else."""
ABOUT_M, SOFA_M = (1.3, 2.2), (1.7, 2.4)
"""How far from the middle of the table somebody stands, or sits on a sofa."""
FACING_RAD = math.radians(35.0)
"""How far from the middle of the table somebody is turned who is not at it."""
HEAD_DEG = ((-55.0, 55.0), (-30.0, 15.0))
"""How far heads are turned aside and up."""
EYE_SHARE = {"sitting": 0.69, "standing": 0.936}
"""How high eyes are, as shares of the stature [Winter 2009]; sitting, over a seat of usual height."""
EMPTY_SHARE = 0.3
"""How often a chair stands about that nobody sits on."""


def add_bystanders(arrangement: Arrangement, names: Sequence[str]) -> None:
    """Put bystanders into a room as far as there is room for them, and maybe an empty chair."""
    for name in names:
        place = PLACES[str(arrangement.rng.choice(list(PLACES)))]
        for _ in range(TRIES):
            person = place(arrangement, name)
            if _has_room(arrangement, person):
                _add(arrangement, person)
                break
    _add_empty_chair(arrangement)


def _at_the_table(arrangement: Arrangement, name: str) -> Person:
    rng, table = arrangement.rng, arrangement.table
    sits = LOW_M <= table.height_m <= HIGH_M and rng.random() < 0.5
    return person_at(rng, name, any_seat(rng, table), table, "sitting" if sits else "standing", back=False)


def _standing_about(arrangement: Arrangement, name: str) -> Person:
    return _somewhere(arrangement, name, ABOUT_M)


def _on_a_sofa(arrangement: Arrangement, name: str) -> Person:
    return replace(_somewhere(arrangement, name, SOFA_M), posture="sitting", chair=False)


def _somewhere(arrangement: Arrangement, name: str, away_m: tuple[float, float]) -> Person:
    """Somebody who stands in the room and faces the table, more or less."""
    rng = arrangement.rng
    bearing, away = rng.uniform(-math.pi, math.pi), rng.uniform(*away_m)
    x, y = arrangement.table.centre_m
    place = (round(x + away * math.cos(bearing), 4), round(y + away * math.sin(bearing), 4))
    yaw = math.remainder(bearing + math.pi + rng.uniform(-FACING_RAD, FACING_RAD), math.tau)
    return Person(name, round(rng.uniform(*STATURES_M), 3), place, round(yaw, 4), "standing")


PLACES: dict[str, Callable[[Arrangement, str], Person]] = {
    "table": _at_the_table,
    "about": _standing_about,
    "sofa": _on_a_sofa,
}
"""Where bystanders are."""


def _has_room(arrangement: Arrangement, person: Person) -> bool:
    place = np.array(person.position_m)
    others = (arrangement.target, *arrangement.others)
    return distance_m(arrangement.performer, place) > FROM_PERFORMER_M and all(
        distance_m(other, place) > FROM_OTHERS_M for other in others
    )


def _add(arrangement: Arrangement, person: Person) -> None:
    """Add somebody, who looks at the performer, at the target agent or at the table, and its seat."""
    watched = arrangement.rng.integers(3)
    acting, watching = arrangement.performer, arrangement.target
    subjects = (_face(acting), _face(watching), np.array([*arrangement.table.centre_m, arrangement.table.height_m]))
    arrangement.others.append(_looking_at(person, subjects[watched]))
    if person.posture == "sitting" and not person.chair:
        arrangement.furniture.append(Sofa(f"sofa_{person.name}", person.position_m, person.yaw_rad))


def _face(person: Person) -> Array:
    return np.array([*person.position_m, EYE_SHARE[person.posture] * person.stature_m])


def _looking_at(person: Person, place: Array) -> Person:
    """Somebody with the head turned to a place (3,), as far as heads turn."""
    eye = _face(person)
    pan = math.degrees(bearing_of(person, place))
    tilt = math.degrees(math.atan2(place[2] - eye[2], float(np.linalg.norm((place - eye)[:2]))))
    head = tuple(round(float(np.clip(angle, *limits)), 1) for angle, limits in zip((pan, tilt), HEAD_DEG, strict=True))
    return replace(person, head_deg=(head[0], head[1]))


def _add_empty_chair(arrangement: Arrangement) -> None:
    """Maybe let a chair stand about."""
    if arrangement.rng.random() > EMPTY_SHARE:
        return
    chair = _somewhere(arrangement, "", ABOUT_M)
    if _has_room(arrangement, chair):
        arrangement.furniture.append(EmptyChair("empty_chair", chair.position_m, chair.yaw_rad))
