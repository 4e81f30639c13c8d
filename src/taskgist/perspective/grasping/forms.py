"""Forms: what an object's shapes are in its own frame, whatever the scene.

The same mug stands in many scenes, and its grasps are the same in all of them. Two objects of one form have equal
shapes, equally placed; only the indices of these differ.
"""

from __future__ import annotations

import hashlib

import numpy as np

from taskgist.perspective.grasping.grasps import Indices
from taskgist.world import Stage


def shapes_of(bench: Stage, name: str) -> Indices:
    """Indices of all shapes of an object, seen and solid ones, in order, (n,)."""
    return np.union1d(bench.scene.seen_geoms(name), bench.scene.solid_geoms_of(name))


def form_of(bench: Stage, name: str) -> str:
    """Digest of an object's form.

    Args:
        bench: A stage on which the object's frame is the world's.
        name: The object.
    """
    scene, model = bench.scene, bench.scene.model
    shapes = shapes_of(bench, name)
    digest = hashlib.sha256()
    for array in (
        np.isin(shapes, scene.seen_geoms(name)),
        np.isin(shapes, scene.solid_geoms_of(name)),
        model.geom_type[shapes],
        model.geom_size[shapes],
        *bench.geoms(shapes),
    ):
        digest.update(np.ascontiguousarray(array).tobytes())
    for mesh in model.geom_dataid[shapes].tolist():
        digest.update(_mesh_bytes(bench, mesh) if mesh >= 0 else b"-")
    return digest.hexdigest()


def _mesh_bytes(bench: Stage, mesh: int) -> bytes:
    model = bench.scene.model
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    return bytes(vertices.tobytes() + faces.tobytes())
