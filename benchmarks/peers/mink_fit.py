"""A body fitted by mink, a quadratic program a step: the witness of our own steps, and slower than they are."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import mink
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array
from taskgist.world import Scene
from taskgist.world.fit import (
    AXES,
    DIRECTION_COST_M,
    POSTURE_COST,
    STEP_DAMPING,
    STIFF,
    Axis,
    Marker,
    alone,
    chosen_joints,
)
from taskgist.world.fit_steps import CONVERGED_RAD, HALVINGS, LM_DAMPING, LONGEST_STEP, NEGLIGIBLE_GAIN


class PointsTask(mink.Task):
    """Points of bodies at places: each beside a site, by an offset along the axes of a site.

    Args:
        sites: Index of the site beside which each lies, and of that with which its offset turns, (n, 2).
        offsets_m: The offsets, metres, (n, 3).
        targets_m: Where the points should be in the world, metres, (n, 3).
        costs: Weight of each, (n,).
    """

    def __init__(self, sites: Sequence[tuple[int, int]], offsets_m: Array, targets_m: Array, costs: Array) -> None:
        super().__init__(cost=np.repeat(costs, 3), lm_damping=LM_DAMPING)
        self._sites, self._offsets_m, self._targets_m = sites, offsets_m, targets_m

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """Point minus target, metres, (3 n,)."""
        places = configuration.data.site_xpos[[site for site, _ in self._sites]] + self._levers(configuration)
        return np.asarray((places - self._targets_m).ravel())

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """How it changes with the configuration, (3 n, nv): that of the site, and that of the lever, turn × lever."""
        model, data = configuration.model, configuration.data
        jacobian, turn = np.zeros((3 * len(self._sites), model.nv)), np.zeros((3, model.nv))
        for row, ((site, frame), lever) in enumerate(zip(self._sites, self._levers(configuration), strict=True)):
            rows = jacobian[3 * row : 3 * row + 3]
            mujoco.mj_jacSite(model, data, rows, None, site)
            mujoco.mj_jacSite(model, data, None, turn, frame)
            rows -= cross_matrix(lever) @ turn
        return jacobian

    def _levers(self, configuration: mink.Configuration) -> Array:
        matrices = configuration.data.site_xmat[[frame for _, frame in self._sites]].reshape(-1, 3, 3)
        return np.asarray((matrices @ self._offsets_m[:, :, None])[:, :, 0])


class DirectionsTask(mink.Task):
    """Axes of sites along directions.

    Args:
        sites: Indices of the sites, n of them.
        axes: The axis of each in its own frame, (n, 3), of length 1.
        targets: Where they should point in the world, (n, 3), of length 1.
        costs: Weight of each, (n,).
    """

    def __init__(self, sites: Sequence[int], axes: Array, targets: Array, costs: Array) -> None:
        super().__init__(cost=np.repeat(costs, 3), lm_damping=LM_DAMPING)
        self._sites, self._axes, self._targets = list(sites), axes, targets

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """Axis minus target, (3 n,)."""
        return np.asarray((self._pointing(configuration) - self._targets).ravel())

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """How it changes with the configuration, (3 n, nv): an axis changes by turn × axis."""
        model, data = configuration.model, configuration.data
        jacobian, turn = np.zeros((3 * len(self._sites), model.nv)), np.zeros((3, model.nv))
        for row, (site, axis) in enumerate(zip(self._sites, self._pointing(configuration), strict=True)):
            mujoco.mj_jacSite(model, data, None, turn, site)
            jacobian[3 * row : 3 * row + 3] = -cross_matrix(axis) @ turn
        return jacobian

    def _pointing(self, configuration: mink.Configuration) -> Array:
        matrices = configuration.data.site_xmat[self._sites].reshape(-1, 3, 3)
        return np.asarray((matrices @ self._axes[:, :, None])[:, :, 0])


def cross_matrix(vector: Array) -> Array:
    """The matrix that multiplies as the cross product with a vector does."""
    x, y, z = vector
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


class MinkFitter:
    """Fits one agent, as ``taskgist.world.Fitter`` does, with the same arguments.

    Args:
        scene: The scene.
        name: Name of the agent to fit.
        moving: What may move, as for ``Fitter``.
        root: Whether the root moves, too.
        weights: Relative costs.
        markers: Points beside landmarks.
        axes: Directions beside ``AXES``.
        damping: Pull of a step towards none.
    """

    def __init__(
        self,
        scene: Scene,
        name: str,
        *,
        moving: str | Collection[str] = "body",
        root: bool = True,
        weights: Mapping[str, float] | None = None,
        markers: Mapping[str, Marker] | None = None,
        axes: Mapping[str, Axis] | None = None,
        damping: float = STEP_DAMPING,
    ) -> None:
        self._alone, self._damping = alone(scene, name), damping
        self._weights, self._markers, self._axes = dict(weights or {}), dict(markers or {}), {**AXES, **(axes or {})}
        model, agent = self._alone.model, self._alone.agent
        self._configuration = mink.Configuration(model)
        self._limits = [mink.ConfigurationLimit(model)]
        base = int(model.body_dofadr[agent.root_body])
        free = {self._dof(joint) for joint in chosen_joints(agent, moving)} | set(range(base, base + 6) if root else ())
        frozen = [dof for dof in range(model.nv) if dof not in free]
        self._frozen = [mink.DofFreezingTask(model, dof_indices=frozen)] if frozen else []
        costs = np.full(model.nv, POSTURE_COST)
        for joint in agent.joints:
            costs[self._dof(joint)] *= max((factor for word, factor in STIFF.items() if word in joint), default=1.0)
        self._posture = mink.PostureTask(model, cost=costs)

    def fit(
        self,
        qpos: Array,
        points: Mapping[str, ArrayLike],
        directions: Mapping[str, ArrayLike],
        *,
        rest: Array,
        iterations: int,
    ) -> tuple[Array, float]:
        """The scene's positions, (nq,), and the cost that they leave.

        Args:
            qpos: Where to start from, (nq,).
            points: Targets of points, metres, all known.
            directions: Targets of directions, of length 1, all known.
            rest: The posture that joints lean to, (nq,).
            iterations: Most steps.
        """
        tasks = [*self._points(points), *self._directions(directions), self._posture]
        self._configuration.update(self._alone.qpos(qpos))
        self._posture.set_target(self._alone.qpos(rest))
        cost = self._cost(tasks)
        for _ in range(iterations):
            cost, change = self._improve(tasks, cost)
            if change < CONVERGED_RAD:
                break
        return self._alone.within(qpos, self._configuration.q), cost

    def _improve(self, tasks: Sequence[mink.Task], cost: float) -> tuple[float, float]:
        """One step, shortened until it helps: the cost after it, and the largest change; 0 if none helps."""
        configuration, before = self._configuration, np.array(self._configuration.q)
        step = mink.solve_ik(
            configuration, tasks, 1.0, "daqp", damping=self._damping, limits=self._limits, constraints=self._frozen
        )
        step = step * min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        for _ in range(HALVINGS):
            configuration.integrate_inplace(step, 1.0)
            if (now := self._cost(tasks)) < cost:
                return now, float(np.abs(step).max()) if now < (1 - NEGLIGIBLE_GAIN) * cost else 0.0
            configuration.update(before)
            step = step / 2
        return cost, 0.0

    def _cost(self, tasks: Iterable[mink.Task]) -> float:
        return float(sum(np.sum((task.cost * task.compute_error(self._configuration)) ** 2) for task in tasks))

    def _points(self, points: Mapping[str, ArrayLike]) -> list[PointsTask]:
        if not points:
            return []
        markers = [self._markers.get(name, Marker(name, (0.0, 0.0, 0.0))) for name in points]
        sites = [(self._site(each.landmark), self._site(each.axes or each.landmark)) for each in markers]
        offsets_m, targets_m = np.array([each.offset_m for each in markers]), np.array(list(points.values()))
        return [PointsTask(sites, offsets_m, targets_m, self._costs(points))]

    def _directions(self, directions: Mapping[str, ArrayLike]) -> list[DirectionsTask]:
        if not directions:
            return []
        sites, axes = zip(*(self._axes[name] for name in directions), strict=True)
        targets = np.array(list(directions.values()))
        costs = DIRECTION_COST_M * self._costs(directions)
        return [DirectionsTask([self._site(site) for site in sites], np.array(axes), targets, costs)]

    def _costs(self, names: Iterable[str]) -> Array:
        return np.array([self._weights.get(name, 1.0) for name in names])

    def _dof(self, joint: str) -> int:
        return int(self._alone.model.joint(f"{self._alone.agent.name}/{joint}").dofadr[0])

    def _site(self, landmark: str) -> int:
        return int(self._alone.model.site(f"{self._alone.agent.name}/{landmark}").id)
