"""Sight: which of an object's pixels an eye sees, and what the others show instead (5.1.1).

Only the pixels in which the object alone would be seen are worth a ray into the whole scene, and only those of its
bounding window are worth a ray at the object alone. The counts are those of the whole image.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.seeing.from_eye import away_m, from_eye
from taskgist.perspective.seeing.image import Lens, lens_of, window
from taskgist.perspective.target import Sought, Target
from taskgist.world import Agent, Shapes, Stage
from taskgist.world.geometry.between import stand_between
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.raycast import INF

Array = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Sight:
    """The pixels in which an object would be seen if it were alone, and what is seen there.

    Attributes:
        eye: Where the eye is in metres, and how it is turned, a row of 12.
        rays_in_eye: Unit directions of those pixels, (n, 3).
        geoms: Shapes that they show, (n,).
        distances_m: How far these are, (n,).
        visible: Whether the shape is the object's, (n,).
    """

    eye: Array
    rays_in_eye: Array
    geoms: NDArray[np.intp]
    distances_m: Array
    visible: NDArray[np.bool_]


def sight_now(here: Standpoint, target: Target) -> Sight:
    """What an agent sees of an object from where it stands; looked at once."""
    if target.name not in here.sights:
        here.sights[target.name] = look(here.stage.show(here.state), here.agent, target)
    return here.sights[target.name]


def look(stage: Stage, agent: Agent, target: Target, *, cone_rad: float = math.pi) -> Sight:
    """Look at an object.

    Args:
        stage: The scene in a state.
        agent: Whose eye.
        target: The object.
        cone_rad: Half-angle of a cone about the gaze outside of which nothing is looked at.
    """
    eye, lens = stage.eye_row(agent), lens_of(agent.profile.eye)
    least = math.cos(cone_rad) if cone_rad < math.pi else -1.0
    but_body = agent.eye_exclude_body
    found = _looked(stage.shapes, target.others, but_body, target.sought, lens, eye, least)
    rays, geoms, distances_m, visible, count, meshes = found
    if meshes:
        return _look_at_meshes(stage, target, but_body, eye, lens, least)
    stage.count_rays(count)
    return Sight(eye, rays, geoms, distances_m, visible)


def _look_at_meshes(stage: Stage, target: Target, but_body: int, eye: Array, lens: Lens, least: float) -> Sight:
    """As ``look`` where a shape has no formula."""
    around = stand_between(stage.shapes, target.others, but_body, eye[:3], target.centers, target.radii_m)
    rays = _rays_towards(target.sought, lens, eye, least)
    directions = rays @ eye[3:].reshape(3, 3).T
    own, own_m = stage.cast_at(target.shapes, eye[:3], directions)
    alone = own >= 0
    own, own_m = own[alone], own_m[alone]
    other, other_m = stage.cast_at(around, eye[:3], directions[alone])
    visible = own_m <= other_m
    return Sight(eye, rays[alone], np.where(visible, own, other), np.minimum(own_m, other_m), visible)


@compiled
def _rays_towards(sought: Sought, lens: Lens, eye: Array, least: float) -> Array:
    """Rays through all pixels near enough to the gaze that might show an object, in the eye's frame, (k, 3)."""
    first_row, last_row, first_column, last_column = window(lens, eye, sought.centers, sought.radii_m)
    rays, count = np.empty(((last_row - first_row) * (last_column - first_column), 3)), 0
    for row in range(first_row, last_row):
        for column in range(first_column, last_column):
            if lens.rays[row, column, 0] >= least:
                for axis in range(3):
                    rays[count, axis] = lens.rays[row, column, axis]
                count += 1
    return rays[:count]


@compiled
def _looked(
    shapes: Shapes, candidates: Indices, but_body: int, sought: Sought, lens: Lens, eye: Array, least: float
) -> tuple[Array, Indices, Array, NDArray[np.bool_], int, bool]:
    """What a ``Sight`` holds, the number of rays that it took, and whether meshes leave it undecided."""
    around = stand_between(shapes, candidates, but_body, eye[:3], sought.centers, sought.radii_m)
    own, others = from_eye(shapes, sought.shapes, eye, False), from_eye(shapes, around, eye, False)
    meshes = len(own) < len(sought.shapes) or len(others) < len(around)
    rays, frame = _rays_towards(sought, lens, eye, least), eye[3:]
    if meshes:
        rays = rays[:0]
    geoms, distances = np.empty(len(rays), dtype=np.intp), np.empty(len(rays))
    visible, count = np.empty(len(rays), dtype=np.bool_), 0
    for ray in range(len(rays)):
        x, y, z = rays[ray, 0], rays[ray, 1], rays[ray, 2]
        dx = frame[0] * x + frame[1] * y + frame[2] * z
        dy = frame[3] * x + frame[4] * y + frame[5] * z
        dz = frame[6] * x + frame[7] * y + frame[8] * z
        k, own_m = _first(own, dx, dy, dz)
        if own_m == INF:
            continue
        other, other_m = _first(others, dx, dy, dz)
        visible[count] = own_m <= other_m
        geoms[count] = sought.shapes[k] if own_m <= other_m else around[other]
        rays[count, 0], rays[count, 1], rays[count, 2] = x, y, z
        distances[count] = min(own_m, other_m)
        count += 1
    return rays[:count], geoms[:count], distances[:count], visible[:count], len(rays) + count, meshes


@compiled
def _first(rows: Array, x: float, y: float, z: float) -> tuple[int, float]:
    """The first shape along a direction, and how far it is."""
    first, nearest = -1, INF
    for k in range(len(rows)):
        at_m = away_m(rows, k, x, y, z)
        if at_m < nearest:
            first, nearest = k, at_m
    return first, nearest
