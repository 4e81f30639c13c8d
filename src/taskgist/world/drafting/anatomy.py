"""What a robot's model consists of: arms and their hands, a head with eyes, a torso, legs or wheels.

The kinematic tree is read first, names only where it leaves a choice. Bodies between which nothing moves are one
*link*; links hang on each other by joints::

    hand      a link, three joints or more from the root, that carries two or more small branches: fingers. Or a jaw
              beside it that is called so
    arm       the joints that lead to a hand and to nothing else; or a chain of five that turn, without fingers
    leg       a chain of three or more that turn, to one of the lowest ends of the body, of which there are two or more
    wheels    round links that turn without end about a level axis, at the lowest height, two or more
    torso     joints that carry arms and eye
    head      joints that carry the eye, and no arm
    eye       a camera of the model, an optical frame, else a link that is called a camera, an eye or a head

The body is looked at as its model has it at rest: ahead is along x, up along z.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from taskgist.common.arrays import Array
from taskgist.world.bodies.agent import subtree
from taskgist.world.bodies.fingers import HINGE, SLIDE, Plain, Unclear, measured_hand

FREE = int(mujoco.mjtJoint.mjJNT_FREE)
LEAST_TO_HAND = 3
"""Joints that lead to a hand, at least (ours)."""
HAND_M = 0.25
"""How far the bodies of a hand are from where it begins, at most (ours: Robotiq's largest has 0.2)."""
ARM_TURNS, LEG_TURNS = 5, 3
"""Turning joints of an arm without fingers, and of a leg, at least (ours: arms have five to seven, dogs' legs 3)."""
ON_FLOOR = 0.08
"""Share of the height within which the ends of legs and wheels are lowest (ours)."""
MOSTLY = 0.7
"""Cosine of 45°: nearer to an axis than across it."""
ROUND = 0.1
"""Share of its height by which a wheel's middle may lie off its axis (ours)."""
OUTSIDE_M = 0.5
"""A camera so far from its body looks at the robot, not from it (ours)."""
JAW, PERHAPS_JAW = re.compile(r"jaw|finger|claw|mover|tong"), re.compile(r"grip")
NO_FINGER = re.compile(r"head|neck|shoulder|elbow|hip|knee|(^|_)eye|wheel|caster")
ARM = re.compile(r"arm|hand|shoulder|elbow|wrist|grip|finger")
LEG = re.compile(r"leg|foot|ankle|knee|thigh|calf|shank|toe")
WHEEL = re.compile(r"wheel|caster|rad_")
LEFT, RIGHT = re.compile(r"left|(^|[_/-])l([_/-]|$)"), re.compile(r"right|(^|[_/-])r([_/-]|$)")
EYES = (
    re.compile(r"((^|_)rgb|colou?r)(_.*)?optical"),
    re.compile(r"(left|(^|_)l_).*optical"),
    re.compile(r"optical"),
    re.compile(r"((^|_)rgb_|colou?r).*(frame|link)|camera|(^|_)cam(_|$)|kinect|xtion|realsense|astra|orbbec|(^|_)zed"),
    re.compile(r"(^|_)(l_|left_)?eye"),
    re.compile(r"head"),
)
"""Names of links that look, the surest first."""
NO_EYE = re.compile(
    r"depth|(^|_)ir(_|$)|infra|laser|lidar|imu|collision|dummy|screw|gazebo|projector|thermal|external|_parent$"
)


class Tree:
    """A body's model at rest, as its kinematic tree.

    Attributes:
        model: The body alone, compiled.
        data: Where everything is.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.data = mujoco.MjData(model)
        self.data.qpos[:] = model.qpos0
        mujoco.mj_kinematics(model, self.data)

    def name(self, body: int) -> str:
        """Name of a body."""
        return str(self.model.body(body).name)

    def joint_name(self, joint: int) -> str:
        """Name of a joint."""
        return str(self.model.joint(joint).name)

    @cached_property
    def links(self) -> list[int]:
        """The first body of each link, the root's first."""
        roots = [body for body in range(1, self.model.nbody) if not self.model.body_parentid[body]]
        return [*roots, *(b for b in range(1, self.model.nbody) if b not in roots and self.model.body_jntnum[b])]

    def link_of(self, body: int) -> int:
        """The first body of the link that a body belongs to."""
        while body not in self.links and body:
            body = int(self.model.body_parentid[body])
        return body

    def children(self, link: int) -> list[int]:
        """The links that hang on a link."""
        return [
            each
            for each in self.links
            if self.model.body_parentid[each] and self.link_of(int(self.model.body_parentid[each])) == link
        ]

    def joints_to(self, body: int) -> list[int]:
        """Joints that carry a body, from the root outwards; those by which the root itself is free apart."""
        found: list[int] = []
        while body:
            first, count = int(self.model.body_jntadr[body]), int(self.model.body_jntnum[body])
            if self.model.body_parentid[body]:
                found = [*range(first, first + count), *found]
            body = int(self.model.body_parentid[body])
        return found

    def turns(self, joints: Iterable[int]) -> list[int]:
        """Those joints that turn."""
        return [joint for joint in joints if int(self.model.jnt_type[joint]) == HINGE]

    def slides(self, joints: Iterable[int]) -> list[int]:
        """Those joints that slide."""
        return [joint for joint in joints if int(self.model.jnt_type[joint]) == SLIDE]

    def axis(self, joint: int) -> Array:
        """A joint's axis in the world, (3,)."""
        return np.array(self.data.xaxis[joint])

    def height_m(self, bodies: Iterable[int]) -> tuple[float, float] | None:
        """The lowest and highest of boxes around bodies' shapes, metres; None without any shape of a size."""
        model = self.model
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, list(bodies)) & (model.geom_rbound > 0))
        if not len(geoms):
            return None
        turns = self.data.geom_xmat[geoms].reshape(-1, 3, 3)[:, 2]
        middles = self.data.geom_xpos[geoms, 2] + np.einsum("nj,nj->n", turns, model.geom_aabb[geoms, :3])
        halves = np.einsum("nj,nj->n", np.abs(turns), model.geom_aabb[geoms, 3:])
        return float((middles - halves).min()), float((middles + halves).max())

    def names_to(self, body: int) -> str:
        """Names of a body, its joints and what carries them up to the next fork, in small letters."""
        names = []
        while body:
            link = self.link_of(body)
            names += [self.name(body)]
            names += [self.joint_name(joint) for joint in self.joints_to(body)[-1:]]
            if link and len(self.children(link)) > 1 and len(names) > 2:
                break
            body = int(self.model.body_parentid[body])
        return " ".join(names).lower()


@dataclass(frozen=True)
class FoundArm:
    """An arm.

    Attributes:
        root: The body that it begins with.
        hand: The body that its hand begins with.
        joints: From the root outwards.
        fingers: What its fingers tell; None without any.
    """

    root: int
    hand: int
    joints: tuple[int, ...]
    fingers: Plain | Unclear | None


@dataclass(frozen=True)
class FoundEye:
    """What may be an eye.

    Attributes:
        name: Of a camera, or of a link.
        body: The body that it is in.
        camera: Whether it is a camera of the model.
        rank: The lower, the surer.
    """

    name: str
    body: int
    camera: bool
    rank: int


@dataclass(frozen=True)
class Anatomy:
    """What was found in a model.

    Attributes:
        tree: The model.
        arms: With the leftmost first.
        eyes: What may be its eye, the surest first; cameras on hands and outside apart.
        aside: Cameras and such that are none: their names, and why not.
        head: Joints that carry the eye and no arm.
        torso: Joints that carry all arms, and the eye if there is one.
        legs: Joints of each leg.
        wheels: Names of the joints of wheels; of bodies that are called wheels where none turns.
        free: Whether the model lets its root move.
    """

    tree: Tree
    arms: tuple[FoundArm, ...]
    eyes: tuple[FoundEye, ...]
    aside: tuple[tuple[str, str], ...]
    head: tuple[int, ...]
    torso: tuple[int, ...]
    legs: tuple[tuple[int, ...], ...]
    wheels: tuple[str, ...]
    free: bool


def anatomy(model: mujoco.MjModel) -> Anatomy:
    """Look at a body's model.

    Args:
        model: The body alone, compiled.
    """
    tree = Tree(model)
    hands = list(_hands(tree))
    of_hands = {body for hand in hands for body in subtree(model, hand)} | {tree.link_of(hand) for hand in hands}
    chains = [chain for chain in _chains(tree) if _last_body(tree, chain) not in of_hands]
    legs = _legs(tree, chains)
    arms_without = [chain for chain in chains if chain not in legs and len(tree.turns(chain)) >= ARM_TURNS]
    ends = [*((hand, True) for hand in hands), *((_last_body(tree, chain), False) for chain in arms_without)]
    eyes, aside = _eyes(tree, [end for end, _ in ends])
    seeing = eyes[0].body if eyes else None
    arms = _arms(tree, ends, seeing)
    carrying = [set(tree.joints_to(arm.hand)) for arm in arms]
    to_eye = tree.joints_to(seeing) if seeing is not None else []
    head = tuple(joint for joint in to_eye if not any(joint in joints for joints in carrying))
    own = {joint for arm in arms for joint in arm.joints}
    torso = [joint for joint in (tree.joints_to(arms[0].hand) if arms else to_eye) if joint not in own]
    torso = [joint for joint in torso if joint not in head]
    ordered = sorted(arms, key=lambda arm: -float(tree.data.xpos[arm.root][1]))
    joints = [int(joint) for joint in model.jnt_type]
    return Anatomy(
        tree=tree,
        arms=tuple(ordered),
        eyes=tuple(eyes),
        aside=tuple(aside),
        head=head,
        torso=tuple(torso),
        legs=tuple(tuple(leg) for leg in legs),
        wheels=tuple(_wheels(tree)),
        free=FREE in joints or any(model.body_jntnum[b] for b in tree.links if not model.body_parentid[b]),
    )


# --- Hands and arms.


def _hands(tree: Tree) -> Iterator[int]:
    """Bodies that hands begin with, the outermost apart that belong to a hand already."""
    found: list[int] = []
    for link in tree.links:
        inside = any(link in subtree(tree.model, hand) for hand in found)
        if inside or len(tree.joints_to(link)) < LEAST_TO_HAND:
            continue
        fingers = tree.children(link)
        if not fingers:
            continue
        hand = _common(tree, [int(tree.model.body_parentid[finger]) for finger in fingers])
        if not _small(tree, hand, fingers):
            continue
        if len(fingers) > 1 or _is_jaw(tree, fingers[0], hand):
            found.append(hand)
            yield hand


def _small(tree: Tree, hand: int, fingers: Sequence[int]) -> bool:
    """Whether all that fingers carry is near the hand, and none of it is called as what no hand carries."""
    origin = tree.data.xpos[hand]
    bodies = [body for finger in fingers for body in subtree(tree.model, finger)]
    if any(NO_FINGER.search(tree.name(body).lower()) for body in bodies):
        return False
    return all(float(np.linalg.norm(tree.data.xpos[body] - origin)) < HAND_M for body in bodies)


def _is_jaw(tree: Tree, finger: int, hand: int) -> bool:
    """Whether a single branch is called a jaw, or a gripper that closes on the link that carries it."""
    if tree.children(finger):
        return False
    names = f"{tree.name(finger)} {tree.joint_name(int(tree.model.body_jntadr[finger]))}".lower()
    perhaps = bool(PERHAPS_JAW.search(names)) and isinstance(measured_hand(tree.model, hand), Plain)
    return bool(JAW.search(names)) or perhaps


def _common(tree: Tree, bodies: Sequence[int]) -> int:
    """The body nearest to some bodies that carries them all."""

    def carriers(body: int) -> list[int]:
        found = [body]
        while body:
            body = int(tree.model.body_parentid[body])
            found.append(body)
        return found

    shared = set.intersection(*(set(carriers(body)) for body in bodies))
    return next(body for body in carriers(bodies[0]) if body in shared)


def _chains(tree: Tree) -> list[list[int]]:
    """Joints of each chain from the last fork to an end."""
    found = []
    for link in tree.links:
        if tree.children(link):
            continue
        chain: list[int] = []
        at = link
        while tree.model.body_parentid[at] and (at == link or len(tree.children(at)) < 2):
            first, count = int(tree.model.body_jntadr[at]), int(tree.model.body_jntnum[at])
            chain = [*range(first, first + count), *chain]
            at = tree.link_of(int(tree.model.body_parentid[at]))
        if chain:
            found.append(chain)
    return found


def _last_body(tree: Tree, chain: Sequence[int]) -> int:
    return int(tree.model.jnt_bodyid[chain[-1]])


def _arms(tree: Tree, ends: Sequence[tuple[int, bool]], seeing: int | None) -> list[FoundArm]:
    """The arms that lead to some ends: joints that carry the eye, or another hand, are no arm's own."""
    found = []
    shared = set(tree.joints_to(seeing)) if seeing is not None else set()
    for hand, fingered in ends:
        others = {joint for other, _ in ends if other != hand for joint in tree.joints_to(other)}
        joints = [joint for joint in tree.joints_to(hand) if joint not in shared | others]
        if not (others | shared):
            joints = _without_lift(tree, joints)
        if joints:
            root = int(tree.model.jnt_bodyid[joints[0]])
            fingers = measured_hand(tree.model, hand) if fingered else None
            found.append(FoundArm(root, hand, tuple(joints), fingers))
    return found


def _without_lift(tree: Tree, joints: list[int]) -> list[int]:
    """Joints of the only limb without those that slide before any turns: a lift, or a gantry."""
    while len(joints) > ARM_TURNS and joints[0] in tree.slides(joints):
        joints = joints[1:]
    return joints


# --- What a body stands on.


def _floor_m(tree: Tree) -> float:
    """Height up to which the ends of legs and wheels are lowest, metres."""
    low, high = tree.height_m(range(1, tree.model.nbody)) or (0.0, 0.0)
    return low + ON_FLOOR * (high - low)


def _legs(tree: Tree, chains: Sequence[list[int]]) -> list[list[int]]:
    """Chains that end lowest, unless they are called arms."""
    floor = _floor_m(tree)
    found = []
    for chain in chains:
        if len(tree.turns(chain)) < LEG_TURNS:
            continue
        end = _last_body(tree, chain)
        names, span = tree.names_to(end), tree.height_m(subtree(tree.model, end))
        lowest = span is not None and span[0] <= floor
        if LEG.search(names) or (lowest and not ARM.search(names)):
            found.append(chain)
    return found if len(found) > 1 else []


def _is_round(tree: Tree, joint: int) -> bool:
    """Whether a joint carries one link alone, and the shapes of that lie about its axis."""
    body = int(tree.model.jnt_bodyid[joint])
    span = tree.height_m([body])
    if span is None or tree.children(body):
        return False
    middle = tree.data.xpos[body] + tree.data.xmat[body].reshape(3, 3) @ _middle(tree, body)
    off = np.cross(middle - tree.data.xanchor[joint], tree.axis(joint))
    return float(np.linalg.norm(off)) < ROUND * (span[1] - span[0])


def _middle(tree: Tree, body: int) -> Array:
    """The middle of a body's shapes in its frame, metres."""
    first, count = int(tree.model.body_geomadr[body]), int(tree.model.body_geomnum[body])
    turn = np.zeros(9)
    middles = []
    for geom in range(first, first + count):
        mujoco.mju_quat2Mat(turn, tree.model.geom_quat[geom])
        middles.append(tree.model.geom_pos[geom] + turn.reshape(3, 3) @ tree.model.geom_aabb[geom, :3])
    return np.asarray(np.mean(middles, axis=0))


def _wheels(tree: Tree) -> list[str]:
    """Joints that turn links without end about a level axis at the lowest height; or what is called wheels."""
    floor = _floor_m(tree)
    found = []
    for joint in tree.turns(range(tree.model.njnt)):
        body = int(tree.model.jnt_bodyid[joint])
        span = tree.height_m([body])
        endless = (
            not tree.model.jnt_limited[joint] and abs(tree.axis(joint)[2]) < 1.0 - MOSTLY and _is_round(tree, joint)
        )
        lowest = span is not None and span[0] <= floor
        called = WHEEL.search(f"{tree.name(body)} {tree.joint_name(joint)}".lower())
        if (endless and lowest) or called:
            found.append(tree.joint_name(joint))
    called_wheels = [tree.name(body) for body in range(1, tree.model.nbody) if WHEEL.search(tree.name(body).lower())]
    return next((names for names in (found, called_wheels) if len(names) > 1), [])


# --- Eyes.


def _eyes(tree: Tree, hands: Sequence[int]) -> tuple[list[FoundEye], list[tuple[str, str]]]:
    """What may be the eye, the surest first, and cameras that are none."""
    of_arms = _of_arms(tree, hands)
    found: list[FoundEye] = []
    aside: list[tuple[str, str]] = []
    for camera in range(tree.model.ncam):
        name, body = str(tree.model.camera(camera).name), int(tree.model.cam_bodyid[camera])
        why = _no_eye(tree, camera, body, of_arms)
        if why:
            aside.append((name or "(no name)", why))
        else:
            found.append(FoundEye(name, body, True, 0))
    for body in range(1, tree.model.nbody):
        name = tree.name(body).lower()
        rank = next((rank for rank, pattern in enumerate(EYES, start=1) if pattern.search(name)), None)
        if rank is None or NO_EYE.search(name):
            continue
        if body in of_arms:
            aside.append((tree.name(body), "an arm carries it"))
        else:
            found.append(FoundEye(tree.name(body), body, False, rank))
    height = {eye: -float(tree.data.xpos[eye.body][2]) for eye in found}
    return sorted(found, key=lambda eye: (eye.rank, height[eye], eye.name)), aside


def _of_arms(tree: Tree, hands: Sequence[int]) -> set[int]:
    """Bodies that arms carry: all below the last fork, or of an only arm below its third joint."""
    found: set[int] = set()
    for hand in hands:
        joints = tree.joints_to(hand)
        others = {joint for other in hands if other != hand for joint in tree.joints_to(other)}
        own = [joint for joint in joints if joint not in others]
        own = own if others else own[-LEAST_TO_HAND:]
        found |= set(subtree(tree.model, int(tree.model.jnt_bodyid[own[0]]))) if own else set()
    return found


def _no_eye(tree: Tree, camera: int, body: int, of_arms: set[int]) -> str:
    """Why a camera of the model is no eye of the body; empty if it may be."""
    model = tree.model
    if not body or int(model.cam_mode[camera]) != int(mujoco.mjtCamLight.mjCAMLIGHT_FIXED):
        return "it is not fixed to the body"
    if int(model.cam_projection[camera]) != int(mujoco.mjtProjection.mjPROJ_PERSPECTIVE):
        return "it is no pinhole"
    if not str(model.camera(camera).name):
        return "it has no name"
    if body in of_arms:
        return "an arm carries it"
    if NO_EYE.search(str(model.camera(camera).name).lower()):
        return "by its name"
    if float(np.linalg.norm(model.cam_pos[camera])) > OUTSIDE_M:
        return "it looks at the robot from outside"
    return ""
