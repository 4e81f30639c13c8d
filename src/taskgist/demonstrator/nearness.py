"""Nearness: places near somebody, at which a thing can be taken.

As everywhere, only present positions, sizes and straight lines decide: how far a place is from the other's shoulders,
whether something stands there, whether a straight line from the other's eye to it is free.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.means import Roles
from taskgist.demonstrator.places import GREATEST_LEAN_RAD
from taskgist.demonstrator.putting import Place, Putting
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage
from taskgist.world.geometry.rotations import about_z, normalized, rotate

Array = NDArray[np.float64]

HAND_ROOM_M = 0.06
"""Room left for a hand between a thing and others."""
ASIDES_RAD = tuple(math.radians(degrees) for degrees in (0, 10, -10, 20, -20, 30, -30, 40, -40))
"""Directions tried, off the line between the two people."""
FARTHER_M = (0.0, 0.02, -0.02, 0.04, -0.04, 0.06, 0.08, 0.10)
"""Offsets of the wanted distance that are tried."""
EDGE_M = 0.06
"""Nothing is put nearer than this to the edge of a support."""
AROUND_M = EDGE_M * np.array([(0, 0, 0), (1, 1, 0), (1, -1, 0), (-1, 1, 0), (-1, -1, 0)])
BELOW_SHOULDERS_M = 0.20
"""How far below shoulders a thing is held out: before the chest."""


def near(scene: Scene, thing: str, performer: str, target: str, distance_m: float) -> Place:
    """A free place on the thing's own support, near somebody and in sight, best on the line to the performer.

    Args:
        scene: The scene.
        thing: What is put there.
        performer: Who puts it there.
        target: Near whom.
        distance_m: Wanted horizontal distance from between the target agent's shoulders.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: No candidate is supported, free and in sight.
    """
    putting = Putting.of(scene, thing)
    place = putting.first(
        _around(putting, performer, target, distance_m),
        around=AROUND_M,
        room_m=HAND_ROOM_M,
        suits=lambda place: putting.in_view(place, target),
    )
    if place is None:
        raise SceneError(
            f"no place {distance_m:g} m from {target!r} for {thing!r}",
            where=scene.name,
            field=thing,
            hint="clear the support before that agent, or take another distance",
        )
    return place


def held_out(scene: Scene, roles: Roles, taking: str, distance_m: float) -> Place:
    """A place before somebody's chest, towards the performer, where a thing is held out.

    It is as near to the wanted distance as the performer gets without leaning far; the other leans for the rest.

    Args:
        scene: The scene.
        roles: Who holds it out, with which hand, to whom.
        taking: The hand that shall take it.
        distance_m: Wanted distance from the shoulder of that hand.

    Returns:
        The place in metres, (3,).
    """
    stage, body = Stage(scene), Body(scene, roles.performer)
    shoulder = stage.shoulder(scene.agent(roles.target).arm(taking)).position
    line = _between_shoulders(stage, roles.performer) - shoulder
    length = float(np.linalg.norm(line))
    place = shoulder
    for distance in np.linspace(distance_m, max(distance_m, length / 2), 21):
        place = shoulder + distance * line / length - (0.0, 0.0, BELOW_SHOULDERS_M)
        if body.torso_for(scene.initial, roles.side, place)[1] <= GREATEST_LEAN_RAD:
            break
    return float(place[0]), float(place[1]), float(place[2])


def _between_shoulders(stage: Stage, name: str) -> Array:
    return np.asarray(np.mean([stage.shoulder(arm).position for arm in stage.scene.agent(name).arms], axis=0))


def _around(putting: Putting, performer: str, target: str, distance_m: float) -> Iterator[Array]:
    """Places around somebody, at a distance and the height of a thing, those towards the performer first."""
    start = _between_shoulders(putting.stage, target) * (1.0, 1.0, 0.0)
    ahead = normalized((_between_shoulders(putting.stage, performer) - start) * (1.0, 1.0, 0.0))
    for aside, farther in product(ASIDES_RAD, FARTHER_M):
        yield start + (distance_m + farther) * rotate(about_z(aside), ahead) + (0.0, 0.0, putting.lies[2])
