"""Shapes of no size: MuJoCo refuses them without saying which one it means."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from taskgist.errors import InputError, SceneError

SIZES = {
    mujoco.mjtGeom.mjGEOM_SPHERE: 1,
    mujoco.mjtGeom.mjGEOM_CAPSULE: 2,
    mujoco.mjtGeom.mjGEOM_CYLINDER: 2,
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: 3,
    mujoco.mjtGeom.mjGEOM_BOX: 3,
}
"""How many sizes each kind of shape has."""


def size_problems(spec: mujoco.MjSpec, where: str) -> Iterator[InputError]:
    """Every shape of a model whose size is zero or less."""
    for geom in spec.geoms:
        if geom.type not in SIZES or geom.meshname:
            continue
        count = 1 if np.isfinite(geom.fromto[0]) else SIZES[geom.type]
        sizes = [float(size) for size in geom.size[:count]]
        if any(size <= 0 for size in sizes):
            kind = geom.type.name.removeprefix("mjGEOM_").lower()
            name = repr(str(geom.name)) if geom.name else "without a name"
            field = f"{kind} {name} of body {str(geom.parent.name)!r}"
            hint = f"give it {count} size{'s' if count > 1 else ''} above zero, in metres"
            yield SceneError("a shape of no size", where=where, field=field, value=sizes, hint=hint)
