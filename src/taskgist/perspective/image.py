"""What an eye sees: its whole image, the pixels of one object, and what stands in the way (5.1.1).

``visibility`` tells how much of an object an agent sees from its current state, from the same pixels as ``view_of``;
where these are few, from finer ones.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.errors import SceneError
from taskgist.perspective.effort import Visibility
from taskgist.perspective.gaze import off_gaze
from taskgist.perspective.lens import Lens, lens_of, pixel_rays, raster, ray_through
from taskgist.perspective.occlusion import away_m, from_eye
from taskgist.perspective.target import Sought, Target
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.rays import INF, Shapes, stand_between
from taskgist.world.stage import Stage
from taskgist.world.state import AHEAD

# --- An agent's whole field of view as a pinhole image: what each pixel shows (5.1.1).
#
# The eye looks along its x axis, z up. Pixels are squares on a plane at distance one: row 0 is the top, column 0 the
# left, and a ray goes through each pixel's centre. The body that the eye sits in is looked through, and so is what is
# transparent; the agent's own hands and chest are seen and occlude like anything.


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


def view_of(stage: Stage, agent: str, settings: Settings = DEFAULT) -> View:
    """Cast one ray through every pixel of an agent's field of view.

    Args:
        stage: The scene in a state.
        agent: Whose eye.
        settings: What is looked through.

    Raises:
        UnknownNameError: There is no such agent.
        SceneError: It has no eye.
    """
    body = stage.scene.agent(agent)
    if not body.profile.eye.sees:
        raise no_eye(agent)
    eye = stage.eye(body)
    rays, hiding = pixel_rays(body.profile.eye), stage.scene.hiding(settings.vision.transparent_alpha)
    geoms, distances_m = stage.cast(
        eye.position,
        rays.reshape(-1, 3) @ eye.matrix.T,
        exclude_body=body.eye_exclude_body,
        only=None if hiding[stage.seen].all() else np.flatnonzero(hiding & stage.seen),
    )
    return View(geoms.reshape(rays.shape[:2]), distances_m.reshape(rays.shape[:2]), stage.scene.owners)


def no_eye(agent: str) -> SceneError:
    """What to tell of an agent that is asked what it sees and has no eye."""
    hint = "name one in its profile: [eye] frame or camera (docs/howto/bodies.md)"
    return SceneError("has no eye: what it sees is unknown", where=f"agent {agent}", hint=hint)


# --- Sight: which of an object's pixels an eye sees, and what the others show instead (5.1.1).
#
# Only the pixels in which the object alone would be seen are worth a ray into the whole scene, and only those of its
# bounding window are worth a ray at the object alone. The counts are those of the whole image; where an object has few
# of its pixels, these are halved, and each ray counts as the part of a pixel that it stands for.


@dataclass(frozen=True, eq=False)
class Sight:
    """The pixels in which an object would be seen if it were alone, and what is seen there.

    Attributes:
        eye: Where the eye is in metres, and how it is turned, a row of 12.
        rays_in_eye: Unit directions of those pixels, or of parts of them, (n, 3).
        geoms: Shapes that they show, (n,).
        distances_m: How far these are, (n,).
        visible: Whether the shape is the object's, (n,).
        ray_px: Pixels that each ray stands for: one, or a fraction of one where an object is small.
        ray_sr: Solid angle of a ray in the image's middle, steradians.
        least_sr: The least solid angle that is made out.
    """

    eye: Array
    rays_in_eye: Array
    geoms: Indices
    distances_m: Array
    visible: Mask
    ray_px: float
    ray_sr: float
    least_sr: float

    def pixels(self, which: Mask | None = None) -> float:
        """Pixels that the rays stand for, or some of them, (n,)."""
        return (len(self.geoms) if which is None else int(np.count_nonzero(which))) * self.ray_px

    def makes_out(self, which: Mask | None = None) -> bool:
        """Whether what the rays show, or some of them, (n,), is large enough to be seen."""
        cosines = self.rays_in_eye[:, 0] if which is None else self.rays_in_eye[which, 0]
        # the same part of a flat image is a smaller part of the sphere the farther it is from the image's middle
        return float((cosines**3).sum()) * self.ray_sr >= self.least_sr

    def owners(self, which: Mask, owners: Sequence[str]) -> tuple[tuple[str, float], ...]:
        """What some of the rays show, (n,), and in how many pixels, most first; ``owners`` are those of all shapes."""
        counts = Counter(owners[geom] for geom in self.geoms[which].tolist())
        most_first = sorted(counts.items(), key=lambda each: (-each[1], each[0]))
        return tuple((owner, count * self.ray_px) for owner, count in most_first)


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
    rays, geoms, distances_m, visible, halvings, count, meshes = found
    if meshes:
        rays, geoms, distances_m, visible, halvings = _look_at_meshes(stage, target, but_body, eye, lens, least)
    stage.count_rays(count)
    ray_px = 0.25**halvings
    return Sight(eye, rays, geoms, distances_m, visible, ray_px, ray_px * lens.pixel_sr, target.least_sr)


def _look_at_meshes(
    stage: Stage, target: Target, but_body: int, eye: Array, lens: Lens, least: float
) -> tuple[Array, Indices, Array, Mask, int]:
    """What ``_looked`` finds, where a shape has no formula."""
    around = stand_between(stage.shapes, target.others, but_body, eye[:3], target.centers, target.radii_m)
    rays, halvings = _rays_towards(target.sought, lens, eye, least)
    directions = rays @ eye[3:].reshape(3, 3).T
    own, own_m = stage.cast_at(target.shapes, eye[:3], directions)
    alone = own >= 0
    own, own_m = own[alone], own_m[alone]
    other, other_m = stage.cast_at(around, eye[:3], directions[alone])
    visible = own_m <= other_m
    return rays[alone], np.where(visible, own, other), np.minimum(own_m, other_m), visible, halvings


@compiled
def _rays_towards(sought: Sought, lens: Lens, eye: Array, least: float) -> tuple[Array, int]:
    """Rays that might show an object, near enough to the gaze, in the eye's frame, (k, 3); how often pixels halve."""
    halvings, first_row, last_row, first_column, last_column = raster(
        lens, eye, sought.centers, sought.radii_m, sought.corners
    )
    rays, count = np.empty(((last_row - first_row) * (last_column - first_column), 3)), 0
    for row in range(first_row, last_row):
        for column in range(first_column, last_column):
            x, y, z = ray_through(lens, halvings, row, column)
            if x >= least:
                rays[count, 0], rays[count, 1], rays[count, 2] = x, y, z
                count += 1
    return rays[:count], halvings


@compiled
def _looked(
    shapes: Shapes, candidates: Indices, but_body: int, sought: Sought, lens: Lens, eye: Array, least: float
) -> tuple[Array, Indices, Array, Mask, int, int, bool]:
    """What a ``Sight`` holds, how often pixels were halved, rays that it took, whether meshes leave it undecided."""
    around = stand_between(shapes, candidates, but_body, eye[:3], sought.centers, sought.radii_m)
    own, others = from_eye(shapes, sought.shapes, eye, False), from_eye(shapes, around, eye, False)
    meshes = len(own) < len(sought.shapes) or len(others) < len(around)
    (rays, halvings), frame = _rays_towards(sought, lens, eye, least), eye[3:]
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
    return rays[:count], geoms[:count], distances[:count], visible[:count], halvings, len(rays) + count, meshes


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
    """What a sight of an object comes to. What is too small to be made out is not visible."""
    width, height = agent.profile.eye.image_px
    in_cone = sight.rays_in_eye[:, 0] >= lens_of(agent.profile.eye).cone_cos
    seen, gazed = (each & sight.makes_out(each) for each in (sight.visible, sight.visible & in_cone))
    near = sight.distances_m[seen]
    turn = stage.state.eyes.get(agent.name, AHEAD)
    assumed = turn if turn.towards is not None else AHEAD
    return Visibility(
        visible_px=sight.pixels(seen),
        image_px=width * height,
        unoccluded_px=sight.pixels(),
        gaze_px=sight.pixels(gazed),
        occluders=sight.owners(~sight.visible, stage.scene.owners),
        nearest_m=float(near.min()) if len(near) else None,
        off_gaze_rad=off_gaze(sight.eye, target.middle, 0.0),
        eyes_rad=assumed.turned_rad,
        eyes_towards=assumed.towards,
    )
