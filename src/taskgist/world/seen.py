"""Which shapes of a model are seen, and which of them hide what is behind them.

MuJoCo's groups say it: rays meet shapes in groups 0 to 2, by its convention, and pass all others. A scene file may name
other groups (``seen_groups``), in which the room and its objects are seen then; its agents are as they are.

Where none are named, models that keep coarse shapes for collisions beside fine ones that touch nothing, all of them in
groups that are seen, are recognised: a body looks like its fine shapes if these extend about as far as the coarse ones
do. A label on a box, or a handle, does not, so that box is seen. What the room itself consists of is no one body.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Mask
from taskgist.world.bodies.agent import SEEN_GROUPS
from taskgist.world.bodies.urdf import COLLISION_GROUP

SHOWN_GROUP = 0
"""Group that a shape gets if it is to be seen, and its own is not by convention."""
MIDDLE = 0.6
"""Fine shapes stand for the coarse ones if their box holds so much of the middle of the others' box, each way."""
SIGNS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)


def show_groups(spec: mujoco.MjSpec, groups: Collection[int]) -> None:
    """Let a model's shapes be seen in some groups, 0 to 5, and in no others."""
    for geom in spec.geoms:
        if geom.group in groups:
            geom.group = geom.group if geom.group in SEEN_GROUPS else SHOWN_GROUP
        elif geom.group in SEEN_GROUPS:
            geom.group = COLLISION_GROUP


def hide_stand_ins(spec: mujoco.MjSpec, compiled: Callable[[], mujoco.MjModel]) -> None:
    """Let coarse shapes that only stand for a body in collisions no longer be seen.

    Args:
        spec: The model; its groups are changed.
        compiled: Compiles it; only asked if a body has shapes that touch something and others that do not.
    """
    both = [body for body in spec.bodies[1:] if len({touches(geom) for geom in _seen(body)}) == 2]
    if not both:
        return
    model = compiled()
    for body in both:
        coarse = [geom for geom in _seen(body) if touches(geom)]
        looks = [geom for geom in _seen(body) if not touches(geom)]
        looks = [geom for geom in looks if alphas(model)[geom.id] > 0.0]
        if looks and _stand_for(_box(model, looks), _box(model, coarse)):
            for geom in coarse:
                geom.group = COLLISION_GROUP


def _seen(body: mujoco.MjsBody) -> list[mujoco.MjsGeom]:
    return [geom for geom in body.geoms if geom.group in SEEN_GROUPS]


def touches(geom: mujoco.MjsGeom) -> bool:
    """Whether a shape collides with something."""
    return bool(geom.contype or geom.conaffinity)


def _stand_for(looks: Array, coarse: Array) -> bool:
    """Whether one box, lowest and highest corner (2, 3), holds the middle of another."""
    middle, half = coarse.mean(axis=0), MIDDLE * np.ptp(coarse, axis=0) / 2
    return bool((looks[0] <= middle - half).all() and (looks[1] >= middle + half).all())


def _box(model: mujoco.MjModel, geoms: Sequence[mujoco.MjsGeom]) -> Array:
    """Lowest and highest corner of a box around shapes of one body, in its frame, metres, (2, 3)."""
    corners = []
    for geom in (geom.id for geom in geoms):
        turn = np.zeros(9)
        mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
        local = model.geom_aabb[geom, :3] + SIGNS * model.geom_aabb[geom, 3:]
        corners.append(local @ turn.reshape(3, 3).T + model.geom_pos[geom])
    return np.array((np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))))


def visible_geoms(model: mujoco.MjModel) -> Mask:
    """Whether each shape can be seen: its group is, and it is not wholly transparent, (ngeom,)."""
    return np.isin(model.geom_group, SEEN_GROUPS) & (alphas(model) > 0.0)


def alphas(model: mujoco.MjModel) -> Array:
    """How opaque each shape's colour is, from 0 to 1, (ngeom,). That of its material counts, where it has one."""
    own, materials = model.geom_rgba[:, 3], model.geom_matid
    return np.asarray(np.where(materials < 0, own, model.mat_rgba[materials, 3]) if model.nmat else own)
