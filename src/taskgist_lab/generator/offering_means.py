"""Means of showing: moving away what hides a thing, and turning the face of a picture."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import Body
from taskgist.moving.hand_pose import SIGNS
from taskgist.moving.steps import PutDown, Take, Withdraw, half_height_m
from taskgist.moving.steps_from_above import LiftAway, TakeFromAbove, Turn
from taskgist.world.geometry.transforms import yaw_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.outcomes import share_in_view
from taskgist_lab.simulator.demonstration import Script
from taskgist_lab.simulator.means import CROSS, EDGE_M, Means, Roles
from taskgist_lab.simulator.places import Place, Putting

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
            raise SceneError(
                f"{occluder!r} does not hide {roles.thing!r}",
                where=scene.name,
                hint="try another room",
            )
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
            f"no free place for {occluder!r} out of the line of sight",
            where=scene.name,
            hint="try another room",
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


# --- Turning: means of showing a picture by turning its face towards somebody.

DIP_RAD = math.radians(50.0)
"""How far the fingers point down that hold a picture at its upper edge."""
WRIST_RAD = math.radians(110.0)
"""Wrists and elbows turn no farther."""
OVER_M = 0.06
"""How much higher than the picture is tall the hand rises from it."""


def turn_towards(roles: Roles) -> Means:
    """Show by turning: a face, which looks along the thing's x axis or against it, comes to look at the target agent.

    The hand turns inwards, as hands do: the right one to the left.
    """

    def script(scene: Scene) -> Script:
        stage = Stage(scene)
        place = stage.body_position(scene.object_body(roles.thing))
        eye = stage.eye(scene.agent(roles.target)).position
        wanted = math.atan2(eye[1] - place[1], eye[0] - place[0])
        now = yaw_of(scene.initial.qpos[scene.object_slice(roles.thing)][3:])
        angle = _inwards(wanted - now, roles.side)
        take = TakeFromAbove(roles.thing, roles.side, DIP_RAD, aside_rad=-angle / 3)
        away = LiftAway(2 * half_height_m(stage, roles.thing) + OVER_M)
        return _script(roles, take, angle, away)

    return script


def _inwards(angle_rad: float, side: str) -> float:
    """The least turn inwards that brings one face or the other there.

    Raises:
        SceneError: It is more than wrists do.
    """
    angle = SIGNS[side] * (SIGNS[side] * angle_rad % math.pi)
    if abs(angle) > WRIST_RAD:
        raise SceneError("too far to be turned", where=side, value=round(angle, 2), hint="take the other hand")
    return angle


def _script(roles: Roles, take: TakeFromAbove, angle_rad: float, away: LiftAway) -> Script:
    return Script(
        "show",
        roles.performer,
        roles.target,
        roles.thing,
        (take, Turn(angle_rad), away),
        roles.target_watches,
        "turned with its face to the other",
        roles.target_returns_to,
    )
