"""Embree by way of trimesh: one ray through each pixel, into triangles."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.peers.eye_view import EyeView
from benchmarks.peers.triangles import triangles

Array = NDArray[np.float64]


class Embree:
    """Casts rays of an eye; the tree over all triangles is built once, and not counted.

    Args:
        view: The eye.

    Raises:
        ImportError: trimesh or embreex is not installed.
    """

    name = "trimesh with embree"

    def __init__(self, view: EyeView) -> None:
        trimesh: Any = importlib.import_module("trimesh")
        ray: Any = importlib.import_module("trimesh.ray.ray_pyembree")
        self._view = view
        corners, faces, owners = _all_triangles(view)
        self._owners = np.append(owners, -1).astype(np.int32)
        mesh: Any = trimesh.Trimesh(corners, faces, process=False)
        self._caster: Any = ray.RayMeshIntersector(mesh)
        self._rays = view.rays()
        self._origins = np.tile(view.position, (len(self._rays), 1))

    def image(self) -> NDArray[np.int32]:
        """The shape in each pixel, −1 for none, (height, width)."""
        width, height = self._view.size_px
        return self.cast(np.arange(width * height)).reshape(height, width)

    def cast(self, pixels: NDArray[np.intp]) -> NDArray[np.int32]:
        """The shape in some pixels, −1 for none, (n,)."""
        hit = self._caster.intersects_first(self._origins[pixels], self._rays[pixels])
        return np.asarray(self._owners[hit])

    def cone(self, geoms: NDArray[np.intp]) -> NDArray[np.intp]:
        """Pixels in the bounding cones of some shapes, (n,)."""
        data, radii = self._view.data, self._view.scene.model.geom_rbound[geoms]
        offsets = data.geom_xpos[geoms] - self._view.position
        far = np.linalg.norm(offsets, axis=1)
        inside = np.sqrt(np.maximum(0.0, 1 - (radii / far) ** 2)) * far
        along = self._rays @ offsets.T
        return np.flatnonzero(((along >= inside) | (far <= radii)).any(axis=1))

    def close(self) -> None:
        """Nothing to give back."""


def _all_triangles(view: EyeView) -> tuple[Array, NDArray[np.int32], NDArray[np.int32]]:
    """Corners and triangles of all shapes in the world, and which shape each triangle belongs to."""
    corners, faces, owners, first = [], [], [], 0
    for geom in view.geoms:
        local, own = triangles(view.scene.model, geom)
        corners.append(local @ view.data.geom_xmat[geom].reshape(3, 3).T + view.data.geom_xpos[geom])
        faces.append(own + first)
        owners.append(np.full(len(own), geom))
        first += len(local)
    return np.concatenate(corners), np.concatenate(faces), np.concatenate(owners).astype(np.int32)
