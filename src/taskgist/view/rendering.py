"""Rendering by ray casting: colour images of a state from any pinhole, without display or graphics card."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array
from taskgist.common.files import writing
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

LIGHT = np.array([0.3, 0.25, 0.9]) / math.sqrt(0.3**2 + 0.25**2 + 0.9**2)
SKY, FLOOR = np.array([0.93, 0.95, 0.97]), np.array([0.78, 0.77, 0.74])
TILE_M = 0.5


@dataclass(frozen=True, eq=False)
class Rendered:
    """A rendered image.

    Attributes:
        rgb: Colours from 0 to 1, (height, width, 3).
        geoms: Index of the shape in each pixel, −1 for none, (height, width).
    """

    rgb: Array
    geoms: NDArray[np.int32]


def pinhole(fov_rad: tuple[float, float], width_px: int, height_px: int) -> Array:
    """Unit directions of the pixels' centres, (height, width, 3), in a frame that looks along x with z up.

    Args:
        fov_rad: Horizontal and vertical field of view.
        width_px: Pixels across.
        height_px: Pixels down.
    """
    right = math.tan(fov_rad[0] / 2) * (2 * (np.arange(width_px) + 0.5) / width_px - 1)
    down = math.tan(fov_rad[1] / 2) * (2 * (np.arange(height_px) + 0.5) / height_px - 1)
    y, z = np.meshgrid(-right, -down)
    rays = np.stack((np.ones_like(y), y, z), axis=-1)
    return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))


def render(
    stage: Stage,
    camera: Pose,
    directions: Array,
    *,
    exclude_body: int = -1,
    only: ArrayLike | None = None,
    highlight: Collection[int] = (),
) -> Rendered:
    """Render what the stage shows.

    Args:
        stage: The scene in a state.
        camera: Looks along its x axis, z up.
        directions: Unit directions of the pixels in the camera's frame, (height, width, 3).
        exclude_body: A body to look through (the head that the eye sits in), or −1.
        only: The only shapes that are there, where given.
        highlight: Shapes to paint in the colour of attention.
    """
    height, width = directions.shape[:2]
    rays = directions.reshape(-1, 3) @ camera.matrix.T
    normals = np.zeros_like(rays)
    geoms, distances = stage.cast(camera.position, rays, exclude_body=exclude_body, only=only, normals=normals)
    points = camera.position + rays * distances[:, None]
    colours = _colours(stage, geoms, points, highlight)
    lit = 0.55 + 0.45 * np.clip(normals @ LIGHT, 0.0, 1.0)
    rgb = np.where((geoms >= 0)[:, None], colours * lit[:, None], SKY)
    return Rendered(rgb.reshape(height, width, 3), geoms.reshape(height, width))


def _colours(stage: Stage, geoms: NDArray[np.int32], points: Array, highlight: Collection[int]) -> Array:
    model = stage.scene.model
    colours = np.array(model.geom_rgba[geoms, :3], dtype=float)
    planes = (geoms >= 0) & (model.geom_rbound[geoms] == 0)
    tiles = np.floor(points[:, :2] / TILE_M).sum(axis=1) % 2
    colours[planes] = FLOOR * (1 - 0.08 * tiles[planes, None])
    colours[np.isin(geoms, list(highlight))] = HIGHLIGHT
    return colours


HIGHLIGHT = np.array([0.95, 0.45, 0.05])
"""Colour of the target object in every picture."""


def looking(from_m: ArrayLike, at_m: ArrayLike) -> Pose:
    """A level camera at one point that looks at another; metres, (3,) each."""
    position = np.asarray(from_m, dtype=float)
    forward = np.asarray(at_m, dtype=float) - position
    forward /= np.linalg.norm(forward)
    left = np.cross((0.0, 0.0, 1.0), forward)
    left /= np.linalg.norm(left)
    return Pose(position, np.stack((forward, left, np.cross(forward, left)), axis=1))


# --- Saving pictures: whole or not at all, and the same bytes for the same picture.

DPI = 100


def save_figure(figure: Figure, path: Path) -> Path:
    """Write a figure as PNG.

    Raises:
        InputError: The folder does not exist or cannot be written to.
    """
    FigureCanvasAgg(figure)
    with writing(path, replace=True) as stream:
        figure.savefig(stream, format="png", dpi=DPI, metadata={"Software": None})
    return path
