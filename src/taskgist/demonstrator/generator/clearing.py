"""Clearing: means of showing a thing by moving away what hides it."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.generator.sight import share_in_view
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.putting import Place, Putting
from taskgist.demonstrator.removing import CROSS, EDGE_M
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import PutDown, Take, Withdraw
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage

Array = NDArray[np.float64]

GRID_M, AROUND_M = 0.06, 0.54
"""Spacing of the places that are looked at for what is moved away, and how far around where it stands."""
ROOM_M = 0.05
"""Room left between it and other things."""
CLEAR_SHARE = 0.9
"""How much of the thing must be in view then."""
GREATEST_LEAN_RAD = 0.85


def move_away(roles: Roles, *, occluder: str) -> Means:
    """Show by moving away what stands in the line of sight; the thing itself is not touched."""

    def script(scene: Scene) -> Script:
        stage = Stage(scene)
        if share_in_view(stage, roles.target, roles.thing) > 0.0:
            raise SceneError(f"{occluder!r} does not hide {roles.thing!r}", where=scene.name, hint="draw another room")
        steps = (Take(occluder, roles.side), PutDown(_clear_place(scene, roles, occluder)), Withdraw())
        return Script(
            "show",
            roles.performer,
            roles.target,
            roles.thing,
            steps,
            roles.target_watches,
            f"{occluder} moved out of the line of sight",
            roles.target_returns_to,
        )

    return script


def _clear_place(scene: Scene, roles: Roles, occluder: str) -> Place:
    """The nearest free place at which the occluder is out of the line of sight, and that the hand gets to."""
    putting, body = Putting.of(scene, occluder), Body(scene, roles.performer)

    def suits(place: Array) -> bool:
        lean = body.torso_for(scene.initial, roles.side, place + putting.middle)[1]
        return bool(lean <= GREATEST_LEAN_RAD) and _clears(putting, roles, place)

    found = putting.first(_around(putting), around=(putting.radius_m + EDGE_M) * CROSS / 2, room_m=ROOM_M, suits=suits)
    if found is None:
        raise SceneError(
            f"no free place for {occluder!r} out of the line of sight", where=scene.name, hint="draw another room"
        )
    return found


def _around(putting: Putting) -> list[Array]:
    offsets = np.arange(-AROUND_M, AROUND_M + GRID_M / 2, GRID_M)
    places = [putting.lies + (x, y, 0.0) for x, y in product(offsets, offsets)]
    return sorted(places, key=lambda place: float(np.linalg.norm(place - putting.lies)))


def _clears(putting: Putting, roles: Roles, place: Array) -> bool:
    """Whether the thing is in view once the occluder stands there."""
    state = putting.stage.scene.initial
    at = putting.stage.scene.object_slice(putting.thing)
    pose = np.array(state.qpos[at])
    pose[:3] += place - putting.lies
    with putting.stage.showing(state.replace(at=at, to=pose)):
        return share_in_view(putting.stage, roles.target, roles.thing) >= CLEAR_SHARE
