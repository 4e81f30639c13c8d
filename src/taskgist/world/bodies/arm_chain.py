"""An arm as numbers: its joints, and capsules around its links, in the frame of what carries it; and what joints move.

The shoulder girdle stays at rest: joints that move the shoulder itself are a body's thrust, no part of its arm.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled_part
from taskgist.world.geometry.solids import AT, COLUMNS, TURNED, solids_of

GIRDLE_M = 0.01
"""A joint moves the shoulder itself if its axis passes it farther away than this."""
STEPS = 65_535
"""Steps of a joint's range in which configurations are kept."""
JOINT_COLUMNS, CAPSULE_COLUMNS, LIMIT_COLUMNS = 9, 9, 9
ALONG, SLIDES, LOW, SPAN = 3, 6, 7, 8
END, THICK, CARRIED, HAND = 3, 6, 7, 8
BARRED, NEAR, TWIST = 4, 7, 8
NO_LIMITS = np.empty((0, LIMIT_COLUMNS))
SLACK = 1e-6


@dataclass(frozen=True, eq=False)
class ArmChain:
    """The joints of an arm and what they carry, all at one configuration, in the carrier's axes about the shoulder.

    Attributes:
        joints: From the carrier outwards: a point of the axis (3), the axis (3), whether it slides, and how far below
            and over which span it moves, radians or metres, (j, 9).
        capsules: Around the links: both ends of the axis (3 + 3) and radius in metres, how many of the joints carry
            it, and whether it belongs to the hand, (c, 9).
        palm: Where the palm is, metres, (3,).
        wrist: Where the hand begins, (3,).
        carrier: Solid shapes of the carrier, (s, 17); see ``geometry.solids``.
        limits: Of ball-and-socket joints that several hinges stand for: how many of the joints carry the limb, where
            it points (3), the middle of a cone of directions that it does not take (3), the cosine of the cone's
            half-angle, and how far the limb twists about itself, radians, (l, 9).
    """

    joints: Array
    capsules: Array
    palm: Array
    wrist: Array
    carrier: Array
    limits: Array

    @cached_property
    def inside(self) -> Array:
        """Where in the hand the straight way to the palm begins, metres, (3,): the palm lies before the hand."""
        hands = self.capsules[self.capsules[:, HAND] == 1]
        if not len(hands):
            return self.wrist
        start, along = hands[0, :END], hands[0, END : END + 3] - hands[0, :END]
        share = float(along @ (self.palm - start)) / max(float(along @ along), 1e-12)
        return np.asarray(start + np.clip(share, 0.0, 1.0) * along)

    def mirrored(self) -> ArmChain:
        """The arm of the other side: y is turned about, and turns go the other way."""
        joints, capsules, carrier = self.joints.copy(), self.capsules.copy(), self.carrier.copy()
        joints[:, 1] *= -1
        turning = joints[:, SLIDES] == 0
        joints[:, ALONG + 1] *= -1
        joints[turning, ALONG : ALONG + 3] *= -1  # axial vectors
        capsules[:, [1, END + 1]] *= -1
        carrier[:, AT + 1] *= -1
        carrier[:, TURNED + 3 : TURNED + 6] *= -1
        flip = np.array((1.0, -1.0, 1.0))
        limits = self.limits.copy()
        limits[:, [2, BARRED + 1]] *= -1
        return ArmChain(joints, capsules, self.palm * flip, self.wrist * flip, carrier, limits)

    def scaled(self, factor: float) -> ArmChain:
        """The arm of a body that is so many times as large."""
        joints, capsules, carrier = self.joints.copy(), self.capsules.copy(), self.carrier.copy()
        joints[:, :3] *= factor
        joints[joints[:, SLIDES] == 1, LOW:] *= factor
        capsules[:, : THICK + 1] *= factor
        carrier[:, 1:TURNED] *= factor
        carrier[:, COLUMNS - 1] *= factor
        return ArmChain(joints, capsules, self.palm * factor, self.wrist * factor, carrier, self.limits)

    def is_about(self, other: ArmChain, within_m: float) -> bool:
        """Whether another arm is the same but for so much."""
        if self.joints.shape != other.joints.shape or self.capsules.shape != other.capsules.shape:
            return False
        if not np.array_equal(self.limits, other.limits):
            return False
        pairs = (self.joints, other.joints), (self.capsules, other.capsules), (self.palm, other.palm)
        return all(np.allclose(one, two, rtol=0.0, atol=within_m) for one, two in pairs)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, ArmChain) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)

    @cached_property
    def digest(self) -> str:
        """Digest of its numbers, to a hundredth of a millimetre."""
        arrays = [self.joints, self.capsules, self.palm, self.wrist, self.carrier]
        arrays += [self.limits] if len(self.limits) else []
        shapes = repr([array.shape for array in arrays])
        finite = (np.nan_to_num(array, posinf=1e6, neginf=-1e6) for array in arrays)
        content = b"".join((np.round(array * 1e5) + 0.0).astype("<i8").tobytes() for array in finite)
        return hashlib.sha256(shapes.encode() + content).hexdigest()[:16]


def chain_of(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    indices: Mapping[str, int],
    geoms: Indices,
    limits: Array = NO_LIMITS,
) -> ArmChain:
    """An arm as numbers.

    Args:
        model: The model.
        data: Where its bodies are, at the configuration ``qpos0``.
        indices: Of the bodies ``root``, ``hand`` and ``carrier``, and of the sites ``shoulder`` and ``palm``.
        geoms: The arm's shapes; those of them that collide are what it bumps into things with.
        limits: Of ball-and-socket joints, as in the chain, (l, 9).
    """
    carrier, shoulder, hand = indices["carrier"], indices["shoulder"], indices["hand"]
    turn, origin = data.xmat[carrier].reshape(3, 3), data.site_xpos[shoulder]

    def place(points: Array) -> Array:
        return np.asarray((np.asarray(points) - origin) @ turn)

    bodies = _bodies_between(model, hand, indices["root"])
    girdle = set(_bodies_between(model, int(model.site_bodyid[shoulder]), indices["root"])[:-1])
    rows, carriers = [], []
    for body in bodies:
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            for row in _rows(model, data, joint, turn, place):
                if body in girdle and _moves(row):
                    continue
                rows.append(row)
                carriers.append(body)
    joints = np.array(rows).reshape(-1, JOINT_COLUMNS)
    capsules = _capsules(model, data, geoms, carriers, hand, place)
    own = np.flatnonzero(model.geom_bodyid == carrier)
    own = own[((model.geom_contype[own] != 0) | (model.geom_conaffinity[own] != 0)) & _formed(model, own)]
    matrices = np.einsum("ji,njk->nik", turn, data.geom_xmat[own].reshape(-1, 3, 3)).reshape(-1, 9)
    shapes = solids_of(model, own, place(data.geom_xpos[own]), matrices)
    palm, wrist = place(data.site_xpos[indices["palm"]]), place(data.xpos[hand])
    return ArmChain(joints, capsules, palm, wrist, shapes, limits)


def _formed(model: mujoco.MjModel, geoms: Indices) -> Mask:
    """Whether shapes are held against by formula: neither planes nor fields nor meshes."""
    kinds = model.geom_type[geoms]
    return np.asarray((kinds >= int(mujoco.mjtGeom.mjGEOM_SPHERE)) & (kinds <= int(mujoco.mjtGeom.mjGEOM_BOX)))


def _bodies_between(model: mujoco.MjModel, body: int, root: int) -> list[int]:
    """Bodies from an arm's root to one that it carries, in this order; the root alone if it does not carry it."""
    found = [body]
    while found[-1] not in (root, 0):
        found.append(int(model.body_parentid[found[-1]]))
    return found[::-1] if found[-1] == root else [root]


def _rows(
    model: mujoco.MjModel, data: mujoco.MjData, joint: int, turn: Array, place: Callable[[Array], Array]
) -> list[list[float]]:
    """A joint as rows of a chain: a hinge or slide as one, a ball as three hinges."""
    kind, limited = int(model.jnt_type[joint]), bool(model.jnt_limited[joint])
    low, high = (float(limit) for limit in model.jnt_range[joint])
    now = float(model.qpos0[model.jnt_qposadr[joint]])
    anchor = place(data.xanchor[joint]).tolist()
    if kind == int(mujoco.mjtJoint.mjJNT_BALL):
        most = high if limited else math.pi
        axes = data.xmat[model.jnt_bodyid[joint]].reshape(3, 3).T @ turn
        return [[*anchor, *axis.tolist(), 0.0, -most, 2 * most] for axis in axes]
    if kind == int(mujoco.mjtJoint.mjJNT_FREE):
        return []
    slides = kind == int(mujoco.mjtJoint.mjJNT_SLIDE)
    if not limited:
        low, high = (now, now) if slides else (now - math.pi, now + math.pi)
    return [[*anchor, *(data.xaxis[joint] @ turn).tolist(), float(slides), low - now, high - low]]


def _moves(row: list[float]) -> bool:
    """Whether a joint above the shoulder, which is the origin, moves it by turning."""
    anchor, axis = np.array(row[:3]), np.array(row[ALONG : ALONG + 3])
    return row[SLIDES] == 0 and float(np.linalg.norm(np.cross(anchor, axis))) > GIRDLE_M


def _capsules(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    geoms: Indices,
    carriers: list[int],
    hand: int,
    place: Callable[[Array], Array],
) -> Array:
    """One capsule for all that the same joints carry, (c, 9), as thin as its longest shape is; hands are flat."""
    hull = (model.geom_contype[geoms] != 0) | (model.geom_conaffinity[geoms] != 0)
    groups: dict[tuple[int, bool], list[tuple[Array, float]]] = {}
    joint: dict[tuple[int, bool], Array] = {}
    for geom in (geoms[hull] if hull.any() else geoms).tolist():
        body = int(model.geom_bodyid[geom])
        chain = _bodies_between(model, body, 0)
        group = (sum(carrier in chain for carrier in carriers), hand in chain)
        joint.setdefault(group, place(data.xpos[body]))
        box, matrix = model.geom_aabb[geom], data.geom_xmat[geom].reshape(3, 3)
        longest = int(np.argmax(box[3:]))
        radius_m = float(np.min(box[3:]) if group[1] else np.median(box[3:]))
        along = max(float(box[3 + longest]) - radius_m, 0.0) * matrix[:, longest]
        middle = data.geom_xpos[geom] + matrix @ box[:3]
        groups.setdefault(group, []).append((place(np.array((middle - along, middle + along))), radius_m))
    rows = [[*_joined(shapes, joint[group]), *group] for group, shapes in sorted(groups.items(), key=lambda g: g[0])]
    return np.array(rows, dtype=np.float64).reshape(-1, CAPSULE_COLUMNS)


def _joined(shapes: list[tuple[Array, float]], joint: Array) -> list[float]:
    """One capsule for several, from what is nearest to the joint to what is farthest, as thick as the longest is."""
    ends = np.concatenate([ends for ends, _ in shapes])
    away_m = np.linalg.norm(ends - joint, axis=1)
    lengths_m = [float(np.linalg.norm(ends[1] - ends[0])) for ends, _ in shapes]
    radius_m = shapes[int(np.argmax(lengths_m))][1]
    return [*ends[np.argmin(away_m)].tolist(), *ends[np.argmax(away_m)].tolist(), radius_m]


# --- Configurations: where they bring what a joint carries. Compiled.


@compiled_part
def turn_on(frame: Array, row: Array, by: float) -> None:
    """Let a joint move all that it carries: ``frame``, (12,), a position and a matrix row by row, is written to.

    A point p of the arm is then at position + matrix p (product of exponentials [Brockett 1984]).
    """
    ax, ay, az = row[ALONG], row[ALONG + 1], row[ALONG + 2]
    if row[SLIDES] == 1.0:
        for k in range(3):
            frame[k] += by * (frame[3 + 3 * k] * ax + frame[4 + 3 * k] * ay + frame[5 + 3 * k] * az)
        return
    sine, cosine = math.sin(by), math.cos(by)
    rest = 1.0 - cosine
    r00, r01, r02 = cosine + rest * ax * ax, rest * ax * ay - sine * az, rest * ax * az + sine * ay
    r10, r11, r12 = rest * ax * ay + sine * az, cosine + rest * ay * ay, rest * ay * az - sine * ax
    r20, r21, r22 = rest * ax * az - sine * ay, rest * ay * az + sine * ax, cosine + rest * az * az
    cx, cy, cz = row[0], row[1], row[2]
    tx, ty, tz = (
        cx - r00 * cx - r01 * cy - r02 * cz,
        cy - r10 * cx - r11 * cy - r12 * cz,
        cz - r20 * cx - r21 * cy - r22 * cz,
    )
    for k in range(3):
        a, b, c = frame[3 + 3 * k], frame[4 + 3 * k], frame[5 + 3 * k]
        frame[k] += a * tx + b * ty + c * tz
        frame[3 + 3 * k] = a * r00 + b * r10 + c * r20
        frame[4 + 3 * k] = a * r01 + b * r11 + c * r21
        frame[5 + 3 * k] = a * r02 + b * r12 + c * r22


@compiled_part
def put(frame: Array, x: float, y: float, z: float) -> tuple[float, float, float]:
    """Where a point of the arm is, once its joints have moved the frame that carries it."""
    return (
        frame[0] + frame[3] * x + frame[4] * y + frame[5] * z,
        frame[1] + frame[6] * x + frame[7] * y + frame[8] * z,
        frame[2] + frame[9] * x + frame[10] * y + frame[11] * z,
    )


@compiled_part
def within_limits(frames: Array, limits: Array) -> bool:
    """Whether the limbs of ball-and-socket joints point, and are twisted, as such joints let them.

    The twist is what is left of a rotation after the shortest swing to where the limb points (swing-twist
    decomposition of a unit quaternion).
    """
    for row in range(len(limits)):
        m, (x, y, z) = frames[int(limits[row, 0])], (limits[row, 1], limits[row, 2], limits[row, 3])
        px, py, pz = (
            m[3] * x + m[4] * y + m[5] * z,
            m[6] * x + m[7] * y + m[8] * z,
            m[9] * x + m[10] * y + m[11] * z,
        )
        if px * limits[row, BARRED] + py * limits[row, BARRED + 1] + pz * limits[row, BARRED + 2] > limits[row, NEAR]:
            return False
        scalar = max(0.0, 1.0 + m[3] + m[7] + m[11]) / 4  # of the quaternion, squared
        along = max(0.0, (1.0 + px * x + py * y + pz * z) / 2 - scalar)  # its vector along the limb, squared
        if along + scalar > SLACK and 2 * math.atan2(math.sqrt(along), math.sqrt(scalar)) > limits[row, TWIST] + SLACK:
            return False
    return True


@compiled_part
def put_frames(joints: Array, configuration: NDArray[np.uint16], frames: Array) -> None:
    """Write the frame after each joint of a configuration, the first one before all of them, (j + 1, 12)."""
    for k in range(12):
        frames[0, k] = 1.0 if k in (3, 7, 11) else 0.0
    for joint in range(len(joints)):
        for k in range(12):
            frames[joint + 1, k] = frames[joint, k]
        by = joints[joint, LOW] + joints[joint, SPAN] * configuration[joint] / STEPS
        turn_on(frames[joint + 1], joints[joint], by)
