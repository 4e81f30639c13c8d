"""Hiding places: where straight lines from the other's eye to a thing all meet the occluder."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.putting import Place, Putting
from taskgist.demonstrator.supports import POINT_SPACING_M
from taskgist.errors import SceneError
from taskgist.world import Scene, Stage, object_points
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

HAND_ROOM_M = 0.08
"""Room that a hand needs around a thing: fingers reach this far beyond it."""
GAPS_M = tuple(0.02 * step for step in range(10))
"""Gaps beyond that room that are tried behind an occluder."""
ASIDES_M = (0.0, 0.03, -0.03, 0.06, -0.06)
"""Offsets across the line of sight that are tried."""
HEAD_MOVES_M = 0.05
"""Nobody keeps the head quite still: a thing is hidden from places so far around the eye, too."""


def behind(scene: Scene, thing: str, occluder: str, target: str) -> Place:
    """A place on the occluder's own support at which the occluder hides a thing from the target agent's eye.

    Candidates lie behind the occluder as the target agent sees it, the nearest to it first.

    Args:
        scene: The scene.
        thing: What is hidden.
        occluder: Behind what.
        target: From whom.

    Returns:
        Where the middle of the thing's underside goes, metres, (3,).

    Raises:
        SceneError: No candidate is hidden, free and on the support.
    """
    putting = Putting.of(scene, thing)
    place = putting.first(
        _beyond(putting, occluder, target),
        around=np.zeros((1, 3)),
        room_m=HAND_ROOM_M / 2,
        suits=lambda place: _hidden(putting.stage, thing, putting.shape + place, occluder, target),
    )
    if place is None:
        raise SceneError(
            f"no place behind {occluder!r} hides {thing!r} from {target!r}",
            where=scene.name,
            field=occluder,
            hint="take a larger occluder, or clear the support behind it",
        )
    return place


def _beyond(putting: Putting, occluder: str, target: str) -> Iterator[Array]:
    """Places behind the occluder as seen by the target agent, at the height of its underside, near ones first."""
    stage = putting.stage
    eye = stage.eye(stage.scene.agent(target)).position
    points = object_points(stage, occluder, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    middle = (low + high)[:2] / 2
    away = normalized(middle - eye[:2])
    across = np.array([-away[1], away[0]])
    least = float(np.max((points[:, :2] - middle) @ away)) + HAND_ROOM_M + putting.radius_m
    for gap, aside in product(GAPS_M, ASIDES_M):
        yield np.array([*(middle + (least + gap) * away + aside * across), low[2]])


def _hidden(stage: Stage, thing: str, points: Array, occluder: str, target: str) -> bool:
    """Whether the lines from places around the target agent's eye to all points meet the occluder."""
    scene = stage.scene
    head = stage.eye(scene.agent(target))
    for move in HEAD_MOVES_M * np.array([(0, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]):
        eye = head.to_world(move)
        away = np.linalg.norm(points - eye, axis=1)
        geoms, distances = stage.cast(eye, normalized(points - eye), exclude_body=scene.object_body(thing))
        owners = [scene.owners[geom] if geom >= 0 else "" for geom in geoms]
        if not all(owner == occluder for owner in owners) or np.any(distances >= away):
            return False
    return True
