"""What the twin asks MuJoCo, plainly: whole images, and how deep every pair of shapes overlaps."""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.lens import STEPS, lens_of, raster
from taskgist.settings import Vision
from taskgist.world import Agent, Scene, State

Array = NDArray[np.float64]
Geom = mujoco.mjtGeom
SEEN = (0, 1, 2)
SEEN_MASK = np.array([1, 1, 1, 0, 0, 0], dtype=np.uint8)
UNSEEN, GHOST = 3, 5
MEASURED_M = 0.01
ARCMIN_RAD = math.pi / 180 / 60
MARGIN = 1.5
"""How much wider than an object's ball that is at which the twin looks."""
STRAIGHT = math.pi / 2 - 1e-3
"""Nothing farther aside is in an image."""


@dataclass(frozen=True, eq=False)
class Pixels:
    """What an eye sees around an object, ray by ray.

    Attributes:
        geoms: The first shape that each ray meets, −1 for none, (n,).
        alone: The same if nothing but the object were there.
        rays: Unit directions in the eye's frame, (n, 3).
        share: The part of a pixel that each ray stands for.
        pixel_sr: Solid angle of a pixel in the image's middle.
    """

    geoms: NDArray[np.int32]
    alone: NDArray[np.int32]
    rays: Array
    share: float
    pixel_sr: float

    def count(self, which: NDArray[np.bool_], vision: Vision) -> float:
        """Pixels of some rays; none where their solid angle is too small to be made out."""
        seen_sr = (self.rays[which, 0] ** 3).sum() * self.share * self.pixel_sr
        return float(which.sum()) * self.share if seen_sr >= vision.least_visible_arcmin2 * ARCMIN_RAD**2 else 0.0


class World:
    """A scene in one state, with copies of its own of model and data."""

    def __init__(self, scene: Scene, state: State) -> None:
        self.scene, self.model = scene, copy.copy(scene.model)
        self.hidden = _hidden(scene, state)
        self.model.geom_group[list(self.hidden)] = UNSEEN
        self.data = mujoco.MjData(self.model)
        self.show(state.qpos)

    def show(self, qpos: Array) -> None:
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(self.model, self.data)

    # shapes --------------------------------------------------------------------------------------------------

    def seen_geoms(self, owner: str) -> list[int]:
        """Shapes of an owner that rays meet, tracked or not."""
        groups = self.scene.model.geom_group
        return [g for g, who in enumerate(self.scene.owners) if who == owner and groups[g] in SEEN]

    def solid_geoms(self, without: Iterable[str]) -> list[int]:
        """Shapes that block, of all but some owners."""
        m, left_out = self.model, set(without)
        return [
            g
            for g, owner in enumerate(self.scene.owners)
            if owner not in left_out
            and g not in self.hidden
            and self.scene.model.geom_group[g] != GHOST
            and (m.geom_contype[g] or m.geom_conaffinity[g])
        ]

    def middle(self, owner: str) -> Array:
        return np.asarray(self.data.geom_xpos[self.seen_geoms(owner)].mean(axis=0))

    # sight ---------------------------------------------------------------------------------------------------

    def image(self, agent: Agent, alone: Sequence[int] | None = None) -> NDArray[np.int32]:
        """The first shape in each pixel of the whole field of view, −1 for none, (height * width,).

        With ``alone``, only these shapes are there, and the body around the eye is as solid as any.
        """
        return self._cast(agent, pixel_rays(agent), alone)

    def look(self, agent: Agent, owner: str, vision: Vision) -> Pixels:
        """What an eye sees around an object: the whole image, or finer pixels around it where it has few.

        How fine they are is asked of the fast one; which of them count is found out anew.
        """
        shapes, eye = self.seen_geoms(owner), lens_of(agent.profile.eye)
        halvings = self._raster(agent, shapes)[0]
        rays = pixel_rays(agent) if halvings == 0 else self._fine_rays(agent, shapes, halvings)
        glass = [g for g in self._transparent(vision) if g not in shapes]
        return Pixels(
            self._cast(agent, rays, passing=glass), self._cast(agent, rays, shapes), rays, 0.25**halvings, eye.pixel_sr
        )

    def _raster(self, agent: Agent, shapes: Sequence[int]) -> tuple[int, ...]:
        m, data, site = self.model, self.data, agent.eye_site
        signs = np.array(list(itertools.product((-1, 1), repeat=3)))
        boxes = m.geom_aabb[shapes, None, :3] + signs * m.geom_aabb[shapes, None, 3:]
        turned = np.einsum("nij,nkj->nki", data.geom_xmat[shapes].reshape(-1, 3, 3), boxes)
        corners = (turned + data.geom_xpos[shapes][:, None]).reshape(-1, 3)
        row = np.concatenate((data.site_xpos[site], data.site_xmat[site]))
        return raster(lens_of(agent.profile.eye), row, data.geom_xpos[shapes], m.geom_rbound[shapes], corners)

    def _fine_rays(self, agent: Agent, shapes: Sequence[int], halvings: int) -> Array:
        """Through all fine pixels in whose rows and columns an object's balls may be, in the eye's frame, (n, 3)."""
        eye, frame = agent.profile.eye, self.data.site_xmat[agent.eye_site].reshape(3, 3)
        width, height = (size * 2**halvings for size in eye.image_px)
        right, up = (math.tan(angle / 2) for angle in eye.fov_rad)
        wanted = np.zeros((height, width), dtype=bool)
        for shape in shapes:
            x, y, z = (self.data.geom_xpos[shape] - self.data.site_xpos[agent.eye_site]) @ frame
            rows, columns = (_around(x, at, self.model.geom_rbound[shape]) for at in (z, y))
            top, bottom = ((1 - tangent / up) * height / 2 for tangent in rows)
            left, last = ((1 - tangent / right) * width / 2 for tangent in columns)
            wanted[_cut(top, height) : _cut(bottom + 1, height), _cut(left, width) : _cut(last + 1, width)] = True
        row, column = np.nonzero(wanted)
        aside = np.abs(column + 0.5 - width / 2) - 0.5
        left = (aside + row * STEPS[0] % 1) / (width / 2) * right
        above = up * (1 - 2 * (row + aside * STEPS[1] % 1) / height)
        rays = np.stack((np.ones(len(row)), np.where(column < width / 2, left, -left), above), axis=1)
        return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))

    def _transparent(self, vision: Vision) -> list[int]:
        m = self.scene.model
        alpha = [m.geom_rgba[g, 3] if m.geom_matid[g] < 0 else m.mat_rgba[m.geom_matid[g], 3] for g in range(m.ngeom)]
        return [g for g in range(m.ngeom) if alpha[g] <= vision.transparent_alpha]

    def _cast(
        self, agent: Agent, rays: Array, alone: Sequence[int] | None = None, passing: Sequence[int] = ()
    ) -> NDArray[np.int32]:
        rays = np.ascontiguousarray(rays @ self.data.site_xmat[agent.eye_site].reshape(3, 3).T)
        model, exclude = self.model, agent.eye_exclude_body
        if alone is not None:
            model, exclude = copy.copy(self.scene.model), -1
            model.geom_group[[g for g in range(model.ngeom) if g not in alone]] = UNSEEN
        if passing:
            model = copy.copy(model)
            model.geom_group[passing] = UNSEEN
        geoms, distances = np.full(len(rays), -1, dtype=np.int32), np.zeros(len(rays))
        eye = self.data.site_xpos[agent.eye_site]
        mujoco.mj_multiRay(
            model, self.data, eye, rays.ravel(), SEEN_MASK, True, exclude, geoms, distances, None, len(rays), 1e10
        )
        return geoms

    # contact -------------------------------------------------------------------------------------------------

    def depths(self, geoms: Iterable[int], others: Iterable[int]) -> dict[tuple[int, int], float]:
        """How deep each shape is in each other one, metres; pairs that do not overlap are left out."""
        pairs = np.array(list(itertools.product(geoms, others)), dtype=int).reshape(-1, 2)
        a, b = pairs.T
        far = np.linalg.norm(self.data.geom_xpos[a] - self.data.geom_xpos[b], axis=1)
        radius = self.model.geom_rbound
        near = (far < radius[a] + radius[b]) | (radius[a] == 0) | (radius[b] == 0)
        depths = {(int(a), int(b)): -self.gap(int(a), int(b)) for a, b in pairs[near]}
        return {pair: depth for pair, depth in depths.items() if depth > 0}

    def gap(self, a: int, b: int) -> float:
        """Signed distance of two shapes. MuJoCo overlooks a capsule that goes right through a thin box."""
        kinds = self.model.geom_type
        for capsule, box in ((a, b), (b, a)):
            if kinds[capsule] == Geom.mjGEOM_CAPSULE and kinds[box] == Geom.mjGEOM_BOX:
                depth = self._axis_depth(capsule, box)
                if depth >= 0:
                    return -depth - float(self.model.geom_size[capsule, 0])
        return float(mujoco.mj_geomDistance(self.model, self.data, a, b, MEASURED_M, None))

    def _axis_depth(self, capsule: int, box: int) -> float:
        """Depth in the box of the middle of the capsule's axis' part inside; negative where it is outside."""
        frame = self.data.geom_xmat[box].reshape(3, 3)
        along = self.data.geom_xmat[capsule].reshape(3, 3)[:, 2] * self.model.geom_size[capsule, 1]
        start = (self.data.geom_xpos[capsule] - self.data.geom_xpos[box] - along) @ frame
        step = 2 * along @ frame
        half = self.model.geom_size[box]
        with np.errstate(divide="ignore", invalid="ignore"):
            cuts = np.sort(np.array([(-half - start) / step, (half - start) / step]), axis=0)
        still = np.abs(step) < 2e-12
        if (still & (np.abs(start) > half)).any():
            return -1.0
        enter = max(0.0, *np.where(still, 0.0, cuts[0]))
        leave = min(1.0, *np.where(still, 1.0, cuts[1]))
        middle = start + (enter + leave) / 2 * step
        return float(np.min(half - np.abs(middle))) if enter <= leave else -1.0


def _around(ahead: float, aside: float, radius_m: float) -> tuple[float, float]:
    """Tangents of the greatest and the least angle at which something of a ball is, a little more than that."""
    angle, distance = math.atan2(aside, ahead), math.hypot(ahead, aside)
    half = MARGIN * math.asin(radius_m / distance) if radius_m < distance else math.pi
    low, high = (min(max(each, -STRAIGHT), STRAIGHT) for each in (angle - half, angle + half))
    return math.tan(high), math.tan(low)


def _cut(pixel: float, pixels: int) -> int:
    return int(min(max(pixel, 0), pixels))


def pixel_rays(agent: Agent) -> Array:
    """Unit directions through the pixels' centres, row by row from the top left, in the eye's frame."""
    eye = agent.profile.eye
    width, height = eye.image_px
    focal = [size / 2 / math.tan(angle / 2) for size, angle in zip(eye.image_px, eye.fov_rad, strict=True)]
    rows, columns = np.divmod(np.arange(width * height), width)
    right, down = (columns + 0.5 - width / 2) / focal[0], (rows + 0.5 - height / 2) / focal[1]
    rays = np.stack((np.ones(len(rows)), -right, -down), axis=1)
    return np.asarray(rays / np.linalg.norm(rays, axis=1, keepdims=True))


def _hidden(scene: Scene, state: State) -> frozenset[int]:
    """Shapes of all that was not tracked."""
    hidden = set()
    for name in state.untracked:
        owner, _, part = name.partition("/")
        for geom, who in enumerate(scene.owners):
            body = scene.model.geom_bodyid[geom]
            if who == owner and (not part or body in scene.agent(owner).parts[part]):
                hidden.add(geom)
    return frozenset(hidden)
