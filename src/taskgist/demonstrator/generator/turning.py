"""Turning: means of showing a picture by turning its face towards somebody."""

from __future__ import annotations

import math

from taskgist.demonstrator.generator.handling import LiftAway, TakeFromAbove, Turn
from taskgist.demonstrator.hand import SIGNS
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.places import half_height_m
from taskgist.demonstrator.script import Script
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage
from taskgist.world.geometry.rotations import yaw_of

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
