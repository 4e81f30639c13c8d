"""What many eyes see of an object, told roughly and quickly: never too little. Compiled.

The agent's own body is looked past, meshes hide nothing, and a mesh that is looked at fills the box around it. So
whoever does not even glimpse an object surely does not see it; whether the others do is for ``visibility`` to tell.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled
from taskgist.perspective.candidates import EYE, Neck, Table, carry
from taskgist.perspective.gaze import TURN_COLUMNS, aim, off_gaze
from taskgist.perspective.image import Lens, window
from taskgist.perspective.occlusion import GRAZE_M, away_m, from_eye, in_shadow
from taskgist.perspective.target import Sought
from taskgist.world.geometry.linkage import POSE
from taskgist.world.geometry.rays import INF, NO_GEOM, Shapes, stand_between

HIDDEN, BESIDE = 0, 1
"""Why an object is not glimpsed from a stance: something hides it, or the head cannot turn to it."""
MARGIN_RAD = 1e-6
"""How much farther than its cone the gaze counts as hopeful."""


@compiled
def first_glimpse(
    table: Table,
    neck: Neck,
    shapes: Shapes,
    others: Indices,
    sought: Sought,
    lens: Lens,
    start: int,
    stop: int,
    missed: Indices,
    off_rad: Array,
    eyes: Array,
) -> int:
    """The first of some stances from which the aimed head may see an object in its gaze cone; ``stop`` if none.

    Args:
        table: The stances.
        neck: The head's joints that may be used.
        shapes: All shapes; where the agent's are does not matter.
        others: Indices of those that may hide something: neither the agent's nor the object's.
        sought: The object.
        lens: Of the agent's eye.
        start: From which stance on,
        stop: and before which.
        missed: Kept up to date: of the stances passed over, the one from which the gaze comes nearest to the object's
            middle, among those whose head turns to the object (``HIDDEN``) and among the others (``BESIDE``), (2,).
        off_rad: Kept up to date: the angle between the two then, (2,).
        eyes: Lowest and highest corner of a box that is made to hold all eyes that look at the object, (2, 3).
    """
    frames, eye = np.empty((EYE + 1 + table.joints, POSE)), np.empty(POSE)
    joints, inwards, now, ranges = neck
    turns = np.empty((len(now), TURN_COLUMNS))
    hider = np.full(1, NO_GEOM, dtype=np.intp)
    for i in range(start, stop):
        for frame in range(len(frames)):
            carry(table, i, frame, frames[frame])
        aim(frames, joints, inwards, now, ranges, sought.middle, turns, eye)
        kind = BESIDE if _nearest_rad(eye, sought) > lens.cone_rad + MARGIN_RAD else HIDDEN
        if kind == HIDDEN:
            for axis in range(3):
                eyes[0, axis], eyes[1, axis] = min(eyes[0, axis], eye[axis]), max(eyes[1, axis], eye[axis])
            # what hides it from one eye mostly hides it from the next as well
            if hider[0] == NO_GEOM or in_shadow(from_eye(shapes, hider, eye, False), sought.corners, eye) == NO_GEOM:
                glimpsed, hider[0] = _glimpsed(shapes, others, sought, lens, eye)
                if glimpsed:
                    return i
        off = off_gaze(eye, sought.middle, 0.0)
        if off < off_rad[kind]:
            missed[kind], off_rad[kind] = i, off
    return stop


@compiled
def next_glimpse(shapes: Shapes, others: Indices, sought: Sought, lens: Lens, eyes: Array, start: int) -> int:
    """The first of some eyes, poses (n, 12), from ``start`` on, that glimpses the object; n if none does."""
    for i in range(start, len(eyes)):
        if _glimpsed(shapes, others, sought, lens, eyes[i])[0]:
            return i
    return len(eyes)


@compiled
def _glimpsed(shapes: Shapes, others: Indices, sought: Sought, lens: Lens, eye: Array) -> tuple[bool, int]:
    """Whether an eye, pose (12,), may see an object in its gaze cone; if not, a shape that alone hides it, or −1."""
    between = stand_between(shapes, others, -1, eye[:3], sought.centers, sought.radii_m)
    hiders = from_eye(shapes, between, eye, False)
    hider = in_shadow(hiders, sought.corners, eye)
    if hider != NO_GEOM:
        return False, hider
    return _shows(from_eye(shapes, sought.shapes, eye, True), hiders, sought, lens, eye), NO_GEOM


@compiled
def _nearest_rad(eye: Array, sought: Sought) -> float:
    """Angle between the gaze and the nearest of an object's balls."""
    least, centers = math.pi, sought.centers
    for k in range(len(centers)):
        least = min(least, off_gaze(eye, centers[k], sought.radii_m[k]))
    return least


@compiled
def _shows(wanted: Array, others: Array, sought: Sought, lens: Lens, eye: Array) -> bool:
    """Whether the ray of some pixel meets a wanted shape, and none of the others before."""
    hider, rays, frame = 0, lens.rays, eye[3:]
    first_row, last_row, first_column, last_column = window(lens, eye, sought.centers, sought.radii_m)
    for row in range(first_row, last_row):
        for column in range(first_column, last_column):
            x, y, z = rays[row, column, 0], rays[row, column, 1], rays[row, column, 2]
            if x < lens.cone_cos:
                continue
            dx = frame[0] * x + frame[1] * y + frame[2] * z
            dy = frame[3] * x + frame[4] * y + frame[5] * z
            dz = frame[6] * x + frame[7] * y + frame[8] * z
            nearest = INF
            for k in range(len(wanted)):
                nearest = min(nearest, away_m(wanted, k, dx, dy, dz))
            if nearest == INF:
                continue
            if hider < len(others) and away_m(others, hider, dx, dy, dz) < nearest - GRAZE_M:
                continue  # what hid one pixel mostly hides the next as well
            hider = 0
            while hider < len(others) and away_m(others, hider, dx, dy, dz) >= nearest - GRAZE_M:
                hider += 1
            if hider == len(others):
                return True
    return False
