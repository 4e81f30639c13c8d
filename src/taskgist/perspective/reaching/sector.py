"""The sector of an arm: which points lie within its length of the shoulder, and in front of it (5.1.2).

Shoulders are given in the frame of what carries the arm, x forward and z up; the right arm's azimuth is mirrored.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.judge import Miss
from taskgist.world import Arm, ArmIndices
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
ROUNDING = 1e-9
DIGITS = 6
"""Distances that agree to so many digits are equal, wherever the scene stands."""
NOWHERE = -1


def arms_of(here: Standpoint) -> tuple[int, ...]:
    """Indices of the agent's arms that may be stretched out."""
    arms = here.agent.arms
    return tuple(index for index, arm in enumerate(arms) if stretch(arm.profile.side) in here.actions)


@dataclass(frozen=True, eq=False)
class Reaching:
    """What n shoulders of one arm reach of some points.

    Attributes:
        nearest: The nearest point that each reaches, −1 for none, (n,); of equally near ones the first.
        reach_m: How far it is, infinite for none, (n,).
        gap_m: How far the nearest point of all is from each, whether in the sector or not, (n,); where that is beyond
            the arm, a lower bound.
    """

    nearest: NDArray[np.intp]
    reach_m: Array
    gap_m: Array

    def miss(self, shoulders: Array, arm: Arm, points: Array, asked: NDArray[np.bool_]) -> Miss:
        """Why no shoulder of those asked, (n,), reaches any of the points: the one that is nearest to one."""
        if not len(points):
            return Miss(math.inf, "has no surface")
        index = int(np.argmin(np.where(asked, self.gap_m, np.inf)))
        gap_m = float(np.linalg.norm(points - shoulders[index], axis=1).min())
        if gap_m > arm.length_m:
            beyond_m = gap_m - arm.length_m
            far = f"{beyond_m:.2f} m" if beyond_m >= 0.005 else f"{1000 * beyond_m:.1f} mm"
            why = f"{gap_m:.2f} m from the {arm.side} shoulder, {far} beyond the arm"
            return Miss(beyond_m, why, lambda: {"arm": arm.side, "beyond_m": beyond_m})
        return Miss(0.0, f"outside the sector of the {arm.side} arm", lambda: {"arm": arm.side})


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points, and a ball around them: those far from it need not be looked at one by one.

    Attributes:
        points: Metres, in the world, (k, 3).
        middle: Centre of the ball, (3,).
        radius_m: Its radius.
    """

    points: Array
    middle: Array
    radius_m: float

    @classmethod
    def of(cls, points: Array) -> Cloud:
        """The cloud of some points, (k, 3)."""
        if not len(points):
            return cls(points, np.zeros(3), 0.0)
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        offset = points - middle
        return cls(points, middle, float(np.sqrt(np.einsum("ij,ij->i", offset, offset).max())))


def reaching(shoulders: Array, carriers: Array, arm: ArmIndices, cloud: Cloud) -> Reaching:
    """What shoulders reach.

    Args:
        shoulders: Their positions in metres, (n, 3).
        carriers: Orientation of what carries them, (n, 3, 3).
        arm: Length and sector.
        cloud: The points.
    """
    sector = _sector(arm.profile)
    return Reaching(*_reaching(shoulders, carriers, *sector, cloud.points, cloud.middle, cloud.radius_m))


def grasps_in_reach(
    shoulder: Array, carrier: Array, arm: ArmIndices, centers: Array, approaches: Array, facing: float
) -> NDArray[np.intp]:
    """Indices of the grasps that one shoulder reaches, but for those from behind: nearest first, ties in their order.

    Args:
        shoulder: Its position, metres, (3,).
        carrier: Orientation of what carries it, (3, 3).
        arm: Length and sector.
        centers: Where the grasps are, metres, (k, 3).
        approaches: Unit directions in which the palm comes, (k, 3).
        facing: Least cosine between the approach and the direction from the shoulder to the grasp.
    """
    distances = _distances(shoulder, carrier, *_sector(arm.profile), centers, approaches, facing)
    indices = np.flatnonzero(np.isfinite(distances))
    return indices[np.argsort(np.round(distances[indices], DIGITS), kind="stable")]


def _sector(arm: Arm) -> tuple[float, bool, tuple[float, float], tuple[float, float]]:
    return arm.length_m, arm.side == "right", arm.azimuth_rad, arm.elevation_rad


@compiled
def _reaching(
    shoulders: Array,
    carriers: Array,
    length_m: float,
    mirrored: bool,
    azimuth_rad: tuple[float, float],
    elevation_rad: tuple[float, float],
    points: Array,
    middle: Array,
    radius_m: float,
) -> tuple[NDArray[np.intp], Array, Array]:
    count = len(shoulders)
    nearest, reach, gap = np.full(count, NOWHERE), np.full(count, np.inf), np.full(count, np.inf)
    for i in range(count):
        if not len(points):
            continue
        gap[i] = max(distance_m(shoulders[i], middle) - radius_m, 0.0)
        if gap[i] > length_m + ROUNDING:
            continue
        gap[i], least = np.inf, np.inf
        for k in range(len(points)):
            at_m = distance_m(shoulders[i], points[k])
            gap[i] = min(gap[i], at_m)
            rounded = round(at_m, DIGITS)
            nearer = at_m <= length_m + ROUNDING and rounded < least
            if nearer and _inside(shoulders[i], carriers[i], mirrored, azimuth_rad, elevation_rad, points[k]):
                nearest[i], reach[i], least = k, at_m, rounded
    return nearest, reach, gap


@compiled
def _distances(
    shoulder: Array,
    carrier: Array,
    length_m: float,
    mirrored: bool,
    azimuth_rad: tuple[float, float],
    elevation_rad: tuple[float, float],
    centers: Array,
    approaches: Array,
    facing: float,
) -> Array:
    """Distance of each grasp from a shoulder that reaches it from the front, infinite where it does not, (k,)."""
    distances = np.full(len(centers), np.inf)
    for k in range(len(centers)):
        at_m, center, approach = distance_m(shoulder, centers[k]), centers[k], approaches[k]
        if at_m > length_m + ROUNDING:
            continue
        along = 0.0
        for axis in range(3):
            along += approach[axis] * (center[axis] - shoulder[axis])
        if along >= facing * at_m - ROUNDING and _inside(
            shoulder, carrier, mirrored, azimuth_rad, elevation_rad, center
        ):
            distances[k] = at_m
    return distances


@compiled
def distance_m(a: Array, b: Array) -> float:
    """Distance between two points (3,)."""
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    return math.sqrt(x * x + y * y + z * z)


@compiled
def _inside(
    shoulder: Array,
    carrier: Array,
    mirrored: bool,
    azimuth_rad: tuple[float, float],
    elevation_rad: tuple[float, float],
    point: Array,
) -> bool:
    """Whether a point lies in the direction of a sector."""
    dx, dy, dz = point[0] - shoulder[0], point[1] - shoulder[1], point[2] - shoulder[2]
    x = dx * carrier[0, 0] + dy * carrier[1, 0] + dz * carrier[2, 0]
    y = dx * carrier[0, 1] + dy * carrier[1, 1] + dz * carrier[2, 1]
    z = dx * carrier[0, 2] + dy * carrier[1, 2] + dz * carrier[2, 2]
    azimuth = math.atan2(-y if mirrored else y, x)
    elevation = math.atan2(z, math.hypot(x, y))
    return (
        azimuth_rad[0] - ROUNDING <= azimuth <= azimuth_rad[1] + ROUNDING
        and elevation_rad[0] - ROUNDING <= elevation <= elevation_rad[1] + ROUNDING
    )
