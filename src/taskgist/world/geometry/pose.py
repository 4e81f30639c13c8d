"""A pose: a place and an orientation in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pose:
    """A place and an orientation in the world.

    Attributes:
        position: Metres, (3,).
        matrix: Rotation, (3, 3); its columns are the frame's axes in the world.
    """

    position: Array
    matrix: Array

    def to_world(self, points: ArrayLike) -> Array:
        """Points (..., 3) of this frame, in the world."""
        return np.asarray(np.asarray(points) @ self.matrix.T + self.position)

    def to_local(self, points: ArrayLike) -> Array:
        """Points (..., 3) of the world, in this frame."""
        return np.asarray((np.asarray(points) - self.position) @ self.matrix)
