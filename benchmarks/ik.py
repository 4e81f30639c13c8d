"""Inverse kinematics of one arm, as a witness: only chosen joints move, within their limits, from many starts.

The shoulder girdle stays at rest: joints that move the shoulder itself are no part of the arm. What ball-and-socket
joints do not do, though their hinges would, is not counted.

Built on mink and the solver daqp. A single start may end in a local minimum; "not reached" is said only after all.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterable, Mapping

import mink
import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from taskgist.world import Agent, ArmIndices, Scene, State

Array = NDArray[np.float64]
STEPS, STALLED_M = 60, 1e-4
"""Steps from one start, and progress in five of them below which it has ended."""
DAMPING, INSIDE_RAD = 1e-3, 1e-3


class ArmIK:
    """Brings the palm of an arm to points.

    Args:
        scene: The scene.
        state: From where; all but the chosen joints stay as they are.
        agent: Whose arm.
        arm: Which.
        also: Further joints that may move, with their ranges in radians, by name.
        starts: How many configurations to start from; the first is the state's own.
        seed: Of the others.
    """

    def __init__(
        self,
        scene: Scene,
        state: State,
        agent: Agent,
        arm: ArmIndices,
        *,
        also: Mapping[str, tuple[float, float]] | None = None,
        starts: int = 8,
        seed: int = 0,
    ) -> None:
        self._model = model = copy.copy(scene.model)
        self._palm = arm.palm_site
        joints = [j for j in range(model.njnt) if _in_arm(model, int(model.jnt_bodyid[j]), arm)]
        joints = [joint for joint in joints if not _moves_shoulder(model, joint, arm)]
        self._chain, self._bodies = arm.chain, (arm.carrier_body, _limbs(model, joints, arm))
        for name, limits in (also or {}).items():
            joint = int(model.joint(f"{agent.name}/{name}").id)
            model.jnt_range[joint], model.jnt_limited[joint] = limits, True
            joints.append(joint)
        self._configuration = mink.Configuration(model)
        self._task = mink.FrameTask(
            model.site(self._palm).name, "site", position_cost=1.0, orientation_cost=0.0, lm_damping=DAMPING
        )
        moving = {int(model.jnt_dofadr[joint]) for joint in joints}
        self._fixed = mink.DofFreezingTask(model, [dof for dof in range(model.nv) if dof not in moving])
        self._limits = [mink.ConfigurationLimit(model)]
        self._starts = self._some(joints, np.array(state.qpos), starts, np.random.default_rng(seed))

    def gap_m(self, target: Array, *, enough_m: float) -> float:
        """How near the palm comes to a point, metres; search ends where it is near enough.

        Args:
            target: In the world, metres, (3,).
            enough_m: Near enough.
        """
        best = np.inf
        for start in self._starts:
            best = min(best, self._from(start, target, enough_m))
            if best <= enough_m:
                break
        return float(best)

    def brings(self, target: Array, *, enough_m: float, free: Callable[[Array], bool]) -> bool:
        """Whether the palm comes near enough to a point in a configuration that is free.

        Args:
            target: In the world, metres, (3,).
            enough_m: Near enough.
            free: Tells of a configuration, (nq,), whether nothing is in the way.
        """
        return any(
            self._from(start, target, enough_m) <= enough_m and free(np.array(self._configuration.q))
            for start in self._starts
        )

    def _from(self, start: Array, target: Array, enough_m: float) -> float:
        self._configuration.update(start)
        self._task.set_target(mink.SE3.from_translation(target))
        gaps = [self._gap(target)]
        while gaps[-1] > enough_m and len(gaps) <= STEPS:
            velocity = mink.solve_ik(
                self._configuration, [self._task], 1.0, "daqp", DAMPING, limits=self._limits, constraints=[self._fixed]
            )
            self._configuration.integrate_inplace(velocity, 1.0)
            gaps.append(self._gap(target))
            if len(gaps) > 5 and gaps[-6] - gaps[-1] < STALLED_M:
                break
        return min(gaps) if not self._too_far().any() else self._brought_back(target)

    def _brought_back(self, target: Array) -> float:
        """How near the palm comes where it ends up in what the joints do; infinite if it does not."""
        low, high = self._ranges
        q = np.array(self._configuration.q)

        def off(angles: Array) -> Array:
            q[self._indices] = angles
            self._configuration.update(q)
            return np.concatenate((self._configuration.data.site_xpos[self._palm] - target, self._too_far()))

        start = np.clip(q[self._indices], low + INSIDE_RAD, high - INSIDE_RAD)
        least_squares(off, start, bounds=(low, high), max_nfev=STEPS)
        return self._gap(target) if self._too_far().max() <= INSIDE_RAD else np.inf

    def _too_far(self) -> Array:
        """How far limbs point, and are twisted, beyond what ball-and-socket joints let them, radians, (2 l,)."""
        carrier, limbs = self._bodies
        data, found = self._configuration.data, []
        for row, limb in zip(self._chain.limits, limbs, strict=True):
            turned = data.xmat[carrier].reshape(3, 3).T @ data.xmat[limb].reshape(3, 3)
            quaternion = np.empty(4)
            mujoco.mju_mat2Quat(quaternion, turned.ravel())
            twist_rad = 2 * math.atan2(abs(float(quaternion[1:] @ row[1:4])), abs(quaternion[0]))
            cosine = float(np.clip((turned @ row[1:4]) @ row[4:7], -1.0, 1.0))
            found += [max(0.0, math.acos(row[7]) - math.acos(cosine)), max(0.0, twist_rad - row[8])]
        return np.array(found) if found else np.zeros(1)

    def _some(self, joints: list[int], now: Array, count: int, rng: np.random.Generator) -> list[Array]:
        """The present configuration, brought into its limits, and others at random in the joints' ranges."""
        model = self._model
        self._indices = indices = [int(model.jnt_qposadr[joint]) for joint in joints]
        ranges = [model.jnt_range[joint] if model.jnt_limited[joint] else (-np.pi, np.pi) for joint in joints]
        self._ranges = low, high = np.array(ranges).T
        starts = [np.array(now)]
        starts[0][indices] = np.clip(now[indices], low, high)
        while len(starts) < count:
            start = np.array(now)
            start[indices] = rng.uniform(low, high)
            self._configuration.update(start)
            if not self._too_far().any():
                starts.append(start)
        return starts

    def _gap(self, target: Array) -> float:
        return float(np.linalg.norm(self._configuration.data.site_xpos[self._palm] - target))


def _limbs(model: mujoco.MjModel, joints: Iterable[int], arm: ArmIndices) -> list[int]:
    """The bodies that ball-and-socket joints carry."""
    bodies = [int(model.jnt_bodyid[joint]) for joint in sorted(joints)]
    return [bodies[int(row[0]) - 1] for row in arm.chain.limits]


def _in_arm(model: mujoco.MjModel, body: int, arm: ArmIndices) -> bool:
    """Whether a body is the arm's own: nearer to the hand than what carries the arm."""
    while body not in (0, arm.carrier_body):
        if body == _root(model, arm):
            return True
        body = int(model.body_parentid[body])
    return False


def _moves_shoulder(model: mujoco.MjModel, joint: int, arm: ArmIndices) -> bool:
    """Whether turning a joint by a tenth of a radian moves the arm's shoulder by more than a millimetre."""
    data = mujoco.MjData(model)
    places = []
    for by in (0.0, 0.1):
        data.qpos[:] = model.qpos0
        data.qpos[model.jnt_qposadr[joint]] += by
        mujoco.mj_kinematics(model, data)
        places.append(data.site_xpos[arm.shoulder_site].copy())
    return bool(np.linalg.norm(places[1] - places[0]) > 1e-3)


def _root(model: mujoco.MjModel, arm: ArmIndices) -> int:
    """The arm's first body."""
    agent = str(model.body(arm.hand_body).name).partition("/")[0]
    return int(model.body(f"{agent}/{arm.profile.root}").id)
