"""An agent in a compiled scene: its profile, with every name resolved to MuJoCo's indices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.errors import SceneError
from taskgist.world.body.derived import completed, site_index
from taskgist.world.body.hands import GHOST_GROUP, ghosts_of
from taskgist.world.body.profile import AgentProfile, Arm

SEEN_GROUPS = (0, 1, 2)
"""Geom groups that rays meet: MuJoCo shows them by default and keeps 3 for collision shapes."""
SEEN_MASK = np.array([group in SEEN_GROUPS for group in range(6)], dtype=np.uint8)

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class ArmIndices:
    """One arm: its profile and its indices.

    ``ghosts`` are the geoms of a virtual grasp, in the order of ``hand_boxes``; ``carrier_body`` is what the arm hangs
    on.
    """

    profile: Arm
    shoulder_site: int
    palm_site: int
    hand_body: int
    carrier_body: int
    geoms: Indices
    hand_geoms: Indices
    ghosts: Indices

    @cached_property
    def sector(self) -> NDArray[np.float64]:
        """Length in metres, whether mirrored, azimuths and elevations in radians: for compiled functions, (6,)."""
        arm = self.profile
        return np.array((arm.length_m, arm.side == "right", *arm.azimuth_rad, *arm.elevation_rad), dtype=np.float64)


@dataclass(frozen=True, eq=False)
class Agent:
    """An agent: name, profile, and where its joints, sites and shapes are in the model.

    Attributes:
        base: Slice of qpos (7): position in metres and wxyz of the root.
        joints: qpos index of each scalar joint, by its name without prefix, in the model's order.
        core_geoms: Solid shapes of head, torso and base: those that virtual actions must not push into things.
        geoms: All its shapes but the ghosts.
    """

    name: str
    profile: AgentProfile
    stature_m: float
    base: slice
    joints: Mapping[str, int]
    root_body: int
    bodies: Indices
    geoms: Indices
    core_geoms: Indices
    eye_site: int
    eye_exclude_body: int
    thigh_bodies: tuple[int, ...]
    arms: tuple[ArmIndices, ...]
    parts: Mapping[str, Indices]

    def arm(self, side: str) -> ArmIndices:
        """The arm of that side."""
        for arm in self.arms:
            if arm.profile.side == side:
                return arm
        raise SceneError("no such arm", where=self.name, field="side", value=side)

    @property
    def sides(self) -> tuple[str, ...]:
        """Sides on which the agent has an arm."""
        return tuple(arm.profile.side for arm in self.arms)


def resolve_agent(model: mujoco.MjModel, name: str, profile: AgentProfile, stature_m: float) -> Agent:
    """Find an attached agent's joints, sites and shapes in a compiled model; all names were checked before."""
    profile = completed(model, name, profile)
    bodies = np.array([b for b in range(model.nbody) if model.body(b).name.startswith(f"{name}/")])
    root = int(bodies[0])
    base = int(model.jnt_qposadr[model.body_jntadr[root]])
    geoms = _geoms_of(model, bodies)
    arms = tuple(_resolve_arm(model, name, arm) for arm in profile.arms)
    arm_geoms = np.concatenate([arm.geoms for arm in arms]) if arms else np.array([], dtype=np.intp)
    _, _, eye = profile.frames[0]
    return Agent(
        name=name,
        profile=profile,
        stature_m=stature_m,
        base=slice(base, base + 7),
        joints=_scalar_joints(model, name, bodies),
        root_body=root,
        bodies=bodies,
        geoms=geoms,
        core_geoms=solid(model, np.setdiff1d(geoms, arm_geoms)),
        eye_site=site_index(model, name, "eye_frame", eye.name),
        eye_exclude_body=_body(model, name, profile.eye.exclude),
        thigh_bodies=tuple(_body(model, name, thigh) for thigh in profile.legs.thighs),
        arms=arms,
        parts=_parts(model, name, profile, bodies),
    )


_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def _scalar_joints(model: mujoco.MjModel, name: str, bodies: Indices) -> dict[str, int]:
    """Index into qpos of each joint that turns or slides, by its name without prefix."""
    return {
        model.joint(j).name.removeprefix(f"{name}/"): int(model.jnt_qposadr[j])
        for j in range(model.njnt)
        if model.jnt_bodyid[j] in bodies and int(model.jnt_type[j]) in _SCALAR
    }


def _body(model: mujoco.MjModel, agent: str, name: str) -> int:
    return int(model.body(f"{agent}/{name}").id)


def _resolve_arm(model: mujoco.MjModel, agent: str, arm: Arm) -> ArmIndices:
    root, hand = _body(model, agent, arm.root), _body(model, agent, arm.hand)
    hand_geoms = _geoms_of(model, subtree(model, hand))
    return ArmIndices(
        profile=arm,
        shoulder_site=site_index(model, agent, f"{arm.side}_shoulder_frame", arm.shoulder.name),
        palm_site=site_index(model, agent, f"{arm.side}_palm_frame", arm.palm.name),
        hand_body=hand,
        carrier_body=_body(model, agent, arm.carrier) if arm.carrier else int(model.body_parentid[root]),
        geoms=_geoms_of(model, subtree(model, root)),
        hand_geoms=solid(model, hand_geoms) if len(solid(model, hand_geoms)) else hand_geoms,
        ghosts=np.array(ghosts_of(model, hand), dtype=np.intp),
    )


def solid(model: mujoco.MjModel, geoms: Indices) -> Indices:
    """Those shapes that collide with something: URDF has others that are only shown."""
    return np.asarray(geoms[(model.geom_contype[geoms] != 0) | (model.geom_conaffinity[geoms] != 0)])


def _parts(model: mujoco.MjModel, agent: str, profile: AgentProfile, bodies: Indices) -> dict[str, Indices]:
    """The bodies of each part: as the profile has it, else what the joints of its actions and its arms make of it.

    Each arm is all that hangs on its root, the head all that the head's joints move, the torso what carries them, and
    what is left, wheels or legs, carries the torso.
    """
    if profile.parts:
        return {part: np.array([_body(model, agent, b) for b in names]) for part, names in profile.parts}
    roots = {f"{arm.side}_arm": _body(model, agent, arm.root) for arm in profile.arms}
    necks = [int(model.joint(f"{agent}/{axis.joint}").bodyid[0]) for axis in (profile.pan, profile.tilt) if axis]
    roots["head"] = min(necks, default=_body(model, agent, profile.eye.exclude))
    parts = {part: np.array(subtree(model, root)) for part, root in roots.items()}
    carriers = {body for root in roots.values() for body in _ancestors(model, root)}
    rest = set(bodies.tolist()) - carriers - {int(body) for part in parts.values() for body in part}
    carrying = {"torso": np.array(sorted(carriers)), "legs": np.array(sorted(rest), dtype=np.intp)}
    return parts | {part: found for part, found in carrying.items() if len(found)}


def _ancestors(model: mujoco.MjModel, body: int) -> set[int]:
    found: set[int] = set()
    while (body := int(model.body_parentid[body])) != 0:
        found.add(body)
    return found


def subtree(model: mujoco.MjModel, root: int) -> list[int]:
    """Indices of a body and all that it carries."""
    inside = {root}
    for body in range(root + 1, model.nbody):  # a parent's index is always below its children's
        if int(model.body_parentid[body]) in inside:
            inside.add(body)
    return sorted(inside)


def _geoms_of(model: mujoco.MjModel, bodies: Iterable[int]) -> Indices:
    of_bodies = np.isin(model.geom_bodyid, list(bodies))
    return np.flatnonzero(of_bodies & (model.geom_group != GHOST_GROUP))
