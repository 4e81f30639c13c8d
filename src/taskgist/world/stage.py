"""The stage: the one class that wraps MuJoCo's model and data. Everything that needs geometry asks it.

A stage shows one state at a time. Showing another is cheap (kinematics only) and changes neither states nor scene::

    stage = Stage(scene).show(state)
    eye = stage.eye(scene.agent("P2"))
    geoms, distances_m = stage.cast(eye.position, directions, exclude_body=...)
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.world.agent import SEEN_MASK, Agent, ArmIndices
from taskgist.world.gaps import gap_m
from taskgist.world.scene import Scene
from taskgist.world.state import State

Array = NDArray[np.float64]
UNSEEN_GROUP = 3
NO_GEOM = -1


@dataclass(frozen=True, eq=False)
class Pose:
    """A place and an orientation in the world.

    Attributes:
        position: Metres, (3,).
        matrix: Rotation, (3, 3); its columns are the frame's axes in the world.
    """

    position: Array
    matrix: Array

    def to_world(self, points: ArrayLike) -> Array:
        """Points (..., 3) of this frame, in the world."""
        return np.asarray(np.asarray(points) @ self.matrix.T + self.position)

    def to_local(self, points: ArrayLike) -> Array:
        """Points (..., 3) of the world, in this frame."""
        return np.asarray((np.asarray(points) - self.position) @ self.matrix)


class Stage:
    """A scene brought into a state."""

    def __init__(self, scene: Scene, state: State | None = None) -> None:
        self.scene = scene
        self._data = mujoco.MjData(scene.model)
        self._alone: tuple[tuple[int, ...], mujoco.MjModel] | None = None
        self._known: tuple[frozenset[str], mujoco.MjModel] = (frozenset(), scene.model)
        self.state = scene.initial if state is None else state
        self.show(self.state)

    def show(self, state: State) -> Self:
        """Bring the scene into a state. What was not tracked is left out: no ray meets it, and it blocks nothing."""
        self.state = state
        if state.untracked != self._known[0]:
            self._known = (state.untracked, self._model_without(self.scene.untracked_geoms(state.untracked)))
        self._data.qpos[:] = state.qpos
        mujoco.mj_kinematics(self.scene.model, self._data)
        return self

    @contextmanager
    def showing(self, state: State) -> Iterator[Self]:
        """Bring the scene into a state for a while."""
        before = self.state
        try:
            yield self.show(state)
        finally:
            self.show(before)

    def eye(self, agent: Agent) -> Pose:
        """The agent's eye: x looks forward, z up."""
        return self.site(agent.eye_site)

    def shoulder(self, arm: ArmIndices) -> Pose:
        """The arm's shoulder, in the frame of what carries the arm (x forward, z up of the torso)."""
        return Pose(
            self._data.site_xpos[arm.shoulder_site].copy(), self._data.xmat[arm.carrier_body].reshape(3, 3).copy()
        )

    def joint_axis(self, agent: Agent, joint: str) -> Array:
        """Axis of one of the agent's joints in the world, a unit vector (3,)."""
        return np.array(self._data.xaxis[self.scene.model.joint(f"{agent.name}/{joint}").id])

    def site(self, site: int) -> Pose:
        """Pose of a site."""
        return Pose(self._data.site_xpos[site].copy(), self._data.site_xmat[site].reshape(3, 3).copy())

    def geom(self, geom: int) -> Pose:
        """Pose of a shape."""
        return Pose(self._data.geom_xpos[geom].copy(), self._data.geom_xmat[geom].reshape(3, 3).copy())

    def body(self, body: int) -> Pose:
        """Pose of a body."""
        return Pose(self._data.xpos[body].copy(), self._data.xmat[body].reshape(3, 3).copy())

    def body_position(self, body: int) -> Array:
        """Position of a body's frame in metres, (3,)."""
        return np.array(self._data.xpos[body])

    def body_axis(self, body: int, axis: int) -> Array:
        """One axis of a body's frame in the world, (3,)."""
        return np.array(self._data.xmat[body].reshape(3, 3)[:, axis])

    def geom_centers(self, geoms: ArrayLike) -> Array:
        """Centres of shapes in metres, (n, 3)."""
        return np.array(self._data.geom_xpos[np.asarray(geoms, dtype=np.intp)])

    def cast(
        self,
        origin: ArrayLike,
        directions: ArrayLike,
        *,
        exclude_body: int = -1,
        only: ArrayLike | None = None,
        normals: Array | None = None,
    ) -> tuple[NDArray[np.int32], Array]:
        """Cast rays.

        Args:
            origin: Where all rays start, metres, (3,).
            directions: Unit vectors in the world, (n, 3).
            exclude_body: A body that rays pass through, or −1.
            only: The only shapes that rays meet, where given: what would be seen if nothing else were there.
            normals: Filled with the outward normals of what is met, (n, 3), where given.

        Returns:
            The first geom that each ray meets (−1: none), (n,), and its distance in metres (−1: none), (n,).
        """
        rays = np.ascontiguousarray(directions, dtype=float)
        geoms = np.full(len(rays), NO_GEOM, dtype=np.int32)
        distances = np.full(len(rays), -1.0)
        if len(rays):
            mujoco.mj_multiRay(
                self._model_of(only),
                self._data,
                np.asarray(origin, dtype=float),
                rays.ravel(),
                SEEN_MASK,
                True,
                exclude_body,
                geoms,
                distances,
                None if normals is None else normals.reshape(-1),
                len(rays),
                mujoco.mjMAXVAL,
            )
        return geoms, distances

    def _model_of(self, only: ArrayLike | None) -> mujoco.MjModel:
        """The model of what is known; for rays that meet only some shapes, a copy in which no other is seen."""
        if only is None:
            return self._known[1]
        shapes = tuple(int(geom) for geom in np.asarray(only))
        if self._alone is None or self._alone[0] != shapes:
            model = copy.copy(self.scene.model) if self._alone is None else self._alone[1]
            groups = np.full(model.ngeom, UNSEEN_GROUP)
            groups[list(shapes)] = self.scene.model.geom_group[list(shapes)]
            model.geom_group[:] = groups
            self._alone = (shapes, model)
        return self._alone[1]

    def _model_without(self, hidden: NDArray[np.intp]) -> mujoco.MjModel:
        if not len(hidden):
            return self.scene.model
        model = copy.copy(self.scene.model)
        model.geom_group[hidden] = UNSEEN_GROUP
        return model

    def distance(self, geom_a: int, geom_b: int, *, limit_m: float) -> float:
        """Signed distance in metres between two shapes (negative: how deep they overlap), at most ``limit_m``."""
        if not self._near(geom_a, geom_b, limit_m):
            return limit_m
        return gap_m(self.scene.model, self._data, geom_a, geom_b, limit_m=limit_m)

    def near_pairs(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> list[tuple[int, int]]:
        """Pairs of shapes whose bounding spheres come closer than ``limit_m``; planes are near to everything."""
        a, b = np.asarray(geoms, dtype=np.intp), np.asarray(others, dtype=np.intp)
        radius = self.scene.model.geom_rbound
        gaps = np.linalg.norm(self._data.geom_xpos[a][:, None] - self._data.geom_xpos[b][None], axis=2)
        near = gaps - radius[a][:, None] - radius[b][None] < limit_m
        near |= (radius[b] == 0)[None] | (radius[a] == 0)[:, None]
        return [(int(a[i]), int(b[j])) for i, j in np.argwhere(near)]

    def closest(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> tuple[float, int, int]:
        """The smallest signed distance in metres between two sets of shapes, at most ``limit_m``, and the pair."""
        best = (limit_m, NO_GEOM, NO_GEOM)
        for geom, other in self.near_pairs(geoms, others, limit_m=limit_m):
            gap = gap_m(self.scene.model, self._data, geom, other, limit_m=limit_m)
            if gap < best[0]:
                best = (gap, geom, other)
        return best

    def overlaps(self, geoms: ArrayLike, others: ArrayLike) -> Iterator[tuple[int, int, float]]:
        """Pairs of shapes, one of each set, that overlap, and how deep in metres."""
        for geom, other in self.near_pairs(geoms, others, limit_m=0.0):
            gap = gap_m(self.scene.model, self._data, geom, other, limit_m=0.0)
            if gap < 0.0:
                yield geom, other, -gap

    def place_ghosts(self, arm: ArmIndices, poses: Iterable[Pose]) -> None:
        """Put the shapes of a virtual grasp somewhere; the next ``show`` puts them back."""
        for ghost, pose in zip(arm.ghosts, poses, strict=True):
            self._data.geom_xpos[ghost] = pose.position
            self._data.geom_xmat[ghost] = pose.matrix.ravel()

    def solid_geoms(self) -> NDArray[np.intp]:
        """Indices of the shapes that block: all but ghosts, those that nothing collides with, and what is untracked."""
        hidden = self.scene.untracked_geoms(self.state.untracked)
        return self.scene.solid_geoms if not len(hidden) else np.setdiff1d(self.scene.solid_geoms, hidden)

    def in_bounds(self, geoms: ArrayLike, point: ArrayLike) -> bool:
        """Whether a point lies in the box, along the world's axes, around the bounding spheres of some shapes."""
        shapes = np.asarray(geoms, dtype=np.intp)
        centers, radius = self._data.geom_xpos[shapes], self.scene.model.geom_rbound[shapes][:, None]
        low, high = (centers - radius).min(axis=0), (centers + radius).max(axis=0)
        return bool(np.all(low <= point) and np.all(point <= high))

    def is_plane(self, geom: int) -> bool:
        """Whether a shape is an endless plane, such as the floor."""
        return bool(self.scene.model.geom_rbound[geom] == 0)

    def _near(self, geom_a: int, geom_b: int, limit_m: float) -> bool:
        return bool(self.near_pairs([geom_a], [geom_b], limit_m=limit_m))
