"""An agent in a compiled scene: its profile, with every name resolved to MuJoCo's indices."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError
from taskgist.world.bodies.arm_chain import NO_LIMITS, ArmChain, chain_of
from taskgist.world.bodies.capability import ArmReach, reach_of
from taskgist.world.bodies.hands import GHOST_GROUP, ghosts_of
from taskgist.world.bodies.human import shoulder_limits
from taskgist.world.bodies.profile import DERIVED_M, AgentProfile, Arm, Axis
from taskgist.world.geometry.shapes import lowest_point

# --- What a profile leaves out and its model knows: ranges of joints, lengths of arms.

FULL_TURN_RAD = (-math.pi, math.pi)
"""Range of a joint that turns without end, where a profile gives none."""


def completed(model: mujoco.MjModel, agent: str, profile: AgentProfile) -> AgentProfile:
    """The profile with no gaps: ranges that no joint exceeds, and a length for every arm.

    Args:
        model: The compiled scene.
        agent: Name of the agent, under which its names stand in the model.
        profile: As its document gives it.
    """
    axes = {name: getattr(profile, name) for name in ("pan", "tilt", "turn", "lean")}
    return replace(
        profile,
        **{name: axis and replace(axis, range_rad=range_of(model, agent, axis)) for name, axis in axes.items()},
        arms=tuple(_completed_arm(model, agent, arm) for arm in profile.arms),
    )


def range_of(model: mujoco.MjModel, agent: str, axis: Axis) -> tuple[float, float]:
    """What the profile allows and the joint can do, radians."""
    joint = model.joint(f"{agent}/{axis.joint}")
    low, high = (float(limit) for limit in joint.range) if joint.limited[0] else FULL_TURN_RAD
    if not joint.limited[0] and all(map(math.isfinite, axis.range_rad)):
        return axis.range_rad
    return max(low, axis.range_rad[0]), min(high, axis.range_rad[1])


def _completed_arm(model: mujoco.MjModel, agent: str, arm: Arm) -> Arm:
    if arm.thrust is not None:
        arm = replace(arm, thrust=replace(arm.thrust, range_rad=range_of(model, agent, arm.thrust)))
    return arm if arm.length_m != DERIVED_M else replace(arm, length_m=stretched_m(model, agent, arm))


def stretched_m(model: mujoco.MjModel, agent: str, arm: Arm) -> float:
    """The arm stretched out: how far its palm gets from its shoulder within the ranges of its joints, metres.

    One joint after the other is put where the distance is greatest, until nothing changes much; from two
    configurations, so that an arm which begins folded does not stay so.
    """
    shoulder, palm = (
        site_index(model, agent, f"{arm.side}_{name}_frame", frame.name)
        for name, frame in (("shoulder", arm.shoulder), ("palm", arm.palm))
    )
    joints = _joints_between(model, int(model.site_bodyid[palm]), int(model.body(f"{agent}/{arm.root}").id))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    start = data.site_xpos[shoulder].copy()

    def squared(joint: int, value: float) -> float:
        data.qpos[model.jnt_qposadr[joint]] = value
        mujoco.mj_kinematics(model, data)
        return float(np.sum((data.site_xpos[palm] - start) ** 2))

    found = 0.0
    for share in (0.5, 0.3):
        for joint in joints:
            data.qpos[model.jnt_qposadr[joint]] = float(np.dot((1 - share, share), _limits(model, joint)))
        for joint in (*joints, *joints, *joints):
            found = max(found, _best(model, joint, squared))
    return math.sqrt(found)


def _joints_between(model: mujoco.MjModel, body: int, root: int) -> list[int]:
    """Joints from an arm's root to a body that it carries, the farthest first."""
    joints: list[int] = []
    while True:
        joints += range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
        if body in (root, 0):
            return joints
        body = int(model.body_parentid[body])


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    low, high = (float(limit) for limit in model.jnt_range[joint])
    return (low, high) if model.jnt_limited[joint] else FULL_TURN_RAD


def _best(model: mujoco.MjModel, joint: int, squared: Callable[[int, float], float]) -> float:
    """Puts a joint where the squared distance is greatest, which it gives.

    About a hinge, the squared distance of two points is a + b cos q + c sin q: three values tell where it is greatest.
    """
    candidates = list(_limits(model, joint))
    if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_HINGE):
        at_0, at_90, at_180 = (squared(joint, angle) for angle in (0.0, math.pi / 2, math.pi))
        middle = (at_0 + at_180) / 2
        top = math.atan2(at_90 - middle, at_0 - middle)
        low, high = candidates
        candidates += [angle for angle in (top - 2 * math.pi, top, top + 2 * math.pi) if low <= angle <= high]
    best = max(candidates, key=lambda value: squared(joint, value))
    return squared(joint, best)


def site_index(model: mujoco.MjModel, agent: str, label: str, name: str) -> int:
    """Index of a frame's site: the one that was added for it, else the model's own of that name."""
    added = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, f"{agent}/{label}"))
    return added if added >= 0 else int(model.site(f"{agent}/{name}").id)


SEEN_GROUPS = (0, 1, 2)
"""Geom groups that rays meet: MuJoCo shows them by default and keeps 3 for collision shapes."""
SEEN_MASK = np.array([group in SEEN_GROUPS for group in range(6)], dtype=np.uint8)


@dataclass(frozen=True, eq=False)
class ArmIndices:
    """One arm: its profile and its indices.

    ``ghosts`` are the geoms of a virtual grasp, in the order of ``hand_boxes``; ``flat_ghost`` is that of the whole
    hand flat on a thing, −1 if it grasps nothing together with another; ``carrier_body`` is what the arm hangs on;
    ``chain`` are its joints and links as numbers; ``human_stature_m`` is None for robots.
    """

    profile: Arm
    shoulder_site: int
    palm_site: int
    hand_body: int
    carrier_body: int
    geoms: Indices
    hand_geoms: Indices
    ghosts: Indices
    flat_ghost: int
    chain: ArmChain
    human_stature_m: float | None

    @cached_property
    def reach(self) -> ArmReach:
        """Where its palm gets to; made in seconds when such an arm is first met, and kept."""
        return reach_of(self.chain, self.profile.side, self.human_stature_m)

    @cached_property
    def sector(self) -> Array:
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
        lifts: Names of the joints between base and shoulders that slide, as a torso's lift does.
        arm_positions: Indices into qpos of the joints of its arms, (n,).
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
    lifts: tuple[str, ...]
    arm_positions: Indices
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
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    human_m = stature_m if profile.model == HUMAN else None
    arms = tuple(_resolve_arm(model, data, name, arm, human_m) for arm in profile.arms)
    arm_geoms = np.concatenate([arm.geoms for arm in arms]) if arms else np.array([], dtype=np.intp)
    _, _, eye = profile.frames[0]
    parts = _parts(model, name, profile, bodies)
    of_arms = {int(body) for arm in arms for body in parts.get(f"{arm.profile.side}_arm", ())}
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
        lifts=_lifts(model, name, arms),
        arm_positions=np.array(list(_scalar_joints(model, name, of_arms).values()), dtype=np.intp),
        parts=parts,
    )


def _lifts(model: mujoco.MjModel, name: str, arms: Iterable[ArmIndices]) -> tuple[str, ...]:
    carriers = {body for arm in arms for body in (arm.carrier_body, *_ancestors(model, arm.carrier_body))}
    return tuple(
        str(model.joint(j).name).removeprefix(f"{name}/")
        for j in range(model.njnt)
        if int(model.jnt_bodyid[j]) in carriers and int(model.jnt_type[j]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    )


_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def _scalar_joints(model: mujoco.MjModel, name: str, bodies: Indices | set[int]) -> dict[str, int]:
    """Index into qpos of each joint that turns or slides, by its name without prefix."""
    return {
        model.joint(j).name.removeprefix(f"{name}/"): int(model.jnt_qposadr[j])
        for j in range(model.njnt)
        if model.jnt_bodyid[j] in bodies and int(model.jnt_type[j]) in _SCALAR
    }


class Coupling(NamedTuple):
    """A joint that the model has follow another one: URDF's mimic.

    Attributes:
        follower: The joint that follows, its index in the model.
        leader: The one that it follows.
        terms: Coefficients of the polynomial by which it does, from the constant on, (5,). MuJoCo counts both joints
            from where they are in ``qpos0``.
    """

    follower: int
    leader: int
    terms: Array

    def led(self, model: mujoco.MjModel, leader: ArrayLike) -> Array:
        """Where the follower is when its leader is somewhere, radians or metres, in the leader's shape."""
        start, zero = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (self.follower, self.leader))
        return np.asarray(start + np.polyval(self.terms[::-1], np.asarray(leader) - zero))


def couplings(model: mujoco.MjModel) -> tuple[Coupling, ...]:
    """Joints of a model that follow others."""
    kinds = np.flatnonzero(model.eq_type == int(mujoco.mjtEq.mjEQ_JOINT))
    return tuple(
        Coupling(int(model.eq_obj1id[each]), int(model.eq_obj2id[each]), np.array(model.eq_data[each][:5]))
        for each in kinds
        if model.eq_obj2id[each] >= 0
    )


def _body(model: mujoco.MjModel, agent: str, name: str) -> int:
    return int(model.body(f"{agent}/{name}").id)


HUMAN = "human"
"""Model of the parametric human body."""


def _resolve_arm(
    model: mujoco.MjModel, data: mujoco.MjData, agent: str, arm: Arm, human_stature_m: float | None
) -> ArmIndices:
    root, hand = _body(model, agent, arm.root), _body(model, agent, arm.hand)
    hand_geoms = _geoms_of(model, subtree(model, hand))
    shoulder = site_index(model, agent, f"{arm.side}_shoulder_frame", arm.shoulder.name)
    palm = site_index(model, agent, f"{arm.side}_palm_frame", arm.palm.name)
    carrier = _body(model, agent, arm.carrier) if arm.carrier else int(model.body_parentid[root])
    geoms = _geoms_of(model, subtree(model, root))
    indices = {"root": root, "hand": hand, "carrier": carrier, "shoulder": shoulder, "palm": palm}
    ghosts, flat_ghost = ghosts_of(model, hand)
    return ArmIndices(
        profile=arm,
        shoulder_site=shoulder,
        palm_site=palm,
        hand_body=hand,
        carrier_body=carrier,
        geoms=geoms,
        hand_geoms=solid(model, hand_geoms) if len(solid(model, hand_geoms)) else hand_geoms,
        ghosts=np.array(ghosts, dtype=np.intp),
        flat_ghost=flat_ghost,
        chain=chain_of(model, data, indices, geoms, shoulder_limits(arm.side) if human_stature_m else NO_LIMITS),
        human_stature_m=human_stature_m,
    )


def solid(model: mujoco.MjModel, geoms: Indices) -> Indices:
    """Those shapes that collide with something: URDF has others that are only shown."""
    return np.asarray(geoms[(model.geom_contype[geoms] != 0) | (model.geom_conaffinity[geoms] != 0)])


def _parts(model: mujoco.MjModel, agent: str, profile: AgentProfile, bodies: Indices) -> dict[str, Indices]:
    """The bodies of each part: as the profile has it, else what the joints of its actions and its arms make of it.

    Each arm is all that hangs on its root, the head all that the head's joints move, the torso what carries them, and
    what is left, wheels or legs, carries the torso. Without an eye there is no head.
    """
    if profile.parts:
        return {part: np.array([_body(model, agent, b) for b in names]) for part, names in profile.parts}
    roots = {f"{arm.side}_arm": _body(model, agent, arm.root) for arm in profile.arms}
    necks = [int(model.joint(f"{agent}/{axis.joint}").bodyid[0]) for axis in (profile.pan, profile.tilt) if axis]
    if profile.eye.sees:
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


# --- Legs: the angles with which a body's soles stand on the floor while its hips are at a height.


def legs_for(model: mujoco.MjModel, agent: Agent, *, hip_height_m: float) -> tuple[dict[str, float], float]:
    """Leg angles with which the soles stand on the floor while the hips are at a height.

    The shanks stay upright; thighs are as inclined as the height asks for.

    Args:
        model: The compiled scene.
        agent: The agent.
        hip_height_m: Wanted height of the hips over the floor; at or above standing height the legs are straight.

    Returns:
        Joint angles in radians by name, and the height of the root in metres that results; for a body without legs,
        none and the height at which its model puts the root.
    """
    legs = agent.profile.legs
    if not legs.feet:
        return {}, float(model.body_pos[agent.root_body][2])
    thigh, lower = leg_lengths_m(model, agent)
    drop = np.clip((hip_height_m - lower) / thigh, -1.0, 1.0)
    flexion = math.acos(drop)
    angles = dict.fromkeys(legs.hips, flexion) | dict.fromkeys(legs.knees, flexion) | dict.fromkeys(legs.ankles, 0.0)
    return angles, float(lower + thigh * drop)


def leg_lengths_m(model: mujoco.MjModel, agent: Agent) -> tuple[float, float]:
    """Lengths in metres of the thigh, and of shank and foot together (knee to sole)."""
    foot = body_index(model, agent, agent.profile.legs.feet[0])
    shank = int(model.body_parentid[foot])
    of_foot = agent.geoms[model.geom_bodyid[agent.geoms] == foot]
    soles = model.geom_size[of_foot, 2] - model.geom_pos[of_foot, 2]
    thigh_m = float(np.linalg.norm(model.body_pos[shank]))
    return thigh_m, float(np.linalg.norm(model.body_pos[foot])) + float(soles.max())


def ankle_height_m(model: mujoco.MjModel, agent: Agent) -> float:
    """Height in metres of the ankles over the soles."""
    foot = body_index(model, agent, agent.profile.legs.feet[0])
    return leg_lengths_m(model, agent)[1] - float(np.linalg.norm(model.body_pos[foot]))


def standing_height_m(model: mujoco.MjModel, agent: Agent, qpos: Array) -> float:
    """Height in metres of the root at which the agent's lowest shape touches the floor.

    Args:
        model: The compiled scene.
        agent: The agent.
        qpos: Its joints as they are; where its base is does not matter, (nq,).
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qpos[agent.base] = (0, 0, 0, 1, 0, 0, 0)
    mujoco.mj_kinematics(model, data)
    matrices = data.geom_xmat.reshape(-1, 3, 3)
    lowest = [(geom, lowest_point(model, int(geom), matrices[geom])) for geom in agent.geoms]
    heights = [data.geom_xpos[geom][2] + matrices[geom][2] @ point for geom, point in lowest if point is not None]
    return -float(min(heights, default=0.0))


def body_index(model: mujoco.MjModel, agent: Agent, name: str) -> int:
    """Index of one of the agent's bodies by its name without prefix."""
    return int(model.body(f"{agent.name}/{name}").id)
