"""PyBullet's Tiny Renderer: software, triangles, segmentation by body."""

from __future__ import annotations

import importlib
import warnings
from types import ModuleType
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.triangles import triangles

NEAR_M, FAR_M = 0.01, 50.0


def pybullet() -> ModuleType:
    """The library.

    Raises:
        ImportError: It is not installed.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # its C module warns of Python's own changes
        return importlib.import_module("pybullet")


class TinyRenderer:
    """Draws the whole image of an eye.

    Args:
        view: The eye.

    Raises:
        ImportError: PyBullet is not installed.
    """

    name = "PyBullet's Tiny Renderer"

    def __init__(self, view: EyeView) -> None:
        self._bullet: Any = pybullet()
        self._view, self._client = view, self._bullet.connect(self._bullet.DIRECT)
        self._geom_of = np.full(len(view.geoms) + 1, -1, dtype=np.int32)
        for geom in view.geoms:
            self._geom_of[self._add(geom)] = geom

    def _add(self, geom: int) -> int:
        bullet, data, wxyz = self._bullet, self._view.data, np.zeros(4)
        mujoco.mju_mat2Quat(wxyz, data.geom_xmat[geom])
        corners, faces = triangles(self._view.scene.model, geom)
        shape = bullet.createVisualShape(
            bullet.GEOM_MESH,
            vertices=corners.tolist(),
            indices=faces.ravel().tolist(),
            physicsClientId=self._client,
        )
        return int(
            bullet.createMultiBody(
                baseVisualShapeIndex=shape,
                basePosition=data.geom_xpos[geom].tolist(),
                baseOrientation=wxyz[[1, 2, 3, 0]].tolist(),
                physicsClientId=self._client,
            )
        )

    def image(self) -> NDArray[np.int32]:
        """The shape in each pixel, −1 for none, (height, width)."""
        bullet, (width, height), (across, up) = self._bullet, self._view.size_px, self._view.half_window
        eye, axes = self._view.position, self._view.axes
        looking = bullet.computeViewMatrix(eye.tolist(), (eye + axes[:, 0]).tolist(), axes[:, 2].tolist())
        # It samples pixels at a corner, others in the middle: half a pixel makes up for it.
        aside, above = across / width, up / height
        window = tuple(NEAR_M * edge for edge in (aside - across, aside + across, above - up, above + up))
        lens = bullet.computeProjectionMatrix(*window, NEAR_M, FAR_M)
        drawn = bullet.getCameraImage(
            width, height, looking, lens, renderer=bullet.ER_TINY_RENDERER, physicsClientId=self._client
        )
        return np.asarray(self._geom_of[np.asarray(drawn[4]).reshape(height, width)])

    def close(self) -> None:
        """Give its memory back."""
        self._bullet.disconnect(self._client)
