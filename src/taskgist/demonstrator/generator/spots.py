"""Spots: places in a room at which something is held, let go or put, as a performer picks them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.furniture import Table, Thing
from taskgist.demonstrator.generator.arrangement import EDGE_M, TRIES, Arrangement, Where
from taskgist.demonstrator.generator.furnishing import any_place, on_top
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.things import SMALL, any_of
from taskgist.demonstrator.generator.zones import handy, off_the_way
from taskgist.demonstrator.hand import SIGNS
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.places import lift_m
from taskgist.demonstrator.putting import Place
from taskgist.demonstrator.room import Person
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage

Array = NDArray[np.float64]

FARTHEST_EDGE_M = 1.2
LIFTED_M = 0.10
"""How far above where it stands something is held, at least."""
DISTRACTORS, WATCHES = 5, 0.3
"""Most other things, and how often the target agent looks at the thing in the beginning."""


def thing_at_hand(arrangement: Arrangement, thing: Thing | None = None, *, distractors: int = DISTRACTORS) -> Setting:
    """Put something handy for the performer on the table, and others around it.

    Args:
        arrangement: The room.
        thing: What is acted on; None: any small thing.
        distractors: How many others, at most.

    Returns:
        The room as it is then, with who acts on the thing.
    """
    rng = arrangement.rng
    put = arrangement.put(thing or any_of(rng, SMALL), handy(arrangement.performer))
    arrangement.add_distractors(distractors, where=off_the_way(arrangement.performer, put))
    return arrangement.setting(arrangement.roles(put, arrangement.hand_for(put), watches=WATCHES))


def free_place(arrangement: Arrangement, where: Where, *, radius_m: float) -> Array:
    """A place (3,) on the table with nothing around it.

    Raises:
        SceneError: There is none.
    """
    table = arrangement.table
    for _ in range(TRIES):
        place = any_place(table, arrangement.rng, radius_m + EDGE_M)
        if on_top(table, place, radius_m + EDGE_M) and arrangement.free(place, radius_m) and where(place):
            return place
    raise SceneError("no free place on the table", where="room", hint="draw another room")


def to_the_edge_m(person: Person, table: Table) -> float:
    """How far the edge of a table is before somebody."""
    ahead = np.array([math.cos(person.yaw_rad), math.sin(person.yaw_rad)])
    away = np.arange(0.0, FARTHEST_EDGE_M, 0.01)
    on = [on_top(table, np.array(person.position_m) + each * ahead, 0.0) for each in away]
    return float(away[on.index(True)]) if any(on) else FARTHEST_EDGE_M


def beside(person: Person, side: str, *, aside_m: float, ahead_m: float) -> tuple[float, float]:
    """A floor point beside somebody, metres, (2,).

    Args:
        person: Who.
        side: On the side of which hand.
        aside_m: How far from the pelvis to that side.
        ahead_m: How far before it.
    """
    cos, sin = math.cos(person.yaw_rad), math.sin(person.yaw_rad)
    left = -SIGNS[side] * aside_m
    x, y = person.position_m
    return x + ahead_m * cos - left * sin, y + ahead_m * sin + left * cos


def before_chest(scene: Scene, roles: Roles, *, before_m: float, below_m: float) -> Place:
    """Where the performer holds the thing before its chest, on the side of the hand, metres, (3,).

    Args:
        scene: The scene, in which the thing stands somewhere.
        roles: Who holds what, in which hand.
        before_m: How far ahead of the shoulders.
        below_m: How far below them; but it is always held above the table.
    """
    stage, agent = Stage(scene), scene.agent(roles.performer)
    shoulder, both = stage.shoulder(agent.arm(roles.side)), [stage.shoulder(arm).position for arm in agent.arms]
    x, y, z = (shoulder.position + np.mean(both, axis=0)) / 2 + before_m * shoulder.matrix[:, 0]
    return lifted(stage, roles.thing, (float(x), float(y), float(z) - below_m))


def lifted(stage: Stage, thing: str, place: Place) -> Place:
    """A place for the middle of a thing, (3,), raised until it is clear of its support and of what stands beneath."""
    stands, there = stage.body_position(stage.scene.object_body(thing)), np.array(place)
    clear = max(LIFTED_M, lift_m(stage, thing, start=there, end=there))
    return place[0], place[1], max(place[2], float(stands[2]) + clear)
