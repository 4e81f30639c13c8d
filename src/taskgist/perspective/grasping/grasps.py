"""Grasps: values, by index, in an object's frame or in the world (5.1.3)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Pose

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
PER_GRASP = ("centers", "closings", "approaches", "widths_m", "gaps_m", "in_itself", "shapes", "touching")


@dataclass(frozen=True, eq=False)
class Grasps:
    """Sampled grasps, in the object's frame or, once placed, in the world.

    Attributes:
        centers: Half-way between the two points that the hand closes on, metres, (n, 3).
        closings: Unit directions from the thumb's point to the fingers', (n, 3).
        approaches: Unit directions in which the palm comes, (n, 3).
        widths_m: How far the two points are apart, (n,).
        gaps_m: How far fingers and thumb each stand off their point before they close, (n,).
        in_itself: Whether the hand would be in the object itself, other than where it closes on it, (n,).
        shapes: The seen shapes that the points lie on, (n, 2).
        solids: The object's solid shapes, (k,).
        touching: Whether a grasp's fingers touch each of these by design, (n, k).
        narrowest_m: Width of the object's narrowest opposite points, whether the hand opens that wide or not; None if
            it has no opposite faces.
    """

    centers: Array
    closings: Array
    approaches: Array
    widths_m: Array
    gaps_m: Array
    in_itself: NDArray[np.bool_]
    shapes: Indices
    solids: Indices
    touching: NDArray[np.bool_]
    narrowest_m: float | None

    def __len__(self) -> int:
        return len(self.centers)

    def placed(self, pose: Pose) -> Grasps:
        """The same grasps in the world, of an object that stands there."""
        turn = pose.matrix.T
        return replace(
            self,
            centers=pose.to_world(self.centers),
            closings=self.closings @ turn,
            approaches=self.approaches @ turn,
        )

    def only(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> Grasps:
        """Some of them."""
        return replace(self, **{field: getattr(self, field)[rows] for field in PER_GRASP})
