"""Fitting a body to tracked points: inverse kinematics over landmarks, by mink.

Trackers deliver points (and sometimes directions) of body parts; a body wants joint angles. Each landmark is a site
of the agent's model with the tracker's own name for it (``left_elbow``, ``nose``), so a fit is a sum of named tasks,
solved by Newton steps under joint limits::

    fitter = Fitter(scene, "P1")
    fit = fitter.fit(state, points={"head": (0.1, 0, 1.6)}, directions={"face": (1, 0, 0)})
    fit.state, fit.errors_m["head"]
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import mink
import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.errors import UnknownNameError
from taskgist.world.alone import alone
from taskgist.world.fit_tasks import DirectionsTask, PointsTask, posture_costs
from taskgist.world.fit_words import AXES, chosen_joints, free_dofs, landmarks_in
from taskgist.world.scene import Scene
from taskgist.world.state import State

Array = NDArray[np.float64]
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
        damping: float = STEP_DAMPING,
    ) -> None:
        self._damping = damping
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
        return [PointsTask([self._site(name) for name in points], np.array(list(points.values())), costs)]

    def _direction_tasks(self, directions: Mapping[str, Array]) -> list[DirectionsTask]:
        if not directions:
            return []
        targets = np.array(list(directions.values()))
        targets /= np.linalg.norm(targets, axis=1, keepdims=True)
        costs = DIRECTION_COST_M * np.array([self._weights.get(name, 1.0) for name in directions])
        sites, axes = zip(*map(self._axis, directions), strict=True)
        return [DirectionsTask([self._site(site) for site in sites], np.array(axes), targets, costs)]

    def _point_errors(self, points: Mapping[str, Array]) -> dict[str, float]:
        places = self._configuration.data.site_xpos
        return {name: float(np.linalg.norm(places[self._site(name)] - p)) for name, p in points.items()}

    def _direction_errors(self, directions: Mapping[str, Array]) -> dict[str, float]:
        errors = {}
        for name, direction in directions.items():
            site, axis = self._axis(name)
            matrix = self._configuration.data.site_xmat[self._site(site)].reshape(3, 3)
            cosine = float(matrix @ np.array(axis) @ direction / np.linalg.norm(direction))
            errors[name] = float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        return errors

    def _axis(self, name: str) -> tuple[str, tuple[float, float, float]]:
        if name not in AXES:
            raise UnknownNameError("direction", name, AXES, where=self._agent.name)
        return AXES[name]

    def _site(self, landmark: str) -> int:
        site = int(mujoco.mj_name2id(self._model, mujoco.mjtObj.mjOBJ_SITE, f"{self._agent.name}/{landmark}"))
        if site < 0:
            raise UnknownNameError("landmark", landmark, landmarks_in(self._model, self._agent.name))
        return site


def _cost(tasks: Iterable[IkTask], at: mink.Configuration) -> float:
    """Weighted sum of squared errors."""
    return float(sum(np.sum((task.cost * task.compute_error(at)) ** 2) for task in tasks))
