"""What published models lack, and MuJoCo refuses though geometry does not need it: masses, and the thickness of meshes.

Meshes without thickness (floors, posters, cloth) become sheets. MuJoCo asks a volume of every mesh, and corners in all
three directions of those that collide; of what is nearly flat the library that makes hulls complains on the terminal.
Such a mesh gets ``SHEET_M`` of thickness behind its front, as a file of its own, and is a mesh like others from then
on: seen from both sides, it carries and blocks.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TypeVar

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.world.bodies.meshes import keep_file
from taskgist.world.geometry.pieces import Piece, is_flat, is_line, merged, mesh_of, pieces, thickened

LEAST_MASS_KG, LEAST_INERTIA_KG_M2 = 1e-6, 1e-9
"""What a body without mass gets: the least that MuJoCo lets move."""


Made = TypeVar("Made")


def made_of(spec: mujoco.MjSpec, files: dict[str, bytes], make: Callable[[mujoco.MjSpec], Made]) -> Made:
    """What MuJoCo makes of a model; what it refuses and geometry does not need is mended first, where it does refuse.

    Flat meshes get a thickness, bodies without mass the least that may move, such as a root that is made free, and
    inertias that no body has those of one.

    Args:
        spec: The model, with all of its files as ``assets``; changed where it does not compile as it is.
        files: The bundle, to which new meshes are added.
        make: Compiles the model, for itself or to write it.

    Raises:
        ValueError: MuJoCo refuses it for other reasons.
    """
    try:
        return make(spec)
    except ValueError:
        thicken_flat_meshes(spec, files, [mesh.name for mesh in spec.meshes])
        spec.compiler.balanceinertia = True
        give_least_mass(spec)
        return make(spec)


def give_least_mass(spec: mujoco.MjSpec) -> None:
    """Give those bodies of a model that have no mass the least."""
    spec.compiler.boundmass = max(spec.compiler.boundmass, LEAST_MASS_KG)
    spec.compiler.boundinertia = max(spec.compiler.boundinertia, LEAST_INERTIA_KG_M2)


def has_mass(body: mujoco.MjsBody) -> bool:
    """Whether a body has a mass of its own, by what is said of it or by its shapes."""
    return bool(body.explicitinertial) or any(geom.mass != 0.0 and geom.density != 0.0 for geom in body.geoms)


# --- Meshes without thickness.

FARTHEST_M = 1e6
"""Longest mesh: of longer ones, the library that makes hulls complains on the terminal."""
SHELL = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
COPIED = ("name", "file", "content_type", "scale", "refpos", "refquat", "uservert", "userface")
"""What makes the corners and triangles of a mesh."""
FORGOTTEN = ("uservert", "userface", "usernormal", "userfacenormal", "usertexcoord", "userfacetexcoord")


def thicken_flat_meshes(spec: mujoco.MjSpec, files: dict[str, bytes], names: Collection[str]) -> None:
    """Give a thickness to meshes of a model that have none.

    Args:
        spec: The model, with all of its files as ``assets``; changed.
        files: The bundle, to which the new meshes are added.
        names: The meshes that are looked at.

    Raises:
        SceneError: A mesh is a line, or too long for hulls to be made of it.
    """
    for mesh, piece in _looked_at(spec, names):
        extent_m, field = float(np.ptp(piece.vertices, axis=0).max()), f"mesh {str(mesh.name)!r}"
        if not extent_m <= FARTHEST_M:
            hint = "lengths are in metres: check its corners, and its scale"
            raise SceneError(f"a mesh that is {extent_m:.3g} m long", field=field, hint=hint)
        if is_line(piece):
            raise SceneError("a mesh that is a line, without any area", field=field, hint="make it a thin capsule")
        if _has_no_volume(piece):
            _replace(mesh, piece, spec, files)


def solid_meshes(spec: mujoco.MjSpec) -> set[str]:
    """Names of the meshes that collide, as far as their shapes say so."""
    return {str(geom.meshname) for geom in spec.geoms if geom.meshname and (geom.contype or geom.conaffinity)}


def _looked_at(spec: mujoco.MjSpec, names: Collection[str]) -> list[tuple[mujoco.MjsMesh, Piece]]:
    """Meshes of a model as MuJoCo reads them; those that it cannot read are left to whoever compiles the model."""
    meshes = [mesh for mesh in spec.meshes if mesh.name in names and (mesh.file or len(mesh.uservert))]
    if not meshes:
        return []
    together = _compiled(spec, meshes)
    found = []
    for mesh in meshes:
        model = together or _compiled(spec, [mesh])
        if model is not None:
            found.append((mesh, mesh_of(model, mesh.name)))
    return found


def _compiled(spec: mujoco.MjSpec, meshes: list[mujoco.MjsMesh]) -> mujoco.MjModel | None:
    """A model of nothing but some meshes, as shells, of which no volume is asked."""
    alone = mujoco.MjSpec()
    alone.assets = spec.assets
    for mesh in meshes:
        added = alone.add_mesh()
        for key in COPIED:
            setattr(added, key, getattr(mesh, key))
        added.inertia = SHELL
    try:
        return alone.compile()
    except ValueError:
        return None


LEAST_SHARE = 1e-6
"""A mesh without a volume encloses less than this share of its area times its extent."""


def _has_no_volume(mesh: Piece) -> bool:
    """Whether a mesh is flat, or all of its triangles lie in planes through its middle."""
    if is_flat(mesh):
        return True
    corners = mesh.corners
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas_m2 = np.linalg.norm(doubled, axis=1) / 2
    middle = areas_m2 @ corners.mean(axis=1) / areas_m2.sum()
    volume_m3 = float(np.abs(np.einsum("ij,ij->i", corners[:, 0] - middle, doubled)).sum()) / 6
    return volume_m3 < LEAST_SHARE * float(areas_m2.sum() * np.ptp(mesh.vertices, axis=0).max())


def _replace(mesh: mujoco.MjsMesh, flat: Piece, spec: mujoco.MjSpec, files: dict[str, bytes]) -> None:
    """Let a mesh be a closed one, whose flat pieces have a thickness."""
    flat = merged(flat)
    sheets = [thickened(each, front_m=0.0) if is_flat(each) else each for each in _apart(flat)]
    starts = np.cumsum([0, *(len(sheet.vertices) for sheet in sheets)])
    faces = np.concatenate([sheet.faces + start for sheet, start in zip(sheets, starts, strict=False)])
    content = _as_obj(np.concatenate([sheet.vertices for sheet in sheets]), faces)
    mesh.file = keep_file(files, f"{mesh.name.replace('/', '_')}.sheet.obj", content)
    spec.assets = {**spec.assets, mesh.file: content}
    mesh.content_type = ""
    mesh.scale, mesh.refpos, mesh.refquat = (1, 1, 1), (0, 0, 0), (1, 0, 0, 0)
    for key in FORGOTTEN:
        setattr(mesh, key, [])


def _apart(flat: Piece) -> list[Piece]:
    return [flat] if is_flat(flat) else pieces(flat)


def _as_obj(vertices: Array, faces: Array) -> bytes:
    lines = ["# a flat mesh with a thickness"]
    lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices]
    lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
    return ("\n".join(lines) + "\n").encode()
