"""Hiding places inside things and under things, and the means that use them."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.generator.handling import PutInto
from taskgist.demonstrator.generator.sight import would_be_hidden
from taskgist.demonstrator.generator.things import WALL_M
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.places import POINT_SPACING_M, half_height_m
from taskgist.demonstrator.putting import Place, Putting
from taskgist.demonstrator.script import Script, Step
from taskgist.demonstrator.steps import HoldUp, Take, Withdraw
from taskgist.demonstrator.throwing import LetFall
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

ROOM_M = 0.015
"""Gap between a thing and the walls around it."""
OFFSETS_M = tuple(0.02 * step for step in range(-4, 5))
"""Offsets from the middle of a bin that are tried."""
TOWARDS_M = 0.05
"""How far from its middle towards the target agent a thing is best put."""
OVER_RIM_M, HELD_S = 0.01, 0.1
"""How high above the rim of a bin the underside of a thing is when the hand opens, and how long it is there."""


def script_of(roles: Roles, task: str, means: str, steps: tuple[Step, ...]) -> Script:
    """A script of roles in which the performer need not take the thing first, or not at all."""
    return Script(
        task,
        roles.performer,
        roles.target,
        roles.thing,
        steps,
        roles.target_watches,
        means,
        roles.target_returns_to,
    )


def put_inside(roles: Roles, task: str, *, container: str) -> Means:
    """Let fall into an open bin whose walls hide the thing from the target agent."""

    def script(scene: Scene) -> Script:
        place, rim_m = inside(scene, roles, container)
        x, y, _ = place
        held = (x, y, rim_m + OVER_RIM_M + half_height_m(Stage(scene), roles.thing))
        steps = (HoldUp(held, HELD_S), LetFall(dropped=False), Withdraw())
        return roles.script(task, f"put into {container}", *steps)

    return script


def inside(scene: Scene, roles: Roles, container: str) -> tuple[Place, float]:
    """A place in a bin where its walls hide the thing from the target agent's eye, and the height of its rim.

    Raises:
        SceneError: There is none.
    """
    putting = Putting.of(scene, roles.thing)
    points = object_points(putting.stage, container, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = np.array([*((low + high) / 2)[:2], low[2] + WALL_M])
    walls = np.abs(points[:, :2] - middle[:2])
    room = float(np.linalg.norm(walls[points[:, 2] > low[2] + 2 * WALL_M], axis=1).min()) - WALL_M
    eye = putting.stage.eye(scene.agent(roles.target)).position
    best = TOWARDS_M * normalized((eye - middle)[:2])  # there the wall hides most, and arms have room
    for offset in sorted(product(OFFSETS_M, OFFSETS_M), key=lambda each: float(np.linalg.norm(each - best))):
        fits = np.linalg.norm(offset) + putting.radius_m + ROOM_M <= room
        place = middle + (*offset, 0.0)
        if fits and would_be_hidden(
            putting.stage, roles.target, roles.thing, putting.shape + place, but=(roles.performer,)
        ):
            return (float(place[0]), float(place[1]), float(place[2])), float(high[2])
    raise SceneError(
        f"{container!r} does not hide {roles.thing!r} from {roles.target!r}",
        where=scene.name,
        hint="take a deeper one",
    )


def put_under(roles: Roles, *, cover: str) -> Means:
    """Hide by putting a cover, which is open below, over the thing; the thing itself is not touched."""

    def script(scene: Scene) -> Script:
        putting = Putting.of(scene, roles.thing)
        place = tuple(putting.lies.tolist())
        steps = (Take(cover, roles.side), PutInto(place), Withdraw())
        assert half_height_m(putting.stage, cover) > putting.middle[2]
        return script_of(roles, "hide", f"{cover} put over it", steps)

    return script
