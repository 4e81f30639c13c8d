"""What many eyes see of an object, told roughly and quickly: never too little.

The agent's own body is looked past, meshes hide nothing, and a mesh that is looked at fills the box around it. So
whoever does not even glimpse an object surely does not see it; whether the others do is for ``visibility`` to tell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.image import pixel_rays, window
from taskgist.perspective.target import Target
from taskgist.world import Agent, Shapes, Stage
from taskgist.world.compiled import compiled
from taskgist.world.raycast import BOX, INF, PLANE, box, local, surface
from taskgist.world.rays import stand_between

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
GRAZE_M = 1e-9
"""What hides a surface is nearer to the eye than the surface, by more than rounding."""


def off_gaze(eyes: Array, gazes: Array, centers: Array, radii_m: Array | None = None) -> Array:
    """Angles between gazes and the nearest of some balls, (n,): 0 or less for what is right ahead.

    Args:
        eyes: Positions, metres, (n, 3).
        gazes: Unit directions, (n, 3).
        centers: Centres of the balls, metres, (k, 3) or (3,).
        radii_m: Their radii; points if left out.
    """
    middles = np.atleast_2d(centers)
    return _off_gaze(eyes, gazes, middles, np.zeros(len(middles)) if radii_m is None else radii_m)


def glimpsed(
    stage: Stage, agent: Agent, target: Target, eyes: tuple[Array, Array], asked: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Whether an object may be seen in the gaze cone.

    Args:
        stage: The scene; where the agent is in it does not matter.
        agent: Whose eyes: field of view, image and gaze cone.
        target: The object.
        eyes: Positions, metres, (n, 3), and orientations, (n, 3, 3).
        asked: From which of them, (n,); the others do not count.
    """
    lens = agent.profile.eye
    counted = stage.seen.copy()
    counted[agent.geoms] = False
    counted[target.shapes] = False
    return _glimpsed(
        stage.shapes,
        _near_lines(stage.shapes, counted, eyes[0], asked, target.centers, target.radii_m),
        target.shapes,
        target.centers,
        target.radii_m,
        target.corners,
        *eyes,
        asked,
        pixel_rays(lens),
        lens.fov_rad,
        lens.image_px,
        math.cos(lens.gaze_cone_rad),
    )


@compiled
def _near_lines(
    shapes: Shapes, counted: NDArray[np.bool_], eyes: Array, asked: NDArray[np.bool_], centers: Array, radii_m: Array
) -> NDArray[np.bool_]:
    """Counted shapes that come near to the box that holds the eyes asked and some balls, (ngeom,); planes do."""
    low, high = np.full(3, INF), np.full(3, -INF)
    for axis in range(3):
        for k in range(len(centers)):
            low[axis] = min(low[axis], centers[k, axis] - radii_m[k])
            high[axis] = max(high[axis], centers[k, axis] + radii_m[k])
        for i in range(len(eyes)):
            if asked[i]:
                low[axis], high[axis] = min(low[axis], eyes[i, axis]), max(high[axis], eyes[i, axis])
    near = np.zeros(len(counted), dtype=np.bool_)
    for shape in range(len(counted)):
        if not counted[shape]:
            continue
        b, m, squared = shapes.bounds[shape], shapes.matrices[shape], 0.0
        for axis in range(3):
            at = shapes.positions[shape, axis] + m[3 * axis] * b[0] + m[3 * axis + 1] * b[1] + m[3 * axis + 2] * b[2]
            outside = max(low[axis] - at, at - high[axis], 0.0)
            squared += outside * outside
        radius = b[3] * b[3] + b[4] * b[4] + b[5] * b[5]
        near[shape] = shapes.kinds[shape] == PLANE or squared <= radius
    return near


@compiled
def _off_gaze(eyes: Array, gazes: Array, centers: Array, radii_m: Array) -> Array:
    least = np.full(len(eyes), math.pi)
    for i in range(len(eyes)):
        for k in range(len(centers)):
            x, y, z = centers[k, 0] - eyes[i, 0], centers[k, 1] - eyes[i, 1], centers[k, 2] - eyes[i, 2]
            gx, gy, gz = gazes[i, 0], gazes[i, 1], gazes[i, 2]
            distance = math.sqrt(x * x + y * y + z * z)
            if distance <= radii_m[k]:
                least[i] = 0.0
                continue
            ahead = x * gx + y * gy + z * gz
            aside = math.sqrt((y * gz - z * gy) ** 2 + (z * gx - x * gz) ** 2 + (x * gy - y * gx) ** 2)
            least[i] = min(least[i], math.atan2(aside, ahead) - math.asin(radii_m[k] / distance))
    return least


@compiled
def _glimpsed(
    shapes: Shapes,
    counted: NDArray[np.bool_],
    wanted: Indices,
    centers: Array,
    radii_m: Array,
    corners: Array,
    eyes: Array,
    turned: Array,
    asked: NDArray[np.bool_],
    rays: Array,
    fov_rad: tuple[float, float],
    image_px: tuple[int, int],
    least_cosine: float,
) -> NDArray[np.bool_]:
    found = np.zeros(len(eyes), dtype=np.bool_)
    in_eye = np.empty_like(centers)
    ray = np.empty(3)
    for i in range(len(eyes)):
        if not asked[i]:
            continue
        frame = turned[i].copy().reshape(9)
        for k in range(len(centers)):
            in_eye[k, 0], in_eye[k, 1], in_eye[k, 2] = local(frame, centers[k] - eyes[i])
        others = stand_between(shapes, counted, -1, eyes[i], centers, radii_m)
        if _in_shadow(shapes, others, corners, eyes[i]):
            continue
        rows, columns = window(fov_rad, image_px, in_eye, radii_m)
        for pixel in range((rows[1] - rows[0]) * (columns[1] - columns[0])):
            row, column = divmod(pixel, columns[1] - columns[0])
            seen = rays[rows[0] + row, columns[0] + column]
            if seen[0] < least_cosine:
                continue
            for axis in range(3):
                ray[axis] = frame[3 * axis] * seen[0] + frame[3 * axis + 1] * seen[1] + frame[3 * axis + 2] * seen[2]
            if _shows(shapes, wanted, others, eyes[i], ray):
                found[i] = True
                break
    return found


@compiled
def _in_shadow(shapes: Shapes, others: Indices, corners: Array, eye: Array) -> bool:
    """Whether one box alone hides all that lies between some corners.

    The shadow that a convex thing throws from an eye outside of it is convex, too.
    """
    for shape in others:
        if shapes.kinds[shape] != BOX:
            continue
        m, size = shapes.matrices[shape], shapes.sizes[shape]
        sx, sy, sz = size[0] - GRAZE_M, size[1] - GRAZE_M, size[2] - GRAZE_M
        x, y, z = local(m, eye - shapes.positions[shape])
        hides = abs(x) > sx or abs(y) > sy or abs(z) > sz
        for k in range(len(corners)):
            if not hides:
                break
            dx, dy, dz = local(m, corners[k] - eye)
            hides = box(sx, sy, sz, x, y, z, dx, dy, dz) <= 1.0
        if hides:
            return True
    return False


@compiled
def _shows(shapes: Shapes, wanted: Indices, others: Indices, eye: Array, ray: Array) -> bool:
    """Whether a ray meets a wanted shape, or the box around it, and none of the others before."""
    nearest = INF
    for shape in wanted:
        nearest = min(nearest, distance_m(shapes, shape, eye, ray, True))
    if nearest == INF:
        return False
    for place in range(len(others)):
        if distance_m(shapes, others[place], eye, ray, False) < nearest - GRAZE_M:
            others[0], others[place] = others[place], others[0]  # it mostly hides the next pixel as well
            return False
    return True


@compiled
def distance_m(shapes: Shapes, shape: int, eye: Array, ray: Array, boxed: bool) -> float:
    """How far along a ray a shape is; what has no formula counts as its box, or not at all."""
    matrix, size = shapes.matrices[shape], shapes.sizes[shape]
    px, py, pz = local(matrix, eye - shapes.positions[shape])
    dx, dy, dz = local(matrix, ray)
    if shapes.formless[shape]:
        if not boxed:
            return INF
        b = shapes.bounds[shape]
        inside = abs(px - b[0]) <= b[3] and abs(py - b[1]) <= b[4] and abs(pz - b[2]) <= b[5]
        return 0.0 if inside else box(b[3], b[4], b[5], px - b[0], py - b[1], pz - b[2], dx, dy, dz)
    return surface(shapes.kinds[shape], size[0], size[1], size[2], px, py, pz, dx, dy, dz)
