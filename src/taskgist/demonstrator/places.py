"""Places: the demonstrator's own geometry, by which it reaches its intention.

A thing is shown on the line of sight, in front of the other's face, or on top of something. Only present positions,
sizes and straight lines are used; what the other could do with more effort, and what facts follow, is for others to
find out. ``hiding`` has the places at which things are hidden.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

POINT_SPACING_M = 0.02
CORRIDOR_M = 0.09
"""Things nearer than this to the way of a carried thing are passed over."""
PASSING_M = 0.05
"""Gap with which they are passed over, and least lift."""
COMFORTABLE_VIEW_M = 0.50
"""Distance from the eye at which things are held to be looked at."""
BELOW_EYES_M = 0.12
"""How far below the line between two faces a thing is held, so that neither hides the other."""
GREATEST_LEAN_RAD = 0.6
"""How far one leans, at most, to hold something up."""


def half_height_m(stage: Stage, thing: str) -> float:
    """Height of the frame of a thing over its underside."""
    frame = stage.body_position(stage.scene.object_body(thing))
    return float(frame[2] - object_points(stage, thing, POINT_SPACING_M)[:, 2].min())


def lift_m(stage: Stage, thing: str, *, start: Array, end: Array) -> float:
    """How high a thing must be lifted to pass over what lies on its way, in metres.

    Args:
        stage: The scene, with the thing where it is lifted from.
        thing: The thing.
        start: Where the way begins, (3,).
        end: Where it ends, (3,).
    """
    bottom = object_points(stage, thing, POINT_SPACING_M)[:, 2].min()
    tops = [bottom]
    for other in stage.scene.objects:
        if other != thing:
            points = object_points(stage, other, POINT_SPACING_M)
            tops += points[_distance_m(points[:, :2], start[:2], end[:2]) < CORRIDOR_M, 2].tolist()
    return float(max(tops) - bottom + PASSING_M)


def _distance_m(points: Array, start: Array, end: Array) -> Array:
    """Distances (n,) of points (n, 2) from a segment."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * along, axis=1))


def on_top(stage: Stage, thing: str) -> tuple[float, float, float]:
    """The middle of the upper face of a thing, metres, (3,)."""
    points = object_points(stage, thing, POINT_SPACING_M)
    x, y = (points.min(axis=0) + points.max(axis=0))[:2] / 2
    return float(x), float(y), float(points[:, 2].max())


def before_face(scene: Scene, performer: str, target: str, side: str, distance_m: float) -> tuple[float, float, float]:
    """A place on the line of sight from a face to another one, as near to a distance as the other can hold a thing.

    Args:
        scene: The scene.
        performer: Who holds.
        target: Before whose face.
        side: The holding hand.
        distance_m: Wanted distance from the target's eye.

    Returns:
        The place in metres, (3,).
    """
    stage, body = Stage(scene), Body(scene, performer)
    eye = stage.eye(scene.agent(target)).position
    sight = stage.eye(scene.agent(performer)).position - eye
    place = eye
    for share in np.linspace(0.0, 1.0, 41):
        distance = distance_m + share * (np.linalg.norm(sight) - distance_m)
        place = eye + distance * normalized(sight) - (0.0, 0.0, BELOW_EYES_M)
        if body.torso_for(scene.initial, side, place)[1] <= GREATEST_LEAN_RAD:
            break
    return float(place[0]), float(place[1]), float(place[2])
