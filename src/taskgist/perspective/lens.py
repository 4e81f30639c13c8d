"""An eye as a pinhole: its pixels, the part of an image that may show an object, and finer pixels for what is small.

A person's image of 320 × 240 pixels is coarse: one of them is as wide as a pencil at arm's length, and a key three
metres away has a third of one. Whether some pixel's centre falls onto it would be luck. So where an object, with
nothing in the way, has few pixels, they are halved in both directions, again and again, until enough rays cover it::

    halvings   rays in a pixel   pixels that each ray stands for
    0          1, in its middle  1
    1          4                 1/4
    k          4^k               1/4^k

A finer pixel's ray does not go through its middle but through a point that differs from row to row and from column to
column by an irrational step: else an edge along the rows would gain or lose a whole row at once. Where it goes depends
on nothing but the pixel, so the same scene gives the same answer, and each point of the image counts alike: what is
measured is as often too large as too small. Left and right are mirrored. Compiled.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.bodies.eyes import Eye

LEAST_RAYS = 128
"""Pixels are halved until so many cover the boxes around an object's shapes: areas are then right within about 2 %
(standard deviation, tests/perspective/test_small_things.py)."""
MOST_RAYS = 4096
"""But no more often than so many rays allow in its window."""
MOST_HALVINGS = 16
EDGE_PX = 1e-6
"""Margin of a window, so that rounding never loses a pixel."""
STEPS = (0.7548776662466927, 0.5698402909980532)
"""Irrational steps, row to row and column to column, that spread points evenly over a square (Roberts 2018)."""
CORNERS = 8
"""Corners of the box around a shape."""
LEAST_COSINE = 0.2
"""Farther aside, an image no longer grows: what is there is hardly in any image."""


@lru_cache(maxsize=32)
def pixel_rays(eye: Eye) -> Array:
    """Unit directions through the pixels' centres in the eye's frame, (height, width, 3), read-only."""
    width, height = eye.image_px
    across, up = (math.tan(angle / 2) for angle in eye.fov_rad)
    y = across * (1 - 2 * (np.arange(width) + 0.5) / width)
    z = up * (1 - 2 * (np.arange(height) + 0.5) / height)
    rays = np.ones((height, width, 3))
    rays[..., 1], rays[..., 2] = np.meshgrid(y, z)
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    rays.flags.writeable = False
    return rays


class Lens(NamedTuple):
    """An eye as compiled functions take it.

    Attributes:
        rays: Unit directions through the pixels' centres in the eye's frame, (height, width, 3).
        fov_rad: Field of view, across and up.
        half_tan: Tangents of half of it.
        image_px: Width and height of the image.
        cone_rad: Half-angle of the gaze cone.
        cone_cos: Its cosine.
        pixel_sr: Solid angle of a pixel in the image's middle, steradians.
    """

    rays: Array
    fov_rad: tuple[float, float]
    half_tan: tuple[float, float]
    image_px: tuple[int, int]
    cone_rad: float
    cone_cos: float
    pixel_sr: float


@lru_cache(maxsize=32)
def lens_of(eye: Eye) -> Lens:
    """The lens of a profile's eye."""
    across, up = eye.fov_rad
    half_tan, cone_rad = (math.tan(across / 2), math.tan(up / 2)), eye.gaze_cone_rad
    pixel_sr = 4 * half_tan[0] * half_tan[1] / (eye.image_px[0] * eye.image_px[1])
    return Lens(pixel_rays(eye), eye.fov_rad, half_tan, eye.image_px, cone_rad, math.cos(cone_rad), pixel_sr)


@compiled_part
def in_view(eye: Array, point: Array, cone_cos: float, across_tan: float, up_tan: float) -> bool:
    """Whether a point, metres, (3,), lies in the gaze cone and in the image of an eye, pose (12,).

    Args:
        eye: The eye.
        point: The point.
        cone_cos: Cosine of the gaze cone's half-angle.
        across_tan: Tangent of half the field of view across,
        up_tan: and of half of it up.
    """
    dx, dy, dz = point[0] - eye[0], point[1] - eye[1], point[2] - eye[2]
    ahead = dx * eye[3] + dy * eye[6] + dz * eye[9]
    left = dx * eye[4] + dy * eye[7] + dz * eye[10]
    up = dx * eye[5] + dy * eye[8] + dz * eye[11]
    inside = abs(left) <= across_tan * ahead and abs(up) <= up_tan * ahead
    return bool(inside and ahead > 0.0 and ahead >= cone_cos * math.sqrt(dx * dx + dy * dy + dz * dz))


@compiled
def raster(lens: Lens, eye: Array, centers: Array, radii_m: Array, corners: Array) -> tuple[int, int, int, int, int]:
    """How often an image's pixels are halved for an object, and which of the pixels may show it.

    Args:
        lens: Field of view and size of the image.
        eye: Pose, (12,).
        centers: Centres of balls about the object's shapes, metres, (n, 3).
        radii_m: Their radii, (n,).
        corners: Corners of the boxes around the shapes, metres, (8 n, 3).

    Returns:
        Halvings; the first row, and the first one after the last; the first column, and the first one after the last.
    """
    right, left, bottom, top = _outline(lens, eye, centers, radii_m, corners)
    rays, halvings = _box_px(lens, eye, corners), 0
    first_row, last_row, first_column, last_column = _pixels(lens, 0, right, left, bottom, top)
    while rays < LEAST_RAYS and halvings < MOST_HALVINGS:
        finer = _pixels(lens, halvings + 1, right, left, bottom, top)
        if (finer[1] - finer[0]) * (finer[3] - finer[2]) > MOST_RAYS:
            break
        first_row, last_row, first_column, last_column = finer
        rays, halvings = 4 * rays, halvings + 1
    return halvings, first_row, last_row, first_column, last_column


@compiled_part
def ray_through(lens: Lens, halvings: int, row: int, column: int) -> tuple[float, float, float]:
    """The unit direction, in the eye's frame, of the ray through a pixel of an image halved so often."""
    if halvings == 0:
        return lens.rays[row, column, 0], lens.rays[row, column, 1], lens.rays[row, column, 2]
    half_width, height = (lens.image_px[0] << halvings) / 2, lens.image_px[1] << halvings
    side, aside = 1.0, half_width - 1.0 - column  # whole columns between the image's middle and the pixel
    if aside < 0.0:
        side, aside = -1.0, -1.0 - aside
    y = side * lens.half_tan[0] * (aside + _fraction(row * STEPS[0])) / half_width
    z = lens.half_tan[1] * (1.0 - 2.0 * (row + _fraction(aside * STEPS[1])) / height)
    length = math.sqrt(1.0 + y * y + z * z)
    return 1.0 / length, y / length, z / length


@compiled_part
def _fraction(number: float) -> float:
    return number - math.floor(number)


@compiled_part
def _outline(
    lens: Lens, eye: Array, centers: Array, radii_m: Array, corners: Array
) -> tuple[float, float, float, float]:
    """The part of the image's plane, one ahead of the eye, that holds an object: right, left, bottom and top of it.

    A shape lies in its ball. Seen from above (or from the side), the tangents from the eye to the ball enclose its
    bounding cone. It lies in its box, too, whose outline is that of its corners if all of them are ahead.
    """
    right, left, bottom, top = math.inf, -math.inf, math.inf, -math.inf
    for k in range(len(radii_m)):
        x, y, z = _in_eye(eye, centers, k)
        low_y, high_y = _tangents(x, y, radii_m[k], lens.fov_rad[0] / 2)
        low_z, high_z = _tangents(x, z, radii_m[k], lens.fov_rad[1] / 2)
        right_y, left_y, bottom_z, top_z = math.inf, -math.inf, math.inf, -math.inf
        for corner in range(CORNERS * k, CORNERS * (k + 1)):
            x, y, z = _in_eye(eye, corners, corner)
            if x <= 0.0:
                right_y, left_y, bottom_z, top_z = -math.inf, math.inf, -math.inf, math.inf
                break
            right_y, left_y = min(right_y, y / x), max(left_y, y / x)
            bottom_z, top_z = min(bottom_z, z / x), max(top_z, z / x)
        low_y, high_y = max(low_y, right_y), min(high_y, left_y)
        low_z, high_z = max(low_z, bottom_z), min(high_z, top_z)
        if low_y <= high_y and low_z <= high_z:
            right, left, bottom, top = min(right, low_y), max(left, high_y), min(bottom, low_z), max(top, high_z)
    return right, left, bottom, top


@compiled_part
def _in_eye(eye: Array, points: Array, k: int) -> tuple[float, float, float]:
    """One of some points in the frame of an eye, pose (12,)."""
    dx, dy, dz = points[k, 0] - eye[0], points[k, 1] - eye[1], points[k, 2] - eye[2]
    return (
        dx * eye[3] + dy * eye[6] + dz * eye[9],
        dx * eye[4] + dy * eye[7] + dz * eye[10],
        dx * eye[5] + dy * eye[8] + dz * eye[11],
    )


@compiled_part
def _tangents(ahead: float, aside: float, radius_m: float, half_rad: float) -> tuple[float, float]:
    """Tangents of the least and the greatest angle at which a ball is in view; the first is greater if it is not."""
    middle, distance = math.atan2(aside, ahead), math.hypot(ahead, aside)
    half = math.asin(radius_m / distance) if radius_m < distance else 2 * math.pi  # the eye is inside: all round
    low, high = max(middle - half, -half_rad), min(middle + half, half_rad)
    return (math.tan(low), math.tan(high)) if low <= high else (1.0, -1.0)


@compiled_part
def _pixels(
    lens: Lens, halvings: int, right: float, left: float, bottom: float, top: float
) -> tuple[int, int, int, int]:
    """Rows and columns of an image halved so often that a part of its plane touches, the last ones not included."""
    if right > left:
        return 0, 0, 0, 0
    columns, rows = lens.image_px[0] << halvings, lens.image_px[1] << halvings
    first_column, last_column = _span(right, left, lens.half_tan[0], columns)
    first_row, last_row = _span(bottom, top, lens.half_tan[1], rows)
    return first_row, last_row, first_column, last_column


@compiled_part
def _span(low: float, high: float, half_tan: float, pixels: int) -> tuple[int, int]:
    """The first pixel between two tangents, which grow towards pixel 0, and the first one after the last."""
    first, last = (1.0 - high / half_tan) * pixels / 2, (1.0 - low / half_tan) * pixels / 2
    return max(0, math.floor(first - EDGE_PX)), min(pixels, math.floor(last + EDGE_PX) + 1)


@compiled_part
def _box_px(lens: Lens, eye: Array, corners: Array) -> float:
    """Pixels that the boxes around some shapes would cover in an image, roughly: as if all of a box were equally far.

    Of a box, the eye sees as much as of its three faces that meet in a corner.
    """
    pixels = 0.0
    for k in range(0, len(corners), CORNERS):
        x, y, z = (
            (corners[k, 0] + corners[k + 7, 0]) / 2 - eye[0],
            (corners[k, 1] + corners[k + 7, 1]) / 2 - eye[1],
            (corners[k, 2] + corners[k + 7, 2]) / 2 - eye[2],
        )
        area = _facing(corners, k, 1, 2, x, y, z) + _facing(corners, k, 2, 4, x, y, z)
        area += _facing(corners, k, 4, 1, x, y, z)
        distance = math.sqrt(x * x + y * y + z * z)
        cosine = max((x * eye[3] + y * eye[6] + z * eye[9]) / distance, LEAST_COSINE)
        pixels += area / (distance * cosine) ** 3 / lens.pixel_sr
    return pixels


@compiled_part
def _facing(corners: Array, k: int, one: int, other: int, x: float, y: float, z: float) -> float:
    """Area of the face between two edges from a box's first corner, as seen along (x, y, z), times its length."""
    ax, ay, az = _edge(corners, k, one)
    bx, by, bz = _edge(corners, k, other)
    return abs((ay * bz - az * by) * x + (az * bx - ax * bz) * y + (ax * by - ay * bx) * z)


@compiled_part
def _edge(corners: Array, k: int, to: int) -> tuple[float, float, float]:
    return corners[k + to, 0] - corners[k, 0], corners[k + to, 1] - corners[k, 1], corners[k + to, 2] - corners[k, 2]
