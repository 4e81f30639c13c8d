"""What an eye sees: its whole image, the pixels of one object, and what stands in the way (5.1.1).

``visibility`` tells how much of an object an agent sees from its current state, from the same pixels as ``view_of``.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.effort import Visibility
from taskgist.perspective.gaze import off_gaze
from taskgist.perspective.occlusion import away_m, from_eye
from taskgist.perspective.target import Sought, Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.profile import Eye
from taskgist.world.geometry.rays import INF, Shapes, stand_between
from taskgist.world.stage import Stage

# --- An agent's whole field of view as a pinhole image: what each pixel shows (5.1.1).
#
# The eye looks along its x axis, z up. Pixels are squares on a plane at distance one: row 0 is the top, column 0 the
# left, and a ray goes through each pixel's centre. The body that the eye sits in is looked through; the agent's own
# hands and chest are seen and occlude like anything.

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
        half_tan: Tangents of half of it.
        image_px: Width and height of the image.
        cone_rad: Half-angle of the gaze cone.
        cone_cos: Its cosine.
    """

    rays: Array
    fov_rad: tuple[float, float]
    half_tan: tuple[float, float]
    image_px: tuple[int, int]
    cone_rad: float
    cone_cos: float


@lru_cache(maxsize=32)
def lens_of(eye: Eye) -> Lens:
    """The lens of a profile's eye."""
    across, up = eye.fov_rad
    half_tan, cone_rad = (math.tan(across / 2), math.tan(up / 2)), eye.gaze_cone_rad
    return Lens(pixel_rays(eye), eye.fov_rad, half_tan, eye.image_px, cone_rad, math.cos(cone_rad))


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


@compiled_part
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


@compiled_part
def _widened(
    low: float, high: float, ahead: float, aside: float, radius_m: float, half_rad: float
) -> tuple[float, float]:
    """Lowest and highest angle, with those of the tangents to a sphere that lies in the field of view."""
    middle, distance = math.atan2(aside, ahead), math.hypot(ahead, aside)
    half = math.asin(radius_m / distance) if radius_m < distance else 2 * math.pi  # the eye is inside: all round
    if middle + half > -half_rad and middle - half < half_rad:
        return min(low, middle - half), max(high, middle + half)
    return low, high


@compiled_part
def _span(low: float, high: float, half_rad: float, pixels: int) -> tuple[int, int]:
    """Pixels between two angles, the last not included."""
    if low > high:
        return 0, 0
    first = _pixel(min(high, half_rad), half_rad, pixels)
    last = _pixel(max(low, -half_rad), half_rad, pixels)
    return max(0, math.ceil(first - EDGE_PX)), min(pixels, math.floor(last + EDGE_PX) + 1)


@compiled_part
def _pixel(angle_rad: float, half_rad: float, pixels: int) -> float:
    """Where a direction meets the row of pixel centres."""
    return (1 - math.tan(angle_rad) / math.tan(half_rad)) * pixels / 2 - 0.5


# --- Sight: which of an object's pixels an eye sees, and what the others show instead (5.1.1).
#
# Only the pixels in which the object alone would be seen are worth a ray into the whole scene, and only those of its
# bounding window are worth a ray at the object alone. The counts are those of the whole image.


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
    geoms: Indices
    distances_m: Array
    visible: Mask


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
) -> tuple[Array, Indices, Array, Mask, int, bool]:
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


@compiled_part
def _first(rows: Array, x: float, y: float, z: float) -> tuple[int, float]:
    """The first shape along a direction, and how far it is."""
    first, nearest = -1, INF
    for k in range(len(rows)):
        at_m = away_m(rows, k, x, y, z)
        if at_m < nearest:
            first, nearest = k, at_m
    return first, nearest


def visibility(
    stage: Stage,
    agent: str,
    name: str,
    settings: Settings = DEFAULT,
) -> Visibility | None:
    """How much of an object an agent sees from its current state.

    Args:
        stage: The scene in a state.
        agent: Whose eye.
        name: The object.
        settings: All settings.

    Returns:
        None where the object or the agent's head was not tracked: that is unknown, not invisible.

    Raises:
        UnknownNameError: There is no such agent or object.
    """
    body = stage.scene.agent(agent)
    stage.scene.object_body(name)
    if not stage.state.known([name, f"{agent}/head"]):
        return None
    target = Target(stage, name, settings)
    return measured(stage, body, target, look(stage, body, target))


def measured(stage: Stage, agent: Agent, target: Target, sight: Sight) -> Visibility:
    """What a sight of an object comes to."""
    owners = stage.scene.owners
    others = Counter(owners[geom] for geom in sight.geoms[~sight.visible].tolist())
    width, height = agent.profile.eye.image_px
    in_cone = sight.rays_in_eye[:, 0] >= lens_of(agent.profile.eye).cone_cos
    near = sight.distances_m[sight.visible]
    return Visibility(
        visible_px=int(sight.visible.sum()),
        image_px=width * height,
        unoccluded_px=len(sight.geoms),
        gaze_px=int((sight.visible & in_cone).sum()),
        occluders=tuple(sorted(others.items(), key=lambda item: (-item[1], item[0]))),
        nearest_m=float(near.min()) if len(near) else None,
        off_gaze_rad=off_gaze(sight.eye, target.middle, 0.0),
    )
