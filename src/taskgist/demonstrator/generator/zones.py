"""Zones: where things are handy for somebody, or far from somebody, as conditions on places."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.furniture import Thing
from taskgist.demonstrator.generator.arrangement import Where
from taskgist.demonstrator.generator.people import bearing_of, distance_m
from taskgist.demonstrator.room import Person

Array = NDArray[np.float64]

HANDY_SHARE = 0.48
"""How far from a pelvis things are taken without effort, as a share of the stature."""
OFF_M = 0.18
"""How far off somebody's way to a thing others stand."""
HANDY_RAD = math.radians(55.0)
"""How far aside of where somebody faces."""


def handy(person: Person, *, share: float = HANDY_SHARE, aside_rad: float = HANDY_RAD) -> Where:
    """Within the reach of somebody's arms, nearly without leaning."""

    def where(place: Array) -> bool:
        near = distance_m(person, place) <= share * person.stature_m
        return near and abs(bearing_of(person, place)) <= aside_rad

    return where


def apart(person: Person, least_m: float, most_m: float = math.inf) -> Where:
    """So far from somebody's pelvis."""
    return lambda place: least_m <= distance_m(person, place) <= most_m


def nearer_to(person: Person, other: Person, *, by_m: float = 0.0) -> Where:
    """So much nearer to somebody's pelvis than to another's, at least."""
    return lambda place: distance_m(person, place) + by_m <= distance_m(other, place)


def both(*conditions: Where) -> Where:
    """Where all of some conditions hold."""
    return lambda place: all(where(place) for where in conditions)


def off_the_way(person: Person, *things: Thing, least_m: float = OFF_M) -> Where:
    """Off the straight ways, over the floor, from somebody to some things: out of the way of arms, or of sight."""

    def where(place: Array) -> bool:
        return all(_off_m(place, person, thing) > least_m for thing in things)

    return where


def _off_m(place: Array, person: Person, thing: Thing) -> float:
    """Distance of a place from the straight way to a thing."""
    start, way = np.array(person.position_m), np.array(thing.position_m[:2]) - person.position_m
    share = np.clip((place[:2] - start) @ way / max(float(way @ way), 1e-9), 0.0, 1.0)
    return float(np.linalg.norm(place[:2] - start - share * way))
