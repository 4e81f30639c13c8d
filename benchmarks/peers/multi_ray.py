"""One call of MuJoCo's mj_multiRay with a ray through every pixel: what perspective would do without any thought."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.eye_view import SEEN, EyeView


class MultiRay:
    """Casts the whole image of an eye.

    Args:
        view: The eye.
    """

    name = "one whole-image mj_multiRay"

    def __init__(self, view: EyeView) -> None:
        self._view, self._rays = view, np.ascontiguousarray(view.rays()).ravel()
        self._groups = np.array([group in SEEN for group in range(6)], dtype=np.uint8)

    def image(self) -> NDArray[np.int32]:
        """The shape in each pixel, −1 for none, (height, width)."""
        view, (width, height) = self._view, self._view.size_px
        count = width * height
        geoms, distances = np.full(count, -1, dtype=np.int32), np.empty(count)
        mujoco.mj_multiRay(
            view.scene.model,
            view.data,
            view.position,
            self._rays,
            self._groups,
            True,
            view.agent.eye_exclude_body,
            geoms,
            distances,
            None,
            count,
            mujoco.mjMAXVAL,
        )
        return geoms.reshape(height, width)

    def close(self) -> None:
        """Nothing to give back."""
