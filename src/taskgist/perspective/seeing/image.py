"""An agent's whole field of view as a pinhole image: what each pixel shows (5.1.1).

The eye looks along its x axis, z up. Pixels are squares on a plane at distance one: row 0 is the top, column 0 the
left, and a ray goes through each pixel's centre. The body that the eye sits in is looked through; the agent's own
hands and chest are seen and occlude like anything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Eye, Stage
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
EDGE_PX = 1e-6
"""Margin of a window, so that rounding never loses a pixel."""


@dataclass(frozen=True, eq=False)
class View:
    """What an agent sees: one entry per pixel of its field of view.

    Attributes:
        geoms: Index of the shape in each pixel, −1 for none, (height, width).
        distances_m: Distance from the eye, −1 for none, (height, width).
        owners: What each shape belongs to, by its index.
    """

    geoms: NDArray[np.int32]
    distances_m: Array
    owners: tuple[str, ...]

    def pixels(self) -> dict[str | None, int]:
        """Number of pixels of each owner that is seen; None stands for nothing. They sum to the image."""
        counts: dict[str | None, int] = {}
        for geom, count in zip(*np.unique(self.geoms, return_counts=True), strict=True):
            owner = self.owners[geom] if geom >= 0 else None
            counts[owner] = counts.get(owner, 0) + int(count)
        return counts


def view_of(stage: Stage, agent: str) -> View:
    """Cast one ray through every pixel of an agent's field of view.

    Args:
        stage: The scene in a state.
        agent: Whose eye.

    Raises:
        UnknownNameError: There is no such agent.
    """
    body = stage.scene.agent(agent)
    eye = stage.eye(body)
    rays = pixel_rays(body.profile.eye)
    geoms, distances_m = stage.cast(
        eye.position, rays.reshape(-1, 3) @ eye.matrix.T, exclude_body=body.eye_exclude_body
    )
    return View(geoms.reshape(rays.shape[:2]), distances_m.reshape(rays.shape[:2]), stage.scene.owners)


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
        image_px: Width and height of the image.
        cone_rad: Half-angle of the gaze cone.
        cone_cos: Its cosine.
    """

    rays: Array
    fov_rad: tuple[float, float]
    image_px: tuple[int, int]
    cone_rad: float
    cone_cos: float


@lru_cache(maxsize=32)
def lens_of(eye: Eye) -> Lens:
    """The lens of a profile's eye."""
    cone_rad = eye.gaze_cone_rad
    return Lens(pixel_rays(eye), eye.fov_rad, eye.image_px, cone_rad, math.cos(cone_rad))


@compiled
def window(lens: Lens, eye: Array, centers: Array, radii_m: Array) -> tuple[int, int, int, int]:
    """The part of an image that holds everything inside some spheres.

    Seen from above (or from the side), the tangents from the eye to a sphere enclose its bounding cone, so the pixels
    of the cone lie between the two columns (rows) that the tangents meet.

    Args:
        lens: Field of view and size of the image.
        eye: Pose, (12,).
        centers: Centres of the spheres, metres, (n, 3).
        radii_m: Their radii, (n,).

    Returns:
        First row, and the first one after the last; first column, and the first one after the last.
    """
    across, up = lens.fov_rad[0] / 2, lens.fov_rad[1] / 2
    left, right, top, bottom = -across, across, -up, up  # angles; they grow towards pixel 0
    for k in range(len(radii_m)):
        dx, dy, dz = centers[k, 0] - eye[0], centers[k, 1] - eye[1], centers[k, 2] - eye[2]
        x = dx * eye[3] + dy * eye[6] + dz * eye[9]
        y = dx * eye[4] + dy * eye[7] + dz * eye[10]
        z = dx * eye[5] + dy * eye[8] + dz * eye[11]
        right, left = _widened(right, left, x, y, radii_m[k], across)
        bottom, top = _widened(bottom, top, x, z, radii_m[k], up)
    first_column, last_column = _span(right, left, across, lens.image_px[0])
    first_row, last_row = _span(bottom, top, up, lens.image_px[1])
    return first_row, last_row, first_column, last_column


@compiled
def _widened(
    low: float, high: float, ahead: float, aside: float, radius_m: float, half_rad: float
) -> tuple[float, float]:
    """Lowest and highest angle, with those of the tangents to a sphere that lies in the field of view."""
    middle, distance = math.atan2(aside, ahead), math.hypot(ahead, aside)
    half = math.asin(radius_m / distance) if radius_m < distance else 2 * math.pi  # the eye is inside: all round
    if middle + half > -half_rad and middle - half < half_rad:
        return min(low, middle - half), max(high, middle + half)
    return low, high


@compiled
def _span(low: float, high: float, half_rad: float, pixels: int) -> tuple[int, int]:
    """Pixels between two angles, the last not included."""
    if low > high:
        return 0, 0
    first = _pixel(min(high, half_rad), half_rad, pixels)
    last = _pixel(max(low, -half_rad), half_rad, pixels)
    return max(0, math.ceil(first - EDGE_PX)), min(pixels, math.floor(last + EDGE_PX) + 1)


@compiled
def _pixel(angle_rad: float, half_rad: float, pixels: int) -> float:
    """Where a direction meets the row of pixel centres."""
    return (1 - math.tan(angle_rad) / math.tan(half_rad)) * pixels / 2 - 0.5
