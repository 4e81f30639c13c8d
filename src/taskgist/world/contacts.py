"""What an object rests on, and what it lies in: geometry of one state (5.3.1)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.geometry.shapes import lowest_point
from taskgist.world.stage import Stage

Array = NDArray[np.float64]
DOWN = np.array([0.0, 0.0, -1.0])
POINT_SPACING_M = 0.03
"""Spacing of the points of an object's surface under which a support is searched."""
WALL_DIRECTIONS = 36


def object_points(stage: Stage, name: str, spacing_m: float) -> Array:
    """Points on an object's surface in the world, metres, (n, 3).

    Raises:
        UnknownNameError: There is no such object.
    """
    stage.scene.object_body(name)
    parts = []
    for geom in stage.scene.seen_geoms(name):
        points, _ = stage.scene.surface_points(int(geom), spacing_m)
        parts.append(stage.geom(int(geom)).to_world(points))
    return np.concatenate(parts) if parts else np.empty((0, 3))


def support_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object rests on: the owner of the surface beneath it, or None.

    Points of the object's surface are lifted a little and dropped: where one meets a nearly level surface within
    ``support_m`` beneath the object, that surface carries it. The lift makes the answer robust to interpenetration.
    Agents are never supports (DESIGN 4.5).
    """
    samples = object_points(stage, name, POINT_SPACING_M)
    points = _low_points(stage, name, samples)
    if not len(points):
        return None
    # The lift stays inside the object, so that what stands above it is not taken for its support.
    lift = min(settings.lift_m, float(np.ptp(samples[:, 2])) / 2)
    starts = points + (0.0, 0.0, lift)
    around = _around_points(stage, name, starts, lift + settings.support_m)
    geoms, distances, normals = stage.cast_each(around, starts, np.tile(DOWN, (len(starts), 1)))
    level = normals[:, 2] >= math.cos(settings.support_slope_rad)
    met = geoms[(geoms >= 0) & level & (distances - lift <= settings.support_m)]
    owners = (stage.scene.owners[geom] for geom in met.tolist())
    return next((owner for owner in owners if owner != name and owner not in stage.scene.agents), None)


def _around_points(stage: Stage, name: str, points: Array, margin_m: float) -> NDArray[np.intp]:
    """Seen shapes within a margin of some points of an object, but those of the object's own body, (n,)."""
    middle = points.mean(axis=0)
    radius_m = float(np.linalg.norm(points - middle, axis=1).max()) + margin_m
    return stage.between(middle, middle[None], np.array([radius_m]), but_body=stage.scene.object_body(name))


def _low_points(stage: Stage, name: str, samples: Array) -> Array:
    """Surface points within reach of a support, lowest first: exact lowest points, and the lowest of the samples."""
    exact = []
    for geom in stage.scene.seen_geoms(name):
        pose = stage.geom(int(geom))
        lowest = lowest_point(stage.scene.model, int(geom), pose.matrix)
        if lowest is not None:
            exact.append(pose.to_world(lowest))
    if not exact:
        return np.empty((0, 3))
    points = np.concatenate((np.array(exact), samples))
    points = points[np.argsort(np.round(points[:, 2], 6), kind="stable")]
    return np.asarray(points[points[:, 2] < points[0, 2] + 2 * POINT_SPACING_M])


def container_of(stage: Stage, name: str, settings: Contact) -> str | None:
    """What an object lies in: one body with a floor beneath it and walls all round (DESIGN 4.5), or None.

    From the object's middle, the ray straight down must meet the body, and nearly all horizontal ones must meet it
    within ``container_m``, each on a face that looks towards the object: who has sunk into a table top is not inside
    the table. Whatever else lies in the container is looked through. The room itself, and agents, are no containers.
    """
    middle = stage.geom_centers(stage.scene.seen_geoms(name)).mean(axis=0)
    heading = stage.body_axis(stage.scene.object_body(name), 0)
    rays = _around(math.atan2(heading[1], heading[0]))
    return next(
        (owner for owner in _candidates(stage, name, middle) if _encloses(stage, owner, middle, rays, settings)), None
    )


def _around(start_rad: float) -> Array:
    """Down, and level all round, unit vectors (1 + n, 3)."""
    angles = start_rad + 2 * math.pi * np.arange(WALL_DIRECTIONS) / WALL_DIRECTIONS
    level = np.stack((np.cos(angles), np.sin(angles), np.zeros_like(angles)), axis=1)
    return np.concatenate((DOWN[None], level))


def _candidates(stage: Stage, name: str, middle: Array) -> list[str]:
    """Tracked objects and furniture in whose bounding spheres the middle lies; the room's own walls do not count."""
    scene = stage.scene
    others = [owner for owner in scene.bodies if owner != name and stage.state.known([owner])]
    return [owner for owner in others if stage.in_bounds(scene.geoms_of(owner), middle)]


def _encloses(stage: Stage, owner: str, middle: Array, rays: Array, settings: Contact) -> bool:
    geoms, distances, normals = stage.cast_each(stage.scene.seen_geoms(owner), np.tile(middle, (len(rays), 1)), rays)
    faces = (geoms >= 0) & (np.sum(normals * rays, axis=1) < 0)
    walls = faces[1:] & (distances[1:] <= settings.container_m)
    return bool(faces[0]) and float(walls.mean()) >= settings.container_walls


def overlaps(stage: Stage, *, deeper_than_m: float) -> dict[tuple[str, str], float]:
    """Owners whose shapes overlap, with the depth in metres; furniture among itself, and the floor, are left out."""
    scene = stage.scene
    movable = {*scene.agents, *scene.objects}
    solid = [geom for geom in stage.solid_geoms() if not stage.is_plane(geom)]
    moving = [geom for geom in solid if scene.owners[geom] in movable]
    deepest: dict[tuple[str, str], float] = {}
    for geom, other in stage.near_pairs(moving, solid, limit_m=0.0):
        first, second = sorted((scene.owners[geom], scene.owners[other]))
        if first == second or (other in moving and geom > other):
            continue
        depth = -stage.distance(geom, other, limit_m=0.0)
        if depth > deeper_than_m:
            deepest[first, second] = max(depth, deepest.get((first, second), 0.0))
    return deepest
