"""The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.judge import Miss
from taskgist.perspective.standpoint import Standpoint
from taskgist.perspective.virtual_actions import stretch
from taskgist.world import Arm, ArmIndices, Pose

Array = NDArray[np.float64]
ROUNDING = 1e-9


def arms_of(here: Standpoint) -> tuple[ArmIndices, ...]:
    """The agent's arms that may be stretched out."""
    return tuple(arm for arm in here.agent.arms if stretch(arm.profile.side) in here.actions)


@dataclass(frozen=True, eq=False)
class Reached:
    """Which points an arm reaches.

    Attributes:
        inside: Whether each point is reached, (n,).
        distances_m: How far each is from the shoulder, (n,).
    """

    inside: NDArray[np.bool_]
    distances_m: Array

    def nearest_first(self) -> NDArray[np.intp]:
        """Indices of the reached points by distance, equal ones in their own order."""
        indices = np.flatnonzero(self.inside)
        return indices[np.argsort(np.round(self.distances_m[indices], 6), kind="stable")]

    def miss(self, arm: Arm) -> Miss:
        """Why no point is reached."""
        if not len(self.distances_m):
            return Miss(float("inf"), "has no surface")
        nearest = float(self.distances_m.min())
        if nearest > arm.length_m:
            why = f"{nearest:.2f} m from the {arm.side} shoulder, {nearest - arm.length_m:.2f} m beyond the arm"
            return Miss(nearest - arm.length_m, why)
        return Miss(0.0, f"outside the sector of the {arm.side} arm")


def within_reach(shoulder: Pose, arm: Arm, points: Array) -> Reached:
    """Which points lie within an arm's length of the shoulder and inside its sector.

    Args:
        shoulder: The shoulder's place, in the frame of what carries the arm (x forward, z up).
        arm: Length and sector; the right arm's azimuth is mirrored.
        points: Metres, in the world, (n, 3).
    """
    local = shoulder.to_local(points)
    distances_m = np.sqrt(np.einsum("ij,ij->i", local, local))
    inside = distances_m <= arm.length_m + ROUNDING
    if inside.any():
        outward = -local[:, 1] if arm.side == "right" else local[:, 1]
        azimuth = np.arctan2(outward, local[:, 0])
        elevation = np.arctan2(local[:, 2], np.hypot(local[:, 0], local[:, 1]))
        inside = inside & _between(azimuth, arm.azimuth_rad) & _between(elevation, arm.elevation_rad)
    return Reached(inside, distances_m)


def _between(angles: Array, limits: tuple[float, float]) -> NDArray[np.bool_]:
    return np.asarray((angles >= limits[0] - ROUNDING) & (angles <= limits[1] + ROUNDING))
