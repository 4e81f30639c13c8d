"""Removing: putting things where they are far from somebody, in plain view or hidden, as places and means.

A demonstrator who puts something away looks for a free place that is as far off as it wishes, and takes the one that
is least trouble: the nearest to where the thing lies. Distances over the floor and straight lines of sight are all it
uses.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.hand import UP
from taskgist.demonstrator.hiding import behind
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import PutDown, Withdraw
from taskgist.demonstrator.supports import POINT_SPACING_M, SUPPORT_M, nearest_other_m, supported
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]
Place = tuple[float, float, float]

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

    def script(scene: Scene) -> Script:
        place = far_from(scene, roles, distance_m)
        return roles.script("put away", f"put {distance_m:g} m from {roles.target}", PutDown(place), Withdraw())

    return script


def put_behind_far(roles: Roles, *, occluder: str) -> Means:
    """Hide away: put behind something that is farther from the target agent, as it sees it."""

    def script(scene: Scene) -> Script:
        place = behind(scene, roles.thing, occluder, roles.target)
        _check_farther(scene, roles, occluder, np.array(place))
        return roles.script("hide away", f"put far off behind {occluder}", PutDown(place), Withdraw())

    return script


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
    stage, body = Stage(scene), Body(scene, roles.performer)
    points = object_points(stage, roles.thing, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    lies = np.array([*((low + high) / 2)[:2], low[2]])
    shape = points - lies
    for place in _around(stage, body, lies):
        far = _distance_m(scene, roles.target, place) >= distance_m
        if far and _handy(body, scene, roles.side, place + (high - low) / 2 * UP) and _fits(stage, roles, shape, place):
            return float(place[0]), float(place[1]), float(place[2])
    raise SceneError(
        f"no free place {distance_m:g} m from {roles.target!r} that {roles.performer!r} gets to",
        where=scene.name,
        field=roles.thing,
        hint="ask for less, or clear the support before the performing agent",
    )


def _around(stage: Stage, body: Body, lies: Array) -> Iterator[Array]:
    """Places at the height of a thing around the performer, those nearest to the thing first."""
    x, y = stage.scene.initial.qpos[body.agent.base][:2]
    offsets = np.arange(-AROUND_M, AROUND_M + GRID_M / 2, GRID_M)
    places = [np.array([x + dx, y + dy, lies[2]]) for dx, dy in product(offsets, offsets)]
    return iter(sorted(places, key=lambda place: float(np.linalg.norm(place - lies))))


def _distance_m(scene: Scene, name: str, place: Array) -> float:
    """Distance of a place from an agent's pelvis, over the floor."""
    return float(np.linalg.norm(place[:2] - scene.initial.qpos[scene.agent(name).base][:2]))


def _handy(body: Body, scene: Scene, side: str, place: Array) -> bool:
    """Whether a hand gets there without leaning far."""
    return bool(body.torso_for(scene.initial, side, place)[1] <= GREATEST_LEAN_RAD)


def _fits(stage: Stage, roles: Roles, shape: Array, place: Array) -> bool:
    """Whether a thing of some shape (n, 3) can be put there, and is in the target agent's view then."""
    radius = float(np.linalg.norm(shape[:, :2], axis=1).max())
    return (
        supported(stage, place + (radius + EDGE_M) * CROSS)
        and nearest_other_m(stage, roles.thing, place) > radius + HAND_ROOM_M
        and _in_view(stage, roles, shape + place)
    )


def _in_view(stage: Stage, roles: Roles, points: Array) -> bool:
    """Whether nothing but the thing itself is on the lines from the target agent's eye to points (n, 3)."""
    agent = stage.scene.agent(roles.target)
    eye = stage.eye(agent).position
    lines = points - eye
    own = set(stage.scene.geoms_of(roles.thing).tolist())
    geoms, distances = stage.cast(eye, normalized(lines), exclude_body=agent.eye_exclude_body)
    free = distances > np.linalg.norm(lines, axis=1) - SUPPORT_M
    return bool(np.all(free | np.isin(geoms, list(own))))


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
