"""What many eyes see of an object, told roughly and quickly: never too little.

The agent's own body is looked past, meshes hide nothing, and a mesh that is looked at fills the box around it. So
whoever does not even glimpse an object surely does not see it; whether the others do is for ``visibility`` to tell.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.seeing.image import pixel_rays, window
from taskgist.perspective.target import Target
from taskgist.world import Agent, Shapes, Stage
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.raycast import BOX, INF, box, local, surface
from taskgist.world.geometry.rays import stand_between

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
) -> Indices:
    """Counted shapes that come near to the box that holds the eyes asked and some balls, (n,); planes do."""
    low, high = np.full(3, INF), np.full(3, -INF)
    for axis in range(3):
        for k in range(len(centers)):
            low[axis] = min(low[axis], centers[k, axis] - radii_m[k])
            high[axis] = max(high[axis], centers[k, axis] + radii_m[k])
        for i in range(len(eyes)):
            if asked[i]:
                low[axis], high[axis] = min(low[axis], eyes[i, axis]), max(high[axis], eyes[i, axis])
    near, count = np.empty(len(counted), dtype=np.intp), 0
    for shape in range(len(counted)):
        if not counted[shape]:
            continue
        squared = 0.0
        for axis in range(3):
            at = shapes.positions[shape, axis]
            outside = max(low[axis] - at, at - high[axis], 0.0)
            squared += outside * outside
        if squared <= shapes.radii[shape] ** 2:
            near[count] = shape
            count += 1
    return near[:count]


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
    near: Indices,
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
    for i in range(len(eyes)):
        if not asked[i]:
            continue
        frame = turned[i].copy().reshape(9)
        others = _rows(shapes, stand_between(shapes, near, -1, eyes[i], centers, radii_m), eyes[i], False)
        if _in_shadow(others, corners, eyes[i]):
            continue
        for k in range(len(centers)):
            in_eye[k, 0], in_eye[k, 1], in_eye[k, 2] = local(frame, centers[k] - eyes[i])
        rows, columns = window(fov_rad, image_px, in_eye, radii_m)
        found[i] = _shows(_rows(shapes, wanted, eyes[i], True), others, frame, rays, rows, columns, least_cosine)
    return found


HERE = -1.0
"""Type of what stands for a mesh around the eye."""
KIND, SIZE, START, MATRIX, COLUMNS = 0, 1, 4, 7, 16
"""Columns of a table of shapes seen from one eye: type; half sizes; the eye in the shape's frame; rotation, row by row.
One array, as compiled functions pass it on for nothing."""


@compiled
def _rows(shapes: Shapes, which: Indices, eye: Array, boxed: bool) -> Array:
    """Shapes seen from an eye, (k, COLUMNS); what has no formula counts as its box, or not at all."""
    rows, count = np.empty((len(which), COLUMNS)), 0
    for shape in which:
        if shapes.formless[shape] and not boxed:
            continue
        matrix, bounds = shapes.matrices[shape], shapes.bounds[shape]
        start = local(matrix, eye - shapes.positions[shape])
        for axis in range(3):
            rows[count, SIZE + axis] = bounds[3 + axis] if shapes.formless[shape] else shapes.sizes[shape, axis]
            rows[count, START + axis] = start[axis] - (bounds[axis] if shapes.formless[shape] else 0.0)
        rows[count, KIND] = BOX if shapes.formless[shape] else shapes.kinds[shape]
        if shapes.formless[shape] and _inside(rows, count):
            rows[count, KIND] = HERE
        rows[count, MATRIX:] = matrix
        count += 1
    return rows[:count]


@compiled
def _inside(rows: Array, k: int) -> bool:
    """Whether the eye is inside of a shape's box."""
    x, y, z = abs(rows[k, START]), abs(rows[k, START + 1]), abs(rows[k, START + 2])
    return bool(x <= rows[k, SIZE] and y <= rows[k, SIZE + 1] and z <= rows[k, SIZE + 2])


@compiled
def _in_shadow(others: Array, corners: Array, eye: Array) -> bool:
    """Whether one box alone hides all that lies between some corners.

    The shadow that a convex thing throws from an eye outside of it is convex, too.
    """
    for k in range(len(others)):
        x, y, z = others[k, START], others[k, START + 1], others[k, START + 2]
        sx, sy, sz = others[k, SIZE] - GRAZE_M, others[k, SIZE + 1] - GRAZE_M, others[k, SIZE + 2] - GRAZE_M
        hides = others[k, KIND] == BOX and (abs(x) > sx or abs(y) > sy or abs(z) > sz)
        for c in range(len(corners)):
            if not hides:
                break
            dx, dy, dz = _turned(others, k, corners[c, 0] - eye[0], corners[c, 1] - eye[1], corners[c, 2] - eye[2])
            hides = box(sx, sy, sz, x, y, z, dx, dy, dz) <= 1.0
        if hides:
            return True
    return False


@compiled
def _shows(
    wanted: Array,
    others: Array,
    frame: Array,
    rays: Array,
    rows: tuple[int, int],
    columns: tuple[int, int],
    least_cosine: float,
) -> bool:
    """Whether the ray of some pixel meets a wanted shape, and none of the others before."""
    hider = 0
    for row in range(rows[0], rows[1]):
        for column in range(columns[0], columns[1]):
            x, y, z = rays[row, column, 0], rays[row, column, 1], rays[row, column, 2]
            if x < least_cosine:
                continue
            dx = frame[0] * x + frame[1] * y + frame[2] * z
            dy = frame[3] * x + frame[4] * y + frame[5] * z
            dz = frame[6] * x + frame[7] * y + frame[8] * z
            nearest = INF
            for k in range(len(wanted)):
                nearest = min(nearest, _distance_m(wanted, k, dx, dy, dz))
            if nearest == INF:
                continue
            if hider < len(others) and _distance_m(others, hider, dx, dy, dz) < nearest - GRAZE_M:
                continue  # what hid one pixel mostly hides the next as well
            hider = 0
            while hider < len(others) and _distance_m(others, hider, dx, dy, dz) >= nearest - GRAZE_M:
                hider += 1
            if hider == len(others):
                return True
    return False


@compiled
def _turned(rows: Array, k: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A direction of the world in the frame of a shape."""
    return (
        x * rows[k, MATRIX] + y * rows[k, MATRIX + 3] + z * rows[k, MATRIX + 6],
        x * rows[k, MATRIX + 1] + y * rows[k, MATRIX + 4] + z * rows[k, MATRIX + 7],
        x * rows[k, MATRIX + 2] + y * rows[k, MATRIX + 5] + z * rows[k, MATRIX + 8],
    )


@compiled
def _distance_m(rows: Array, k: int, x: float, y: float, z: float) -> float:
    """How far along a direction from the eye a shape is."""
    if rows[k, KIND] == HERE:
        return 0.0
    dx, dy, dz = _turned(rows, k, x, y, z)
    px, py, pz = rows[k, START], rows[k, START + 1], rows[k, START + 2]
    return surface(int(rows[k, KIND]), rows[k, SIZE], rows[k, SIZE + 1], rows[k, SIZE + 2], px, py, pz, dx, dy, dz)
