"""The stage: the one class that wraps MuJoCo's model and data. Everything that needs geometry asks it.

A stage shows one state at a time. Showing another is cheap (kinematics only) and changes neither states nor scene::

    stage = Stage(scene).show(state)
    eye = stage.eye(scene.agent("P2"))
    geoms, distances_m = stage.cast(eye.position, directions, exclude_body=...)
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Self

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.settings import Contact
from taskgist.world.bodies.agent import Agent, ArmIndices, ankle_height_m, body_index, leg_lengths_m, legs_for
from taskgist.world.bodies.profile import Posture
from taskgist.world.geometry.distances import HALF, RADIUS, TURNED, Clearance
from taskgist.world.geometry.rays import Rays, Shapes
from taskgist.world.geometry.transforms import Pose, about_z, matrix_from_wxyz, wxyz_from_rotation_vector, yaw_of
from taskgist.world.scene import Scene
from taskgist.world.state import State


class Stage:
    """A scene brought into a state."""

    def __init__(self, scene: Scene, state: State | None = None) -> None:
        self.scene = scene
        self._data = mujoco.MjData(scene.model)
        self._rays = Rays(scene.model, self._data, scene.visible)
        self._clearance = Clearance(scene.model, self._data)
        self._untracked: frozenset[str] = frozenset()
        self._shown_count = 0
        self._as_shown = False
        self.state = scene.initial if state is None else state
        self.show(self.state)

    def show(self, state: State) -> Self:
        """Bring the scene into a state. What was not tracked is left out: no ray meets it, and it blocks nothing.

        An object without any shape counts as not tracked, and so does the head of an agent without an eye: what it
        sees is unknown.
        """
        if not self.scene.never_known <= state.untracked:
            state = state.without(self.scene.never_known)
        if state is self.state and self._as_shown:
            return self
        self.state, self._as_shown = state, True
        self._shown_count += 1
        if state.untracked != self._untracked:
            self._untracked = state.untracked
            self._rays.hide(self.scene.untracked_geoms(state.untracked))
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
        """The agent's eye as it is turned in the head: x looks forward, z up."""
        ahead, turn = self.eye_ahead(agent), self.state.eyes.get(agent.name)
        if turn is None or not turn.turned_rad:
            return ahead
        # Eyes turn about axes square to where they look ahead (Listing's law); y is left, so up is about -y.
        in_head = matrix_from_wxyz(wxyz_from_rotation_vector(np.array((0.0, -turn.up_rad, turn.left_rad))))
        return Pose(ahead.position, ahead.matrix @ in_head)

    def eye_ahead(self, agent: Agent) -> Pose:
        """The agent's eye as it looks where the head does, whatever is known of its gaze."""
        return self.site(agent.eye_site)

    def eye_row(self, agent: Agent) -> Array:
        """``eye`` as a row of 12 for compiled functions: position, and orientation row by row."""
        eye = self.eye(agent)
        return np.concatenate((eye.position, eye.matrix.ravel()))

    def shoulder(self, arm: ArmIndices) -> Pose:
        """The arm's shoulder, in the frame of what carries the arm (x forward, z up of the torso)."""
        return Pose(
            self._data.site_xpos[arm.shoulder_site].copy(), self._data.xmat[arm.carrier_body].reshape(3, 3).copy()
        )

    def screw(self, joint: int) -> tuple[Array, Array]:
        """A point on a joint's axis in metres, (3,), and the axis, a unit vector (3,), in the world."""
        return np.array(self._data.xanchor[joint]), np.array(self._data.xaxis[joint])

    def screws(self, joints: Indices) -> tuple[Array, Array]:
        """The same of several joints, (n, 3) each."""
        return self._data.xanchor[joints], self._data.xaxis[joints]

    def site(self, site: int) -> Pose:
        """Pose of a site."""
        return Pose(self._data.site_xpos[site].copy(), self._data.site_xmat[site].reshape(3, 3).copy())

    def geom(self, geom: int) -> Pose:
        """Pose of a shape."""
        return Pose(self._data.geom_xpos[geom].copy(), self._data.geom_xmat[geom].reshape(3, 3).copy())

    def body(self, body: int) -> Pose:
        """Pose of a body."""
        return Pose(self._data.xpos[body].copy(), self._data.xmat[body].reshape(3, 3).copy())

    def bodies(self) -> Array:
        """Position in metres and wxyz of every body, (bodies, 7)."""
        return np.concatenate((self._data.xpos, self._data.xquat), axis=1)

    def body_position(self, body: int) -> Array:
        """Position of a body's frame in metres, (3,)."""
        return np.array(self._data.xpos[body])

    def body_axis(self, body: int, axis: int) -> Array:
        """One axis of a body's frame in the world, (3,)."""
        return np.array(self._data.xmat[body].reshape(3, 3)[:, axis])

    def center_of_mass(self, bodies: Indices) -> Array:
        """Where the mass of some bodies has its middle, metres, (3,)."""
        masses = self.scene.model.body_mass[bodies]
        return np.asarray(masses @ self._data.xipos[bodies] / masses.sum())

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
        return self._rays.cast(origin, directions, exclude_body=exclude_body, only=only, normals=normals)

    def cast_at(self, shapes: ArrayLike, origin: Array, directions: Array) -> tuple[Indices, Array]:
        """Cast rays at a few shapes, as if the others were not there: much quicker than ``cast``.

        Args:
            shapes: Indices of the shapes, (k,).
            origin: Where all rays start, metres, (3,).
            directions: Unit vectors in the world, (n, 3).

        Returns:
            The first of the shapes that each ray meets (−1: none), (n,), and its distance in metres (infinite: none).
        """
        return self._rays.cast_at(np.asarray(shapes, dtype=np.intp), origin, directions)

    def cast_each(self, shapes: ArrayLike, origins: Array, directions: Array) -> tuple[Indices, Array, Array]:
        """Cast rays at a few shapes, each from a point of its own.

        Args:
            shapes: Indices of the shapes, (k,).
            origins: Where the rays start, metres, (n, 3).
            directions: Unit vectors in the world, (n, 3).

        Returns:
            As ``cast_at``, and the outward normals of what is met, (n, 3).
        """
        return self._rays.cast_each(np.asarray(shapes, dtype=np.intp), origins, directions)

    @property
    def shapes(self) -> Shapes:
        """All shapes where they are, for compiled functions."""
        return self._rays.shapes

    def count_rays(self, count: int) -> None:
        """Note that compiled functions cast rays."""
        self._rays.cast_count += count

    @property
    def seen(self) -> Mask:
        """Whether each shape is one that rays meet: visible, and tracked, (ngeom,)."""
        return self._rays.seen

    def between(self, origin: Array, centers: Array, radii_m: Array, *, but_body: int = -1) -> Indices:
        """Seen shapes that rays from a point may meet before they leave some balls behind; never too few.

        Args:
            origin: The point, metres, (3,).
            centers: Centres of the balls, metres, (n, 3).
            radii_m: Their radii, (n,).
            but_body: A body whose shapes do not count, or −1.
        """
        return self._rays.between(origin, centers, radii_m, but_body)

    def distance(self, geom_a: int, geom_b: int, *, limit_m: float) -> float:
        """Signed distance in metres between two shapes (negative: how deep they overlap), at most ``limit_m``."""
        if not self.near_pairs([geom_a], [geom_b], limit_m=limit_m):
            return limit_m
        return self._clearance.gap_m(geom_a, geom_b, limit_m=limit_m)

    def gap(self, geom_a: int, geom_b: int, *, limit_m: float) -> float:
        """The same as ``distance``, for two shapes whose boxes were held against each other before."""
        return self._clearance.gap_m(geom_a, geom_b, limit_m=limit_m)

    def near_pairs(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> list[tuple[int, int]]:
        """Pairs of shapes, one of each set, that may come closer than ``limit_m``; all others do not."""
        return self._clearance.near_pairs(geoms, others, limit_m=limit_m)

    def closest(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> tuple[float, int, int]:
        """The smallest signed distance in metres between two sets of shapes, at most ``limit_m``, and the pair."""
        return self._clearance.closest(geoms, others, limit_m=limit_m)

    def overlaps(
        self, geoms: ArrayLike, others: ArrayLike, *, deeper_than_m: float = 0.0
    ) -> Iterator[tuple[int, int, float]]:
        """Pairs of shapes, one of each set, that overlap deeper than that, and how deep in metres."""
        return self._clearance.overlaps(geoms, others, deeper_than_m=deeper_than_m)

    def boxes(self, geoms: Indices) -> Array:
        """Boxes around shapes where they are, as rows of a table, (n, 18); see ``geometry.boxes``."""
        return self._clearance.boxes(geoms)

    def bounds(self, geoms: Indices) -> Array:
        """Lowest and highest corner of a box along the world's axes around some shapes, metres, (2, 3)."""
        each = self.bounds_of_each(geoms)
        return np.stack((each[:, 0].min(axis=0), each[:, 1].max(axis=0)))

    def bounds_of_each(self, geoms: Indices) -> Array:
        """The same around each of some shapes, (n, 2, 3)."""
        table = self.boxes(geoms)
        half = np.einsum("nij,nj->ni", np.abs(table[:, TURNED:HALF].reshape(-1, 3, 3)), table[:, HALF:RADIUS])
        return np.stack((table[:, :3] - half, table[:, :3] + half), axis=1)

    @property
    def counts(self) -> dict[str, int]:
        """Work done so far: states shown, rays cast, pairs of shapes measured."""
        return {
            "states": self._shown_count,
            "rays": self._rays.cast_count,
            "pairs": self._clearance.measured_count,
        }

    def geoms(self, geoms: Indices) -> tuple[Array, Array]:
        """Positions of shapes in metres, (n, 3), and how they are turned, (n, 9)."""
        return self._data.geom_xpos[geoms], self._data.geom_xmat[geoms]

    def place(self, geoms: Indices, positions: Array, matrices: Array) -> None:
        """Put shapes somewhere, (n, 3) and (n, 9) or all turned alike, (9,); the next ``show`` puts them back."""
        self._as_shown = False
        self._data.geom_xpos[geoms] = positions
        self._data.geom_xmat[geoms] = matrices

    def solid_geoms(self) -> Indices:
        """Indices of the shapes that block: all but ghosts, those that nothing collides with, and what is untracked."""
        hidden = self.scene.untracked_geoms(self.state.untracked)
        return self.scene.solid_geoms if not len(hidden) else np.setdiff1d(self.scene.solid_geoms, hidden)

    def is_plane(self, geom: int) -> bool:
        """Whether a shape is an endless plane, such as the floor."""
        return bool(self.scene.model.geom_rbound[geom] == 0)


# --- Postures: sitting and standing, over feet that stay where they are.
#
# Standing up moves the pelvis over the feet, by about a thigh forward; sitting down is the reverse, onto something.
# Both give a new state of one agent and leave everything else alone; whether there is room is for ``perspective`` to
# judge.


def posture_of(stage: Stage, agent: Agent, settings: Contact) -> Posture | None:
    """Sitting or standing, from the inclination of the thighs; None if the legs were not tracked (5.2.1)."""
    if not stage.state.known([f"{agent.name}/legs", agent.name]):
        return None
    if not agent.thigh_bodies:
        return "standing"
    down = np.mean([-stage.body_axis(body, 2) for body in agent.thigh_bodies], axis=0)
    inclination = math.acos(float(np.clip(-down[2] / np.linalg.norm(down), -1.0, 1.0)))
    return "sitting" if inclination > settings.sitting_thigh_rad else "standing"


def with_posture(stage: Stage, agent: Agent, posture: Posture, *, seat_height_m: float | None = None) -> State:
    """The state in which the agent has taken the other posture over its feet.

    Args:
        stage: The scene in its present state.
        agent: The agent; its torso, head and arms keep their angles.
        posture: The posture to take.
        seat_height_m: Height of what it sits down onto.
    """
    model, state = stage.scene.model, stage.state
    floor = floor_height_m(stage, agent)
    hip_height = math.inf
    if posture == "sitting":
        assert seat_height_m is not None
        hip_height = seat_height_m - floor + agent.profile.legs.seat_share * agent.stature_m
    angles, height = legs_for(model, agent, hip_height_m=hip_height)
    feet = np.mean([stage.body_position(body_index(model, agent, foot)) for foot in agent.profile.legs.feet], axis=0)
    yaw = yaw_of(state.qpos[agent.base][3:])
    thigh, _ = leg_lengths_m(model, agent)
    back = thigh * math.sin(angles[agent.profile.legs.hips[0]])
    place = feet[:2] - back * np.array([math.cos(yaw), math.sin(yaw)])
    upright = state.replace({agent.joints[joint]: angle for joint, angle in angles.items()})
    return upright.replace(at=agent.base, to=(*place, floor + height, *about_z(yaw)))


def floor_height_m(stage: Stage, agent: Agent) -> float:
    """Height in metres of what the lower foot stands on."""
    model = stage.scene.model
    ankles = [stage.body_position(body_index(model, agent, foot))[2] for foot in agent.profile.legs.feet]
    return float(min(ankles)) - ankle_height_m(model, agent)


def seat_position(stage: Stage, agent: Agent) -> Array:
    """Floor point (2,) over which the pelvis would be if the agent sat down with level thighs and kept its feet."""
    model = stage.scene.model
    feet = np.mean([stage.body_position(body_index(model, agent, foot)) for foot in agent.profile.legs.feet], axis=0)
    yaw = yaw_of(stage.state.qpos[agent.base][3:])
    thigh, _ = leg_lengths_m(model, agent)
    return np.asarray(feet[:2] - thigh * np.array([math.cos(yaw), math.sin(yaw)]))
