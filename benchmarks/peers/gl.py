"""MuJoCo's own renderer: OpenGL, segmentation by shape, with whatever context can be made here (EGL, OSMesa, GLFW)."""

from __future__ import annotations

import copy
import importlib
import os
import subprocess
import sys
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.eye_view import EyeView

NEAR_M, FAR_M = 0.01, 50.0
HIDDEN_GROUP = 5
BACKENDS = ("egl", "osmesa", "glfw")


class SegmentationRenderer:
    """Draws the whole image of an eye.

    Args:
        view: The eye.
        slices: Slices and stacks of round shapes; MuJoCo's own 28 and 16 if left out.

    Raises:
        RuntimeError: There is no OpenGL here.
    """

    name = "MuJoCo's segmentation renderer"

    def __init__(self, view: EyeView, *, slices: int | None = None) -> None:
        self._view, model = view, copy.copy(view.scene.model)
        seen = set(view.geoms)
        model.geom_group[[g for g in range(model.ngeom) if g not in seen]] = HIDDEN_GROUP
        model.vis.quality.offsamples = 0
        if slices is not None:
            model.vis.quality.numslices = model.vis.quality.numstacks = slices
        width, height = view.size_px
        model.vis.global_.offwidth, model.vis.global_.offheight = width, height
        self._model, self._context = model, _context(width, height)
        self._context.make_current()
        self._scene, self._options = mujoco.MjvScene(model, maxgeom=4 * model.ngeom + 100), mujoco.MjvOption()
        self._scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = self._scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = True
        self._camera, self._perturb = mujoco.MjvCamera(), mujoco.MjvPerturb()
        self._render = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._render)
        self._rectangle, self._drawn = mujoco.MjrRect(0, 0, width, height), np.empty((height, width, 3), dtype=np.uint8)

    def image(self) -> NDArray[np.int32]:
        """The shape in each pixel, −1 for none, (height, width)."""
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            self._model, self._view.data, self._options, self._perturb, self._camera, everything, self._scene
        )
        for camera in self._scene.camera:
            self._look(camera)
        mujoco.mjr_render(self._rectangle, self._scene, self._render)
        mujoco.mjr_readPixels(self._drawn, None, self._rectangle, self._render)
        red, green, blue = (self._drawn[::-1, :, channel].astype(np.int32) for channel in range(3))
        return np.asarray(self._geom_by_color()[red + (green << 8) + (blue << 16)])

    def close(self) -> None:
        """Give OpenGL's memory back."""
        self._render.free()
        self._context.free()

    def _geom_by_color(self) -> NDArray[np.int32]:
        """The shape that each colour stands for."""
        geoms = np.full(self._scene.ngeom + 2, -1, dtype=np.int32)
        for drawn in self._scene.geoms[: self._scene.ngeom]:
            if drawn.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                geoms[drawn.segid + 1] = drawn.objid
        return geoms

    def _look(self, camera: mujoco.MjvGLCamera) -> None:
        across, up = self._view.half_window
        camera.pos, camera.forward, camera.up = self._view.position, self._view.axes[:, 0], self._view.axes[:, 2]
        camera.frustum_near, camera.frustum_far = NEAR_M, FAR_M
        camera.frustum_center, camera.frustum_width = 0.0, NEAR_M * across
        camera.frustum_bottom, camera.frustum_top = -NEAR_M * up, NEAR_M * up
        camera.orthographic = 0


def _context(width: int, height: int) -> Any:
    """An OpenGL context without a window.

    Raises:
        RuntimeError: None can be made here.
    """
    chosen = os.environ.get("MUJOCO_GL")
    for backend in (chosen,) if chosen in BACKENDS else BACKENDS:
        if _works(backend):
            return importlib.import_module(f"mujoco.{backend}").GLContext(width, height)
    raise RuntimeError("no OpenGL here")


PROBE = """
import mujoco, mujoco.{0} as backend
context = backend.GLContext(64, 64)
context.make_current()
mujoco.MjrContext(mujoco.MjModel.from_xml_string("<mujoco/>"), mujoco.mjtFontScale.mjFONTSCALE_100)
"""


@lru_cache
def _works(backend: str) -> bool:
    """Whether a backend draws: tried in another process, for where OpenGL is half installed it ends its own."""
    probe = [sys.executable, "-c", PROBE.format(backend)]
    try:
        return subprocess.run(probe, capture_output=True, timeout=60, check=False).returncode == 0
    except subprocess.TimeoutExpired:
        return False
