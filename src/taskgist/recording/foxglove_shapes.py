"""MuJoCo's shapes as Foxglove's primitives. Foxglove gives whole edges and diameters, MuJoCo halves and radii."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from taskgist.world import Pose, Scene
from taskgist.world.geometry.rotations import wxyz_from_matrix

Message = dict[str, Any]
Drawn = Iterator[tuple[str, Message]]
"""Pairs of a list in a foxglove.SceneEntity, such as "cubes", and a primitive for it."""

LISTS = ("cubes", "spheres", "cylinders", "triangles")
PLANE_EDGE_M = 10.0
"""Edge of a floor that has none."""

_PLANE_THICKNESS_M = 0.002
_DECIMALS = 5


def primitives(scene: Scene, geom: int, pose: Pose) -> Drawn:
    """How a shape of a scene is drawn; kinds that Foxglove has no primitive for are left out.

    Args:
        scene: The scene.
        geom: Index of the shape.
        pose: Where it is, in the frame of the entity.
    """
    draw = _DRAWERS.get(int(scene.model.geom_type[geom]))
    for kind, primitive in () if draw is None else draw(scene, geom, pose):
        yield kind, primitive | {"color": _color(scene, geom)}


def pose_message(pose: Pose) -> Message:
    """A foxglove.Pose."""
    w, x, y, z = _rounded(wxyz_from_matrix(pose.matrix))
    return {"position": vector(pose.position), "orientation": {"x": x, "y": y, "z": z, "w": w}}


def vector(values: Any) -> Message:
    """A foxglove.Vector3, or foxglove.Point3."""
    x, y, z = _rounded(values)
    return {"x": x, "y": y, "z": z}


def _box(scene: Scene, geom: int, pose: Pose) -> Drawn:
    yield "cubes", {"pose": pose_message(pose), "size": vector(2.0 * scene.model.geom_size[geom])}


def _plane(scene: Scene, geom: int, pose: Pose) -> Drawn:
    half_x, half_y, _ = scene.model.geom_size[geom]
    size = (2.0 * half_x or PLANE_EDGE_M, 2.0 * half_y or PLANE_EDGE_M, _PLANE_THICKNESS_M)
    beneath = Pose(pose.to_world((0.0, 0.0, -_PLANE_THICKNESS_M / 2)), pose.matrix)
    yield "cubes", {"pose": pose_message(beneath), "size": vector(size)}


def _sphere(scene: Scene, geom: int, pose: Pose) -> Drawn:
    diameter = 2.0 * scene.model.geom_size[geom][0]
    yield "spheres", {"pose": pose_message(pose), "size": vector((diameter, diameter, diameter))}


def _ellipsoid(scene: Scene, geom: int, pose: Pose) -> Drawn:
    yield "spheres", {"pose": pose_message(pose), "size": vector(2.0 * scene.model.geom_size[geom])}


def _cylinder(scene: Scene, geom: int, pose: Pose) -> Drawn:
    radius, half_length, _ = scene.model.geom_size[geom]
    size = vector((2.0 * radius, 2.0 * radius, 2.0 * half_length))
    yield "cylinders", {"pose": pose_message(pose), "size": size, "bottom_scale": 1.0, "top_scale": 1.0}


def _capsule(scene: Scene, geom: int, pose: Pose) -> Drawn:
    half_length = scene.model.geom_size[geom][1]
    yield from _cylinder(scene, geom, pose)
    for end in (-half_length, half_length):
        yield from _sphere(scene, geom, Pose(pose.to_world((0.0, 0.0, end)), pose.matrix))


def _mesh(scene: Scene, geom: int, pose: Pose) -> Drawn:
    model = scene.model
    mesh = int(model.geom_dataid[geom])
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    triangles = {"points": [vector(vertex) for vertex in vertices], "indices": np.ravel(faces).tolist(), "colors": []}
    yield "triangles", {"pose": pose_message(pose), **triangles}


_DRAWERS: dict[int, Callable[[Scene, int, Pose], Drawn]] = {
    0: _plane,
    2: _sphere,
    3: _capsule,
    4: _ellipsoid,
    5: _cylinder,
    6: _box,
    7: _mesh,
}
"""By MuJoCo's numbers of kinds, mjtGeom."""


def _color(scene: Scene, geom: int) -> Message:
    model = scene.model
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return dict(zip("rgba", (round(float(channel), 3) for channel in rgba), strict=True))


def _rounded(values: Any) -> list[float]:
    rounded: list[float] = (np.round(np.asarray(values, dtype=np.float64), _DECIMALS) + 0.0).tolist()
    return rounded
