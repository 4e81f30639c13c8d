"""Fitting a body to tracked points: inverse kinematics over landmarks, by mink.

Trackers deliver points (and sometimes directions) of body parts; a body wants joint angles. Each landmark is a site
of the agent's model with the tracker's own name for it (``left_elbow``, ``nose``), so a fit is a sum of named tasks,
solved by Newton steps under joint limits::

    fitter = Fitter(scene, "P1")
    fit = fitter.fit(state, points={"head": (0.1, 0, 1.6)}, directions={"face": (1, 0, 0)})
    fit.state, fit.errors_m["head"]
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import mink
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices
from taskgist.errors import UnknownNameError
from taskgist.world.assembly import assemble
from taskgist.world.bodies.agent import Agent
from taskgist.world.gathering import SCENE_FILE
from taskgist.world.scene import Scene
from taskgist.world.scene_file import AgentEntry, SceneFile, parse_scene_file
from taskgist.world.state import State

# --- An agent alone: the same body in an empty room, for what takes long where much could move.
#
# Inverse kinematics solves for everything that a model has joints for. In a room with others and with things, most of
# that stays where it is; without them each step takes less than half the time.

EMPTY_ROOM: Mapping[str, bytes] = {"empty.xml": b"<mujoco/>"}
SOME_SEAT_M = 0.45
"""Where nothing is to sit on, the height of a seat must be said; the fitted state has that of the scene."""


@dataclass(frozen=True, eq=False)
class Alone:
    """A model of one agent of a scene and nothing else.

    Attributes:
        model: The model; names are those of the scene.
        agent: The agent in it.
        columns: Index into the scene's qpos of each of the model's, (nq,).
    """

    model: mujoco.MjModel
    agent: Agent
    columns: Indices

    def qpos(self, everywhere: Array) -> Array:
        """The agent's own positions (nq,) among those of the scene, (scene's nq,)."""
        return np.array(everywhere[self.columns])

    def within(self, everywhere: Array, qpos: Array) -> Array:
        """Positions of the scene with the agent's own replaced, (scene's nq,)."""
        changed = np.array(everywhere)
        changed[self.columns] = qpos
        return changed


def alone(scene: Scene, name: str) -> Alone:
    """An agent of a scene, alone.

    Raises:
        UnknownNameError: There is no such agent.
    """
    there = scene.agent(name)
    model, agent = _apart(scene, name) if scene.nq > _count(there) else (scene.model, there)
    columns = np.empty(model.nq, dtype=np.intp)
    columns[agent.base] = np.arange(there.base.start, there.base.stop)
    for joint, column in agent.joints.items():
        columns[column] = there.joints[joint]
    return Alone(model, agent, columns)


def _count(agent: Agent) -> int:
    """How many positions an agent has."""
    return int(agent.base.stop - agent.base.start) + len(agent.joints)


def _apart(scene: Scene, name: str) -> tuple[mujoco.MjModel, Agent]:
    """The agent compiled anew, without the scene."""
    file = parse_scene_file(scene.bundle[SCENE_FILE], where=scene.name)
    (entry,) = (entry for entry in file.agents if entry.name == name)
    (model,) = EMPTY_ROOM
    empty = SceneFile(file.name, model, None, (), (_seated(entry),), file.where)
    assembled = assemble(empty, {**scene.bundle, **EMPTY_ROOM})
    return assembled.model, assembled.agents[name]


def _seated(entry: AgentEntry) -> AgentEntry:
    return replace(entry, seat_height_m=entry.seat_height_m or SOME_SEAT_M, room_body=None)


# --- What a fit asks for, as tasks of mink's: many points, or many directions, at once.
#
# Errors are differences of positions in the world. (A frame's own task measures them in the frame, by the logarithm
# of a whole pose: then the same distance weighs up to half as much again for a body that faces the other way.)

POSTURE_COST = 1e-3
"""Pull towards the posture of rest for joints that nothing else decides."""
STIFF: Mapping[str, float] = {"girdle": 20.0, "torso": 10.0, "torso_side": 40.0, "head_roll": 40.0, "wrist": 3.0}
"""How much more reluctantly joints move than others, by words in their names: people bend sideways last (ours)."""
DAMPING = 1e-3
"""Share of the squared error that is added to the diagonal: steps stay short while the targets are far."""


@dataclass(frozen=True)
class Marker:
    """A point that is fixed to a body near one of its landmarks: a marker on the skin, another tracker's joint.

    Attributes:
        landmark: The landmark beside which it lies.
        offset_m: From there to it, metres, along the axes that the body has in its zero configuration.
        axes: The landmark with whose body the offset turns; empty: the same landmark.
    """

    landmark: str
    offset_m: tuple[float, float, float]
    axes: str = ""


@dataclass(frozen=True, eq=False)
class FixedPoints:
    """Points that are fixed to bodies, n of them.

    Attributes:
        sites: The site beside which each lies.
        frames: The site with whose axes its offset turns.
        offsets_m: From the one to the point, in the axes of the other, metres, (n, 3).
    """

    sites: tuple[int, ...]
    frames: tuple[int, ...]
    offsets_m: Array

    def places(self, data: mujoco.MjData) -> Array:
        """Where they are in the world, metres, (n, 3)."""
        return np.asarray(data.site_xpos[list(self.sites)] + self.levers(data))

    def levers(self, data: mujoco.MjData) -> Array:
        """The offsets in the world, metres, (n, 3)."""
        matrices = data.site_xmat[list(self.frames)].reshape(-1, 3, 3)
        return np.asarray((matrices @ self.offsets_m[:, :, None])[:, :, 0])


class PointsTask(mink.Task):
    """Points of bodies at places.

    Args:
        points: The points, n of them.
        targets_m: Where they should be in the world, metres, (n, 3).
        costs: Weight of each, (n,).
    """

    def __init__(self, points: FixedPoints, targets_m: Array, costs: Array) -> None:
        super().__init__(cost=np.repeat(costs, 3), lm_damping=DAMPING)
        self._points = points
        self._targets_m = targets_m

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """Point minus target, metres, (3 n,)."""
        return np.asarray((self._points.places(configuration.data) - self._targets_m).ravel())

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """How it changes with the configuration, (3 n, nv): that of the site, and that of the lever, turn × lever."""
        model, data, points = configuration.model, configuration.data, self._points
        jacobian = np.zeros((3 * len(points.sites), model.nv))
        turn = np.zeros((3, model.nv))
        for row, (site, frame, lever) in enumerate(zip(points.sites, points.frames, points.levers(data), strict=True)):
            rows = jacobian[3 * row : 3 * row + 3]
            mujoco.mj_jacSite(model, data, rows, None, site)
            if lever.any():
                mujoco.mj_jacSite(model, data, None, turn, frame)
                rows -= _cross_matrix(lever) @ turn
        return jacobian


class DirectionsTask(mink.Task):
    """Axes of sites along directions.

    Args:
        sites: Indices of the sites, n of them.
        axes: The axis of each in its own frame, (n, 3), of length 1.
        targets: Where they should point in the world, (n, 3), of length 1.
        costs: Weight of each, (n,).
    """

    def __init__(self, sites: Sequence[int], axes: Array, targets: Array, costs: Array) -> None:
        super().__init__(cost=np.repeat(costs, 3), lm_damping=DAMPING)
        self._sites = list(sites)
        self._axes = axes
        self._targets = targets

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """Axis minus target, (3 n,): the chord between them, nearly the angle in radians while it is small."""
        return np.asarray((self.pointing(configuration) - self._targets).ravel())

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """How it changes with the configuration, (3 n, nv): an axis changes by turn × axis."""
        model, data = configuration.model, configuration.data
        jacobian = np.zeros((3 * len(self._sites), model.nv))
        turn = np.zeros((3, model.nv))
        for row, (site, axis) in enumerate(zip(self._sites, self.pointing(configuration), strict=True)):
            mujoco.mj_jacSite(model, data, None, turn, site)
            jacobian[3 * row : 3 * row + 3] = -_cross_matrix(axis) @ turn
        return jacobian

    def pointing(self, configuration: mink.Configuration) -> Array:
        """Where the axes point in the world, (n, 3)."""
        matrices = configuration.data.site_xmat[self._sites].reshape(-1, 3, 3)
        return np.asarray((matrices @ self._axes[:, :, None])[:, :, 0])


def _cross_matrix(vector: Array) -> Array:
    """The matrix that multiplies as the cross product with a vector does."""
    x, y, z = vector
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


def posture_costs(model: mujoco.MjModel, agent: Agent) -> Array:
    """Pull of each degree of freedom towards the posture of rest, (nv,)."""
    cost = np.full(model.nv, POSTURE_COST)
    for joint in agent.joints:
        stiffness = max((factor for word, factor in STIFF.items() if word in joint), default=1.0)
        cost[int(model.joint(f"{agent.name}/{joint}").dofadr[0])] *= stiffness
    return cost


# --- The words of a fit: which joints may move, which points and directions of a body can be asked for.

ARMS = ("girdle", "shoulder", "elbow", "forearm", "wrist")
MOVING: Mapping[str, tuple[str, ...]] = {
    "arms": ARMS,
    "upper_body": ("torso", *ARMS),
    "trunk_and_arms": ("torso", "head", *ARMS),
}
"""Named sets of joints that a fit may move, by words in the joints' names; ``body`` moves everything, the root too."""

Axis = tuple[str, tuple[float, float, float]]
"""A landmark, and an axis in its frame."""

AXES: Mapping[str, Axis] = {
    "face": ("eye", (1.0, 0.0, 0.0)),
    "head_up": ("eye", (0.0, 0.0, 1.0)),
    "left_hand": ("left_wrist", (0.0, 0.0, -1.0)),
    "right_hand": ("right_wrist", (0.0, 0.0, -1.0)),
    "left_palm": ("left_wrist", (0.0, -1.0, 0.0)),
    "right_palm": ("right_wrist", (0.0, 1.0, 0.0)),
    "left_thumb": ("left_wrist", (1.0, 0.0, 0.0)),
    "right_thumb": ("right_wrist", (1.0, 0.0, 0.0)),
    "pelvis": ("pelvis", (1.0, 0.0, 0.0)),
    "pelvis_up": ("pelvis", (0.0, 0.0, 1.0)),
    "chest": ("chest", (1.0, 0.0, 0.0)),
}
"""Directions that a fit may ask for: a landmark, and the axis of its frame. Of hands: to the fingers, out of the palm,
to the thumb."""


def landmarks(scene: Scene, agent: str) -> tuple[str, ...]:
    """Names of the landmarks that an agent's model has."""
    return landmarks_in(scene.model, agent)


def landmarks_in(model: mujoco.MjModel, agent: str) -> tuple[str, ...]:
    """Names of an agent's landmarks in a model."""
    prefix = f"{agent}/"
    names = (str(model.site(s).name) for s in range(model.nsite))
    return tuple(name.removeprefix(prefix) for name in names if name.startswith(prefix))


def chosen_joints(agent: Agent, moving: str | Collection[str]) -> Iterable[str]:
    """Names of the joints that may move.

    Args:
        agent: Whose.
        moving: A name of ``MOVING``, ``"body"``, or names of joints.

    Raises:
        UnknownNameError: There is no such set of joints, or no such joint.
    """
    if not isinstance(moving, str):
        for joint in moving:
            if joint not in agent.joints:
                raise UnknownNameError("joint", joint, agent.joints, where=agent.name)
        return moving
    if moving == "body":
        return agent.joints
    if moving not in MOVING:
        raise UnknownNameError("set of joints", moving, ("body", *MOVING))
    return [joint for joint in agent.joints if any(word in joint for word in MOVING[moving])]


def free_dofs(model: mujoco.MjModel, agent: Agent, moving: Iterable[str], *, root: bool) -> set[int]:
    """Degrees of freedom of some of an agent's joints, and of its root if that moves, too."""
    starts = [int(model.joint(f"{agent.name}/{joint}").dofadr[0]) for joint in moving]
    base = int(model.body_dofadr[agent.root_body])
    return {*starts, *(range(base, base + 6) if root else ())}


IkTask = PointsTask | DirectionsTask | mink.PostureTask

DIRECTION_COST_M = 0.15
"""Lever with which an error of direction (radians) counts like an error of place (metres)."""
STEP_DAMPING = 3e-4
"""Pull of a step towards none: joints that the targets hardly decide would else swing to and fro. With 3e-4 a frame of
noisy keypoints needs 6 steps, with 1e-6 it needs 14 and ends no better."""
CONVERGED_RAD = 2e-4
LONGEST_STEP = 0.5
"""Radians or metres that one step may change a joint by."""
HALVINGS = 8
NEGLIGIBLE_GAIN = 1e-4
"""Share of the error below which a step is the last one."""


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted state and how well it meets its targets.

    Attributes:
        state: The state with the agent fitted.
        errors_m: Distance in metres between each landmark and its target.
        errors_rad: Angle between each direction and its target.
    """

    state: State
    errors_m: Mapping[str, float]
    errors_rad: Mapping[str, float]


class Fitter:
    """Fits one agent of a scene, other things staying where they are.

    Args:
        scene: The scene.
        agent: Name of the agent to fit.
        moving: A name of ``fit_words.MOVING``, ``"body"``, or the names of the joints that may move.
        root: Whether the root moves too; by default with ``"body"`` only.
        weights: Relative cost of a landmark or direction; 1 where none is given.
        markers: Points that are no landmarks of the body but lie beside one, by the names that ``fit`` gets them under.
        axes: Directions of the body that differ from ``AXES``, or are not among them: a landmark, and the axis in its
            frame, of length 1.
        damping: Pull of a step towards none; less than by default where the targets are exact.
    """

    def __init__(
        self,
        scene: Scene,
        agent: str,
        *,
        moving: str | Collection[str] = "body",
        root: bool | None = None,
        weights: Mapping[str, float] | None = None,
        markers: Mapping[str, Marker] | None = None,
        axes: Mapping[str, Axis] | None = None,
        damping: float = STEP_DAMPING,
    ) -> None:
        self._damping = damping
        self._markers = dict(markers or {})
        self._axes = {**AXES, **(axes or {})}
        self._alone = alone(scene, agent)
        self._agent = self._alone.agent
        self._weights = dict(weights or {})
        self._configuration = mink.Configuration(self._model)
        self._limits = [mink.ConfigurationLimit(self._model)]
        self._frozen = self._freeze(moving, root=moving == "body" if root is None else root)
        self._posture = mink.PostureTask(self._model, cost=posture_costs(self._model, self._agent))

    @property
    def _model(self) -> mujoco.MjModel:
        return self._alone.model

    def _freeze(self, moving: str | Collection[str], *, root: bool) -> list[mink.DofFreezingTask]:
        """Hold every degree of freedom that must not move."""
        free = free_dofs(self._model, self._agent, chosen_joints(self._agent, moving), root=root)
        frozen = [dof for dof in range(self._model.nv) if dof not in free]
        return [mink.DofFreezingTask(self._model, dof_indices=frozen)] if frozen else []

    def fit(
        self,
        state: State,
        *,
        points: Mapping[str, ArrayLike] | None = None,
        directions: Mapping[str, ArrayLike] | None = None,
        rest: State | None = None,
        iterations: int = 30,
    ) -> Fit:
        """Fit the agent.

        Args:
            state: Where to start from; everything but the agent's moving joints stays.
            points: Targets of landmarks in the world, metres, (3,) each; those that are not finite are left out.
            directions: Targets of directions (``fit_words.AXES``) in the world, (3,) each.
            rest: The posture that joints lean to where nothing else decides; by default the one to start from.
            iterations: Most Newton steps.

        Raises:
            UnknownNameError: The model has no such landmark or direction.
        """
        wanted = {name: np.asarray(p, dtype=float) for name, p in (points or {}).items() if np.all(np.isfinite(p))}
        aimed = {name: np.asarray(d, dtype=float) for name, d in (directions or {}).items() if np.all(np.isfinite(d))}
        tasks: list[IkTask] = [*self._point_tasks(wanted), *self._direction_tasks(aimed)]
        self._configuration.update(self._alone.qpos(state.qpos))
        self._posture.set_target(self._alone.qpos((rest or state).qpos))
        self._descend([*tasks, self._posture], iterations)
        fitted = State(self._alone.within(state.qpos, self._configuration.q), state.time_s, state.untracked)
        return Fit(fitted, self._point_errors(wanted), self._direction_errors(aimed))

    def _descend(self, tasks: list[IkTask], iterations: int) -> None:
        """Newton steps until none changes much, or there were enough."""
        cost = _cost(tasks, self._configuration)
        for _ in range(iterations):
            cost, change = self._improve(tasks, cost)
            if change < CONVERGED_RAD:
                return

    def _improve(self, tasks: list[IkTask], cost: float) -> tuple[float, float]:
        """One Newton step, shortened until it helps.

        Returns:
            The cost after it, and the largest change in radians or metres: 0 if no step helps.
        """
        configuration, before = self._configuration, np.array(self._configuration.q)
        step = mink.solve_ik(
            configuration, tasks, 1.0, "daqp", damping=self._damping, limits=self._limits, constraints=self._frozen
        )
        step = step * min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        for _ in range(HALVINGS):
            configuration.integrate_inplace(step, 1.0)
            if (now := _cost(tasks, configuration)) < cost:
                return now, float(np.abs(step).max()) if now < (1 - NEGLIGIBLE_GAIN) * cost else 0.0
            configuration.update(before)
            step = step / 2
        return cost, 0.0

    def _point_tasks(self, points: Mapping[str, Array]) -> list[PointsTask]:
        if not points:
            return []
        costs = np.array([self._weights.get(name, 1.0) for name in points])
        return [PointsTask(self._fixed(points), np.array(list(points.values())), costs)]

    def _fixed(self, names: Iterable[str]) -> FixedPoints:
        markers = [self._markers.get(name, Marker(name, (0.0, 0.0, 0.0))) for name in names]
        return FixedPoints(
            sites=tuple(self._site(marker.landmark) for marker in markers),
            frames=tuple(self._site(marker.axes or marker.landmark) for marker in markers),
            offsets_m=np.array([marker.offset_m for marker in markers]),
        )

    def _direction_tasks(self, directions: Mapping[str, Array]) -> list[DirectionsTask]:
        if not directions:
            return []
        targets = np.array(list(directions.values()))
        targets /= np.linalg.norm(targets, axis=1, keepdims=True)
        costs = DIRECTION_COST_M * np.array([self._weights.get(name, 1.0) for name in directions])
        sites, axes = zip(*map(self._axis, directions), strict=True)
        return [DirectionsTask([self._site(site) for site in sites], np.array(axes), targets, costs)]

    def _point_errors(self, points: Mapping[str, Array]) -> dict[str, float]:
        if not points:
            return {}
        places = self._fixed(points).places(self._configuration.data)
        return {
            name: float(np.linalg.norm(at - target)) for at, (name, target) in zip(places, points.items(), strict=True)
        }

    def _direction_errors(self, directions: Mapping[str, Array]) -> dict[str, float]:
        errors = {}
        for name, direction in directions.items():
            site, axis = self._axis(name)
            matrix = self._configuration.data.site_xmat[self._site(site)].reshape(3, 3)
            cosine = float(matrix @ np.array(axis) @ direction / np.linalg.norm(direction))
            errors[name] = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return errors

    def _axis(self, name: str) -> Axis:
        if name not in self._axes:
            raise UnknownNameError("direction", name, self._axes, where=self._agent.name)
        return self._axes[name]

    def _site(self, landmark: str) -> int:
        site = int(mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_SITE, f"{self._agent.name}/{landmark}"))
        if site < 0:
            raise UnknownNameError("landmark", landmark, landmarks_in(self._model, self._agent.name))
        return site


def _cost(tasks: Iterable[IkTask], at: mink.Configuration) -> float:
    """Weighted sum of squared errors."""
    return float(sum(np.sum((task.cost * task.compute_error(at)) ** 2) for task in tasks))
