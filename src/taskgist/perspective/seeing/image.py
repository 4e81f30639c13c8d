"""An agent's whole field of view as a pinhole image: what each pixel shows (5.1.1).

The eye looks along its x axis, z up. Pixels are squares on a plane at distance one: row 0 is the top, column 0 the
left, and a ray goes through each pixel's centre. The body that the eye sits in is looked through; the agent's own
hands and chest are seen and occlude like anything.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

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


def rays_towards(eye: Eye, centers_in_eye: Array, radii_m: Array, cone_rad: float = math.inf) -> Array:
    """Rays through all the pixels that might show what lies in some spheres.

    Args:
        eye: Field of view and size of the image.
        centers_in_eye: Centres of the spheres in the eye's frame, metres, (n, 3).
        radii_m: Their radii, (n,).
        cone_rad: Half-angle of a cone about the gaze; no pixel outside of it.

    Returns:
        Unit directions in the eye's frame, (k, 3), row by row.
    """
    rows, columns = window(eye.fov_rad, eye.image_px, centers_in_eye, radii_m)
    least = math.cos(cone_rad) if cone_rad < math.pi else -1.0
    return _within(pixel_rays(eye), rows, columns, least)


@compiled
def _within(rays: Array, rows: tuple[int, int], columns: tuple[int, int], least_cosine: float) -> Array:
    """The rays of a window that are near enough to the gaze, (k, 3)."""
    found = np.empty(((rows[1] - rows[0]) * (columns[1] - columns[0]), 3))
    count = 0
    for row in range(rows[0], rows[1]):
        for column in range(columns[0], columns[1]):
            if rays[row, column, 0] >= least_cosine:
                found[count] = rays[row, column]
                count += 1
    return found[:count]


@compiled
def window(
    fov_rad: tuple[float, float], image_px: tuple[int, int], centers_in_eye: Array, radii_m: Array
) -> tuple[tuple[int, int], tuple[int, int]]:
    """The part of an image that holds everything inside some spheres: first and last-but-one of rows and columns.

    Seen from above (or from the side), the tangents from the eye to a sphere enclose its bounding cone, so the pixels
    of the cone lie between the two columns (rows) that the tangents meet.
    """
    columns = _span(centers_in_eye[:, 0], centers_in_eye[:, 1], radii_m, fov_rad[0], image_px[0])
    rows = _span(centers_in_eye[:, 0], centers_in_eye[:, 2], radii_m, fov_rad[1], image_px[1])
    return rows, columns


@compiled
def _span(ahead: Array, aside: Array, radii_m: Array, fov_rad: float, pixels: int) -> tuple[int, int]:
    """Pixels between the outermost tangents, the last not included; ``aside`` grows towards pixel 0."""
    lowest, highest = fov_rad / 2, -fov_rad / 2
    for x, y, radius in zip(ahead, aside, radii_m):  # noqa: B905 - numba knows no strict
        middle, distance = math.atan2(y, x), math.hypot(x, y)
        half = math.asin(radius / distance) if radius < distance else 2 * math.pi  # the eye is inside: all round
        if middle + half > -fov_rad / 2 and middle - half < fov_rad / 2:
            lowest, highest = min(lowest, middle - half), max(highest, middle + half)
    if lowest > highest:
        return 0, 0
    first = _pixel(min(highest, fov_rad / 2), fov_rad, pixels)
    last = _pixel(max(lowest, -fov_rad / 2), fov_rad, pixels)
    return max(0, math.ceil(first - EDGE_PX)), min(pixels, math.floor(last + EDGE_PX) + 1)


@compiled
def _pixel(angle_rad: float, fov_rad: float, pixels: int) -> float:
    """Where a direction meets the row of pixel centres."""
    return (1 - math.tan(angle_rad) / math.tan(fov_rad / 2)) * pixels / 2 - 0.5
