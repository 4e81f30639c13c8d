"""Concave meshes become what they are: a bin can be reached into, a handle grasped.

MuJoCo collides a mesh as its convex hull, while its rays meet the true triangles. Therefore a mesh with hollows keeps
its looks and stops to collide; convex parts collide in its place, in a group that nobody sees. The parts are files of
the scene's bundle, so that a recording's scene is the same everywhere. Agents' links stay hulls: only whether head,
torso and base push into things is asked of them.
"""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np

from taskgist.errors import SceneError
from taskgist.world.geometry.convex_parts import parts_name, parts_text, read_parts, tolerance_m
from taskgist.world.geometry.mesh_pieces import Array, Piece, hollow_m, joined

SOLID_GROUP = 3
"""Geom group of shapes that block but are not seen."""
PART = "/part"
"""What the name of a part begins with, behind the name of its whole."""


def decompose(
    spec: mujoco.MjSpec, compiled: Callable[[mujoco.MjSpec], mujoco.MjModel], files: dict[str, bytes], where: str
) -> None:
    """Let convex parts collide in the place of a model's concave meshes.

    Args:
        spec: The model of room and objects; changed.
        compiled: Compiles it; only asked if there is a mesh that collides.
        files: The bundle of the scene; files with the parts are added where they are missing.
        where: File name for error messages.

    Raises:
        SceneError: A file with parts is damaged.
    """
    solid = [geom for geom in spec.geoms if _collides(geom)]
    if not solid:
        return
    model = compiled(spec)
    parts = {name: _parts(spec, model, name, files, where) for name in dict.fromkeys(g.meshname for g in solid)}
    for geom in solid:
        if parts[geom.meshname]:
            _replace(geom, parts[geom.meshname])


def whole(name: str) -> str:
    """Name of the shape that a part belongs to; other names stay as they are."""
    return name.partition(PART)[0]


def _collides(geom: mujoco.MjsGeom) -> bool:
    return geom.type == mujoco.mjtGeom.mjGEOM_MESH and bool(geom.contype or geom.conaffinity)


def _parts(
    spec: mujoco.MjSpec, model: mujoco.MjModel, name: str, files: dict[str, bytes], where: str
) -> tuple[str, ...]:
    """Names of the meshes of a concave mesh's parts; none for a convex one."""
    mesh = _mesh(model, name)
    if hollow_m(mesh) <= tolerance_m(mesh):
        return ()
    key = parts_name(mesh)
    text = files[key] if key in files else parts_text(mesh, name)
    if text is None:
        return ()
    files[key] = text
    try:
        found = read_parts(text)
    except (ValueError, IndexError) as error:
        hint = "delete it, and it is made anew"
        raise SceneError(
            f"damaged convex parts of mesh {name!r}: {error}", where=f"{where}: {key}", hint=hint
        ) from error
    for number, vertices in enumerate(found):
        spec.add_mesh(name=f"{name}{PART}{number}", uservert=vertices.ravel())
    return tuple(f"{name}{PART}{number}" for number in range(len(found)))


def _mesh(model: mujoco.MjModel, name: str) -> Piece:
    """A compiled mesh in the frame of its file."""
    mesh = model.mesh(name).id
    vertices: Array = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]].astype(np.intp)
    turn = np.zeros(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[mesh].astype(float))
    return joined(vertices @ turn.reshape(3, 3).T + model.mesh_pos[mesh], faces)


def _replace(geom: mujoco.MjsGeom, parts: tuple[str, ...]) -> None:
    """The shape is only seen from now on; its parts, which weigh nothing, collide."""
    for number, part in enumerate(parts):
        added = geom.parent.add_geom(
            name=f"{geom.name}{PART}{number}" if geom.name else "",
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=part,
            pos=geom.pos,
            quat=geom.quat,
            contype=geom.contype,
            conaffinity=geom.conaffinity,
            friction=geom.friction,
            condim=geom.condim,
            group=SOLID_GROUP,
            mass=0,
        )
        for field in ("type", "axisangle", "euler", "xyaxes", "zaxis"):  # other ways to say how it is turned
            setattr(added.alt, field, getattr(geom.alt, field))
    geom.contype = geom.conaffinity = 0
