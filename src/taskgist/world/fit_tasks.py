"""What a fit asks for, as tasks of mink's: many points, or many directions, at once.

Errors are differences of positions in the world. (A frame's own task measures them in the frame, by the logarithm of a
whole pose: then the same distance weighs up to half as much again for a body that faces the other way.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mink
import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.world.body.agent import Agent

Array = NDArray[np.float64]

POSTURE_COST = 1e-3
"""Pull towards the posture of rest for joints that nothing else decides."""
STIFF: Mapping[str, float] = {"girdle": 20.0, "torso": 10.0, "torso_side": 40.0, "head_roll": 40.0, "wrist": 3.0}
"""How much more reluctantly joints move than others, by words in their names: people bend sideways last (ours)."""
DAMPING = 1e-3
"""Share of the squared error that is added to the diagonal: steps stay short while the targets are far."""


class PointsTask(mink.Task):
    """Sites at places.

    Args:
        sites: Indices of the sites, n of them.
        targets_m: Where they should be in the world, metres, (n, 3).
        costs: Weight of each, (n,).
    """

    def __init__(self, sites: Sequence[int], targets_m: Array, costs: Array) -> None:
        super().__init__(cost=np.repeat(costs, 3), lm_damping=DAMPING)
        self._sites = list(sites)
        self._targets_m = targets_m

    def compute_error(self, configuration: mink.Configuration) -> Array:
        """Site minus target, metres, (3 n,)."""
        return np.asarray((configuration.data.site_xpos[self._sites] - self._targets_m).ravel())

    def compute_jacobian(self, configuration: mink.Configuration) -> Array:
        """How it changes with the configuration, (3 n, nv)."""
        model, data = configuration.model, configuration.data
        jacobian = np.zeros((3 * len(self._sites), model.nv))
        for row, site in enumerate(self._sites):
            mujoco.mj_jacSite(model, data, jacobian[3 * row : 3 * row + 3], None, site)
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
