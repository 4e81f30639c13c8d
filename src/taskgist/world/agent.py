"""An agent in a compiled scene: its profile, with every name resolved to MuJoCo's indices."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.errors import SceneError
from taskgist.world.profile import AgentProfile, Arm

SEEN_GROUPS = (0, 1, 2)
"""Geom groups that rays meet: MuJoCo shows them by default and keeps 3 for collision shapes."""
SEEN_MASK = np.array([group in SEEN_GROUPS for group in range(6)], dtype=np.uint8)
GHOST_GROUP = 5
"""Geom group of the shapes with which virtual grasps are tested: never seen, never touched."""
GHOST_SHAPES = ("palm", "fingers", "thumb")

Indices = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class ArmIndices:
    """One arm: its profile and its indices.

    ``ghosts`` are the geoms of a virtual grasp: palm, fingers, thumb; ``carrier_body`` is what the arm hangs on.
    """

    profile: Arm
    shoulder_site: int
    palm_site: int
    hand_body: int
    carrier_body: int
    geoms: Indices
    hand_geoms: Indices
    ghosts: Indices


@dataclass(frozen=True, eq=False)
class Agent:
    """An agent: name, profile, and where its joints, sites and shapes are in the model.

    Attributes:
        base: Slice of qpos (7): position in metres and wxyz of the root.
        joints: qpos index of each scalar joint, by its name without prefix, in the model's order.
        core_geoms: Shapes of head, torso and base: those that virtual actions must not push into things.
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
    """Find an attached agent's joints, sites and shapes in a compiled model.

    Raises:
        SceneError: The profile names something that its model does not have.
    """
    find = _Finder(model, name, profile)
    bodies = np.array([b for b in range(model.nbody) if model.body(b).name.startswith(f"{name}/")])
    root = int(bodies[0])
    if model.body_jntnum[root] != 1 or int(model.jnt_type[model.body_jntadr[root]]) != int(mujoco.mjtJoint.mjJNT_FREE):
        raise SceneError("the root body of an agent's model needs a free joint", where=name, field=profile.model)
    base = int(model.jnt_qposadr[model.body_jntadr[root]])
    geoms = _geoms_of(model, bodies)
    arms = tuple(_resolve_arm(model, find, arm) for arm in profile.arms)
    arm_geoms = np.concatenate([arm.geoms for arm in arms]) if arms else np.array([], dtype=np.intp)
    joints = {
        model.joint(j).name.removeprefix(f"{name}/"): int(model.jnt_qposadr[j])
        for j in range(model.njnt)
        if model.jnt_bodyid[j] in bodies and int(model.jnt_type[j]) in _SCALAR
    }
    find.check_joints(joints)
    return Agent(
        name=name,
        profile=profile,
        stature_m=stature_m,
        base=slice(base, base + 7),
        joints=joints,
        root_body=root,
        bodies=bodies,
        geoms=geoms,
        core_geoms=np.setdiff1d(geoms, arm_geoms),
        eye_site=find.site(profile.eye.site, "eye.site"),
        eye_exclude_body=find.body(profile.eye.exclude, "eye.exclude"),
        thigh_bodies=tuple(find.body(thigh, "posture.thighs") for thigh in profile.legs.thighs),
        arms=arms,
        parts={part: np.array([find.body(b, f"parts.{part}") for b in names]) for part, names in profile.parts},
    )


_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


class _Finder:
    """Looks names of a profile up in its model."""

    def __init__(self, model: mujoco.MjModel, agent: str, profile: AgentProfile) -> None:
        self._model, self._agent, self._profile = model, agent, profile

    def site(self, name: str, field: str) -> int:
        return self._find(mujoco.mjtObj.mjOBJ_SITE, name, field)

    def body(self, name: str, field: str) -> int:
        return self._find(mujoco.mjtObj.mjOBJ_BODY, name, field)

    def check_joints(self, joints: Mapping[str, int]) -> None:
        p = self._profile
        axes = {"head.pan": p.pan, "head.tilt": p.tilt, "torso.turn": p.turn, "torso.lean": p.lean}
        wanted = [(field, axis.joint) for field, axis in axes.items() if axis]
        wanted += [("posture", joint) for joint in (*p.legs.hips, *p.legs.knees, *p.legs.ankles)]
        for field, joint in wanted:
            if joint not in joints:
                raise self._missing(field, joint, "joint")

    def _find(self, kind: mujoco.mjtObj, name: str, field: str) -> int:
        index = int(mujoco.mj_name2id(self._model, kind, f"{self._agent}/{name}"))
        if index < 0:
            raise self._missing(field, name, kind.name.removeprefix("mjOBJ_").lower())
        return index

    def _missing(self, field: str, name: str, kind: str) -> SceneError:
        return SceneError(
            f"profile {self._profile.name!r} names a {kind} that its model {self._profile.model!r} does not have",
            where=self._agent,
            field=field,
            value=name,
        )


def _resolve_arm(model: mujoco.MjModel, find: _Finder, arm: Arm) -> ArmIndices:
    root = find.body(arm.root, "arms.root")
    hand = find.body(arm.hand, "arms.hand")
    ghosts = [g for g in range(model.ngeom) if model.geom_bodyid[g] == hand and model.geom_group[g] == GHOST_GROUP]
    return ArmIndices(
        profile=arm,
        shoulder_site=find.site(arm.shoulder, "arms.shoulder"),
        palm_site=find.site(arm.palm, "arms.palm"),
        hand_body=hand,
        carrier_body=int(model.body_parentid[root]),
        geoms=_geoms_of(model, subtree(model, root)),
        hand_geoms=_geoms_of(model, subtree(model, hand)),
        ghosts=np.array(ghosts, dtype=np.intp),
    )


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
