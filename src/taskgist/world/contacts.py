"""What an object rests on, and what it lies in: geometry of one state (5.3.1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.shapes import lowest_point, surface_points
from taskgist.world.stage import Stage

Array = NDArray[np.float64]
DOWN = np.array([0.0, 0.0, -1.0])
POINT_SPACING_M = 0.03
"""Spacing of the points of an object's surface under which a support is searched."""
WALL_DIRECTIONS = 36


def object_points(stage: Stage, name: str, spacing_m: float) -> Array:
    """Points on an object's surface in the world, metres, (n, 3)."""
    model = stage.scene.model
    parts = []
    for geom in stage.scene.object_geoms(name):
        points, _ = surface_points(model, int(geom), spacing_m)
        parts.append(stage.geom(int(geom)).to_world(points))
    return np.concatenate(parts) if parts else np.empty((0, 3))


def support_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object rests on: the owner of the surface beneath it, or None.

    Points of the object's surface are lifted a little and dropped: where one meets a nearly level surface within
    ``support_m`` beneath the object, that surface carries it. The lift makes the answer robust to interpenetration.
    Agents are never supports (DESIGN 4.5).
    """
    points = _low_points(stage, name)
    if not len(points):
        return None
    lift = _lift_m(stage, name, settings)
    body = stage.scene.object_body(name)
    for point in points:
        origin = point + (0, 0, lift)
        geoms, distances = stage.cast(origin, DOWN[None], exclude_body=body)
        owner = _carrier(stage, int(geoms[0]), float(distances[0]) - lift, settings)
        if owner and owner != name and _level(stage, origin, body, settings):
            return owner
    return None


def _low_points(stage: Stage, name: str) -> Array:
    """Surface points within reach of a support, lowest first: exact lowest points, then samples."""
    model = stage.scene.model
    exact = []
    for geom in stage.scene.object_geoms(name):
        pose = stage.geom(int(geom))
        lowest = lowest_point(model, int(geom), pose.matrix)
        if lowest is not None:
            exact.append(pose.to_world(lowest))
    if not exact:
        return np.empty((0, 3))
    points = np.concatenate((np.array(exact), object_points(stage, name, POINT_SPACING_M)))
    order = np.argsort(np.round(points[:, 2], 6), kind="stable")
    points = points[order]
    return np.asarray(points[points[:, 2] < points[0, 2] + 2 * POINT_SPACING_M])


def _lift_m(stage: Stage, name: str, settings: Contact) -> float:
    """A lift that stays inside the object, so that what stands above it is not taken for its support."""
    points = object_points(stage, name, POINT_SPACING_M)
    return min(settings.lift_m, float(np.ptp(points[:, 2])) / 2)


def _carrier(stage: Stage, geom: int, gap_m: float, settings: Contact) -> str | None:
    if geom < 0 or gap_m > settings.support_m:
        return None
    owner = stage.scene.owners[geom]
    return None if owner in stage.scene.agents else owner


def _level(stage: Stage, origin: Array, exclude_body: int, settings: Contact) -> bool:
    normal = stage.normal(origin, DOWN, exclude_body=exclude_body)
    return normal is not None and bool(normal[2] >= math.cos(settings.support_slope_rad))


def container_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object lies in: one body with a floor beneath it and walls all round (DESIGN 4.5), or None.

    Horizontal rays from the object's middle must nearly all meet the same body within ``container_m``, and so must
    the ray straight down. The room itself is no container.
    """
    geoms = stage.scene.object_geoms(name)
    if not len(geoms):
        return None
    middle = stage.geom_centers(geoms).mean(axis=0)
    body = stage.scene.object_body(name)
    beneath, _ = stage.cast(middle, DOWN[None], exclude_body=body)
    owner = _body_owner(stage, int(beneath[0]))
    if owner is None or owner == name:
        return None
    heading = stage.body_axis(body, 0)[:2]
    start = math.atan2(heading[1], heading[0])
    angles = start + 2 * math.pi * np.arange(WALL_DIRECTIONS) / WALL_DIRECTIONS
    around = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=1)
    hits, distances = stage.cast(middle, around, exclude_body=body)
    own = [
        _body_owner(stage, int(g)) == owner and d <= settings.container_m for g, d in zip(hits, distances, strict=True)
    ]
    return owner if np.mean(own) >= settings.container_walls else None


def _body_owner(stage: Stage, geom: int) -> str | None:
    """Owner of a shape that may contain things: objects and furniture, not agents, not the room's own walls."""
    if geom < 0 or int(stage.scene.model.geom_bodyid[geom]) == 0:
        return None
    owner = stage.scene.owners[geom]
    return None if owner in stage.scene.agents else owner


def overlaps(stage: Stage, *, deeper_than_m: float) -> dict[tuple[str, str], float]:
    """Owners whose shapes overlap, with the depth in metres; furniture among itself, and the floor, are left out."""
    scene = stage.scene
    movable = {*scene.agents, *scene.objects}
    solid = stage.solid_geoms()
    deepest: dict[tuple[str, str], float] = {}
    for geom, other in stage.near_pairs(solid, solid, limit_m=0.0):
        pair = tuple(sorted((scene.owners[geom], scene.owners[other])))
        if (
            geom >= other
            or pair[0] == pair[1]
            or not movable & set(pair)
            or stage.is_plane(geom)
            or stage.is_plane(other)
        ):
            continue
        depth = -stage.distance(geom, other, limit_m=0.0)
        if depth > deeper_than_m:
            deepest[pair[0], pair[1]] = max(depth, deepest.get((pair[0], pair[1]), 0.0))
    return deepest
