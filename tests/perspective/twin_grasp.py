"""The twin's grasps: every sampled one is tried, nearest first, against every solid shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from taskgist.perspective.grasp_sampling import Grasps, hand_centers, hand_frames, sample_grasps
from taskgist.world import ArmIndices, Hand, Pose

if TYPE_CHECKING:
    from tests.perspective.twin import Twin

TOUCH_M = 1e-4


class TwinGrasps:
    """All sampled grasps of an object where it is.

    Args:
        twin: Whose, and where.
        name: The object.
    """

    def __init__(self, twin: Twin, name: str) -> None:
        self._twin, self._settings = twin, twin.settings.grasp
        hand = twin.agent.profile.hand
        assert hand is not None
        self._hand = hand
        self._samples = sample_grasps(twin.stage.show(twin.state), name, hand, self._settings)
        self._blocked: dict[int, bool] = {}

    def nearest(self, arm: ArmIndices) -> float | None:
        """Distance from the shoulder of the nearest free grasp, in the state that the twin's world shows."""
        twin, samples = self._twin, self._samples
        distances = twin.within(arm.shoulder_site, arm.carrier_body, arm.profile, samples.centers)
        ahead = samples.centers - twin.world.data.site_xpos[arm.shoulder_site]
        facing = np.sum(samples.approaches * ahead, axis=1)
        distances[facing < self._settings.facing * np.linalg.norm(ahead, axis=1) - 1e-9] = np.inf
        for index in np.argsort(distances):
            if not np.isfinite(distances[index]):
                return None
            if self._free(arm, int(index)):
                return float(distances[index])
        return None

    def _free(self, arm: ArmIndices, index: int) -> bool:
        world, states = self._twin.world, self._twin.states
        for ghost, pose in zip(arm.ghosts, self._poses(index), strict=True):
            world.data.geom_xpos[ghost], world.data.geom_xmat[ghost] = pose.position, pose.matrix.ravel()
        if index not in self._blocked:
            self._blocked[index] = any(
                depth > TOUCH_M and (ghost == arm.ghosts[0] or other not in touched(self._samples, index))
                for (ghost, other), depth in world.depths(arm.ghosts, states.solid).items()
            )
        if self._blocked[index]:
            return False
        return all(depth <= TOUCH_M for depth in world.depths(arm.ghosts, states.core).values())

    def _poses(self, index: int) -> tuple[Pose, ...]:
        return hand_poses(self._samples, index, self._hand)


def hand_poses(grasps: Grasps, index: int, hand: Hand) -> tuple[Pose, ...]:
    """Poses of the boxes of ``hand_boxes`` in one grasp."""
    one = grasps.only(np.array([index]))
    matrix = hand_frames(one)[0]
    return tuple(Pose(center, matrix) for center in hand_centers(one, hand)[0])


def touched(grasps: Grasps, index: int) -> frozenset[int]:
    """The solid shapes that the fingers of a grasp close on."""
    return frozenset(grasps.solids[grasps.touching[index]].tolist())
