"""Removing: putting things where they are far from somebody, in plain view or hidden, as places and means.

A demonstrator who puts something away looks for a free place that is as far off as it wishes, and takes the one that
is least trouble: the nearest to where the thing lies. Distances over the floor and straight lines of sight are all it
uses.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.hiding import behind
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.putting import Place, Putting
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage

Array = NDArray[np.float64]

GRID_M, AROUND_M = 0.05, 1.0
"""Spacing of the places that are looked at, and how far around the performer."""
HAND_ROOM_M = 0.06
"""Room that a hand needs around a thing."""
CROSS = np.array([(0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)])
EDGE_M = 0.02
"""How far inside the edge of its support a thing is put, at least."""
GREATEST_LEAN_RAD = 0.9
"""How far one leans, at most, to put something down: who stands stoops over a table anyway."""
FARTHER_M = 0.15
"""Who hides something away takes it so much farther off, at least."""


def put_far_from(roles: Roles, *, distance_m: float) -> Means:
    """Put away, in plain view, at least so far from where the target agent is (over the floor)."""
    return roles.putting(
        "put away", f"put {distance_m:g} m from {roles.target}", lambda scene: far_from(scene, roles, distance_m)
    )


def put_behind_far(roles: Roles, *, occluder: str) -> Means:
    """Hide away: put behind something that is farther from the target agent, as it sees it."""

    def place(scene: Scene) -> Place:
        found = behind(scene, roles.thing, occluder, roles.target)
        _check_farther(scene, roles, occluder, np.array(found))
        return found

    return roles.putting("hide away", f"put far off behind {occluder}", place)


def far_from(scene: Scene, roles: Roles, distance_m: float) -> Place:
    """The place nearest to a thing that is far from the target agent, in its view, and handy for the performer.

    Args:
        scene: The scene.
        roles: Who puts what away from whom, with which hand.
        distance_m: Least distance over the floor from the target agent's pelvis.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: There is no such place.
    """
    putting, body = Putting.of(scene, roles.thing), Body(scene, roles.performer)
    places = (place for place in _around(putting, body) if _distance_m(scene, roles.target, place) >= distance_m)
    place = putting.first(
        places,
        around=(putting.radius_m + EDGE_M) * CROSS,
        room_m=HAND_ROOM_M,
        suits=lambda place: (
            _handy(body, scene, roles.side, place + putting.middle) and putting.in_view(place, roles.target)
        ),
    )
    if place is None:
        raise SceneError(
            f"no free place {distance_m:g} m from {roles.target!r} that {roles.performer!r} gets to",
            where=scene.name,
            field=roles.thing,
            hint="ask for less, or clear the support before the performing agent",
        )
    return place


def _around(putting: Putting, body: Body) -> list[Array]:
    """Places at the height of a thing around the performer, those nearest to the thing first."""
    x, y = putting.stage.scene.initial.qpos[body.agent.base][:2]
    offsets = np.arange(-AROUND_M, AROUND_M + GRID_M / 2, GRID_M)
    places = [np.array([x + dx, y + dy, putting.lies[2]]) for dx, dy in product(offsets, offsets)]
    return sorted(places, key=lambda place: float(np.linalg.norm(place - putting.lies)))


def _distance_m(scene: Scene, name: str, place: Array) -> float:
    """Distance of a place from an agent's pelvis, over the floor."""
    return float(np.linalg.norm(place[:2] - scene.initial.qpos[scene.agent(name).base][:2]))


def _handy(body: Body, scene: Scene, side: str, place: Array) -> bool:
    """Whether a hand gets there without leaning far."""
    return bool(body.torso_for(scene.initial, side, place)[1] <= GREATEST_LEAN_RAD)


def _check_farther(scene: Scene, roles: Roles, occluder: str, place: Array) -> None:
    """Raise a SceneError unless a place is farther from the target agent than where the thing lies."""
    lies = Stage(scene).body_position(scene.object_body(roles.thing))
    farther = _distance_m(scene, roles.target, place) - _distance_m(scene, roles.target, lies)
    if farther < FARTHER_M:
        raise SceneError(
            f"the place behind {occluder!r} is not {FARTHER_M:g} m farther from {roles.target!r}",
            where=scene.name,
            field=occluder,
            value=round(farther, 3),
            hint="let the occluder stand farther from the target agent",
        )
