"""Capability maps: where the palm of an arm gets to, and with which configurations of its joints.

An arm is sampled: its joints are put anywhere in their ranges, a million times, and where its palm comes is noted in a
grid of cells that is fixed to what carries the arm, with its shoulder as origin [Zacharias 2007; Reuleaux, Makhal
2018]. Elbows, telescopes and arms that bend one way only come out as they are. The map tells

- which eighths of each cell lie within half a cell of a place that the palm took (what is reached),
- for each cell, up to one configuration for each of 26 directions in which the hand may point (how it is reached).

The shoulder girdle stays at rest: joints that move the shoulder itself are a body's thrust, no part of its arm. What a
configuration pushes into the carrier itself, an upper body mostly, is no configuration.

Maps are made once, in seconds, and kept in the user's cache by a digest of the arm. Left and right arms that mirror
each other have one map, and all people of the same proportions: lengths scale with the stature.
"""

from __future__ import annotations

import hashlib
import logging
import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from taskgist.common.array_files import ArrayFile
from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.common.files import writing
from taskgist.errors import InputError
from taskgist.world.bodies.human import HumanSize, human_mjcf
from taskgist.world.geometry.convex import cache_folder
from taskgist.world.geometry.solids import AT, COLUMNS, TURNED, outside_m, solids_of

log = logging.getLogger("taskgist.world")
SAMPLES = 1_500_000
"""Configurations tried for a map: a cell of an arm of 0.7 m is met about a hundred times."""
EDGE_SHARE = 0.15
"""How often a joint is put to an end of its range, so that the border of the map is met as well."""
CELL_M = 0.05
"""Edge of a cell for an arm of a length of up to ``LONG_M``; longer ones have larger cells."""
LONG_M = 1.5
SHIFT_M = 0.0037
"""How far the grid is shifted, so that no round coordinate lies on the border of a cell or of its eighths."""
DIRECTIONS = 27
"""Directions in which a hand may point: −1, 0 or 1 along each axis."""
SPREAD = 0.4
"""Least part of a direction along an axis that counts as pointing that way: about the sine of 22.5°."""
SUNK_M = 0.01
"""How deep an arm may push into what carries it: shapes of bodies are rough."""
GIRDLE_M = 0.01
"""A joint moves the shoulder itself if its axis passes it farther away than this."""
STEPS = 65_535
"""Steps of a joint's range in which configurations are kept."""
VERSION = "6"
JOINT_COLUMNS, CAPSULE_COLUMNS = 9, 9
ALONG, SLIDES, LOW, SPAN = 3, 6, 7, 8
END, THICK, CARRIED, HAND = 3, 6, 7, 8


# --- An arm as numbers: joints, and capsules around its links, in the frame of what carries it.


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
    """

    joints: Array
    capsules: Array
    palm: Array
    wrist: Array
    carrier: Array

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
        return ArmChain(joints, capsules, self.palm * flip, self.wrist * flip, carrier)

    def scaled(self, factor: float) -> ArmChain:
        """The arm of a body that is so many times as large."""
        joints, capsules, carrier = self.joints.copy(), self.capsules.copy(), self.carrier.copy()
        joints[:, :3] *= factor
        joints[joints[:, SLIDES] == 1, LOW:] *= factor
        capsules[:, : THICK + 1] *= factor
        carrier[:, 1:TURNED] *= factor
        carrier[:, COLUMNS - 1] *= factor
        return ArmChain(joints, capsules, self.palm * factor, self.wrist * factor, carrier)

    def is_about(self, other: ArmChain, within_m: float) -> bool:
        """Whether another arm is the same but for so much."""
        if self.joints.shape != other.joints.shape or self.capsules.shape != other.capsules.shape:
            return False
        pairs = (self.joints, other.joints), (self.capsules, other.capsules), (self.palm, other.palm)
        return all(np.allclose(one, two, rtol=0.0, atol=within_m) for one, two in pairs)

    @cached_property
    def digest(self) -> str:
        """Digest of all that its map depends on."""
        arrays = (self.joints, self.capsules, self.palm, self.wrist, self.carrier)
        settings = repr((VERSION, SAMPLES, EDGE_SHARE, CELL_M, LONG_M, SPREAD, SUNK_M, [a.shape for a in arrays]))
        finite = (np.nan_to_num(array, posinf=1e6, neginf=-1e6) for array in arrays)
        content = b"".join((np.round(array * 1e5) + 0.0).astype("<i8").tobytes() for array in finite)
        return hashlib.sha256(settings.encode() + content).hexdigest()[:16]


def chain_of(model: mujoco.MjModel, data: mujoco.MjData, indices: Mapping[str, int], geoms: Indices) -> ArmChain:
    """An arm as numbers.

    Args:
        model: The model.
        data: Where its bodies are, at the configuration ``qpos0``.
        indices: Of the bodies ``root``, ``hand`` and ``carrier``, and of the sites ``shoulder`` and ``palm``.
        geoms: The arm's shapes; those of them that collide are what it bumps into things with.
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
    return ArmChain(joints, capsules, palm, wrist, shapes)


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
def put_frames(joints: Array, configuration: NDArray[np.uint16], frames: Array) -> None:
    """Write the frame after each joint of a configuration, the first one before all of them, (j + 1, 12)."""
    for k in range(12):
        frames[0, k] = 1.0 if k in (3, 7, 11) else 0.0
    for joint in range(len(joints)):
        for k in range(12):
            frames[joint + 1, k] = frames[joint, k]
        by = joints[joint, LOW] + joints[joint, SPAN] * configuration[joint] / STEPS
        turn_on(frames[joint + 1], joints[joint], by)


class Samples(NamedTuple):
    """What sampling found, over a grid of cells that holds all that the arm may reach.

    Attributes:
        eighths: Of each cell, a bit for each eighth that is reached, (cells,).
        chosen: One configuration for each cell and direction, (cells, 27, j).
        off: How far its palm is from the cell's middle; infinite for none, (cells, 27).
    """

    eighths: NDArray[np.uint8]
    chosen: NDArray[np.uint16]
    off: NDArray[np.float32]


@compiled
def _sampled(
    joints: Array,
    capsules: Array,
    palm: Array,
    wrist: Array,
    carrier: Array,
    count: int,
    cells: int,
    cell_m: float,
) -> Samples:
    """Put the joints anywhere, so many times; the grid has so many cells along each axis, about the shoulder."""
    np.random.seed(0)
    size, half_m, total = len(joints), cells * cell_m / 2 + SHIFT_M, cells**3
    eighths = np.zeros(total, dtype=np.uint8)
    chosen = np.zeros((total, DIRECTIONS, size), dtype=np.uint16)
    off = np.full((total, DIRECTIONS), np.inf, dtype=np.float32)
    frames, steps = np.empty((size + 1, 12)), np.empty(size, dtype=np.uint16)
    for _ in range(count):
        for joint in range(size):
            drawn = np.random.random()
            if drawn < EDGE_SHARE:
                steps[joint] = 0 if drawn < EDGE_SHARE / 2 else STEPS
            else:
                steps[joint] = int((drawn - EDGE_SHARE) / (1.0 - EDGE_SHARE) * STEPS)
        put_frames(joints, steps, frames)
        x, y, z = put(frames[size], palm[0], palm[1], palm[2])
        i, j, k = int((x + half_m) / cell_m), int((y + half_m) / cell_m), int((z + half_m) / cell_m)
        if min(i, j, k) < 1 or max(i, j, k) >= cells - 1 or _pushes(frames, capsules, carrier):
            continue
        wx, wy, wz = put(frames[size], wrist[0], wrist[1], wrist[2])
        direction = pointing(x - wx, y - wy, z - wz)
        cell = (i * cells + j) * cells + k
        mx, my, mz = x + half_m - (i + 0.5) * cell_m, y + half_m - (j + 0.5) * cell_m, z + half_m - (k + 0.5) * cell_m
        away = mx * mx + my * my + mz * mz
        if away < off[cell, direction]:
            off[cell, direction] = away
            for joint in range(size):
                chosen[cell, direction, joint] = steps[joint]
        _mark(eighths, cells, cell_m / 2, x + half_m, y + half_m, z + half_m)
    return Samples(eighths, chosen, off)


@compiled_part
def _mark(eighths: NDArray[np.uint8], cells: int, fine_m: float, x: float, y: float, z: float) -> None:
    """Note which eighths of cells have their middles within half a cell of a place, from the grid's corner."""
    i, j, k = int(x / fine_m), int(y / fine_m), int(z / fine_m)
    for a in range(i - 1, i + 2):
        dx = x - (a + 0.5) * fine_m
        for b in range(j - 1, j + 2):
            dy = y - (b + 0.5) * fine_m
            for c in range(k - 1, k + 2):
                dz = z - (c + 0.5) * fine_m
                if dx * dx + dy * dy + dz * dz <= fine_m * fine_m:
                    bit = 4 * (a % 2) + 2 * (b % 2) + c % 2
                    eighths[((a // 2) * cells + b // 2) * cells + c // 2] |= np.uint8(1 << bit)


@compiled
def _palms(joints: Array, palm: Array, configurations: NDArray[np.uint16]) -> NDArray[np.float32]:
    """Where configurations, (n, j), bring the palm, metres, (n, 3)."""
    found, frames = np.empty((len(configurations), 3), dtype=np.float32), np.empty((len(joints) + 1, 12))
    for row in range(len(configurations)):
        put_frames(joints, configurations[row], frames)
        found[row, 0], found[row, 1], found[row, 2] = put(frames[len(joints)], palm[0], palm[1], palm[2])
    return found


@compiled_part
def pointing(x: float, y: float, z: float) -> int:
    """Which of the 27 directions a vector points in."""
    least = SPREAD * math.sqrt(x * x + y * y + z * z)
    found = 0
    for part in (x, y, z):
        found = 3 * found + (2 if part > least else 0 if part < -least else 1)
    return found


@compiled_part
def _pushes(frames: Array, capsules: Array, carrier: Array) -> bool:
    """Whether the outer links push into what carries the arm: the innermost one is joined to it."""
    inner = 0.0
    for c in range(len(capsules)):
        carried = capsules[c, CARRIED]
        if carried == 0.0:
            continue
        inner = carried if inner == 0.0 else inner
        if carried == inner:
            continue
        frame = frames[int(carried)]
        for share in (0.0, 0.33, 0.67, 1.0):
            x = capsules[c, 0] + share * (capsules[c, END] - capsules[c, 0])
            y = capsules[c, 1] + share * (capsules[c, END + 1] - capsules[c, 1])
            z = capsules[c, 2] + share * (capsules[c, END + 2] - capsules[c, 2])
            x, y, z = put(frame, x, y, z)
            for s in range(len(carrier)):
                dx, dy, dz = x - carrier[s, AT], y - carrier[s, AT + 1], z - carrier[s, AT + 2]
                lx = dx * carrier[s, TURNED] + dy * carrier[s, TURNED + 3] + dz * carrier[s, TURNED + 6]
                ly = dx * carrier[s, TURNED + 1] + dy * carrier[s, TURNED + 4] + dz * carrier[s, TURNED + 7]
                lz = dx * carrier[s, TURNED + 2] + dy * carrier[s, TURNED + 5] + dz * carrier[s, TURNED + 8]
                if outside_m(carrier, s, lx, ly, lz) < capsules[c, THICK] - SUNK_M:
                    return True
    return False


# --- The map.


@dataclass(frozen=True, eq=False)
class CapabilityMap:
    """Where the palm of an arm gets to, in the frame of its chain.

    Attributes:
        chain: The arm.
        corner: Lowest corner of the grid, metres, (3,).
        cell_m: Edge of a cell.
        shape: Cells along x, y and z.
        eighths: Of each cell, a bit for each eighth that is reached, (cells,); the bit is 4 x + 2 y + z of the halves.
        starts: Where the configurations of each cell begin, one more at the end, (cells + 1,).
        configurations: Steps of the joints' spans, 0 to 65,535, (n, j).
        directions: In which of 27 directions the hand then points, (n,).
        palms: Where the palm is then, metres, (n, 3).
    """

    chain: ArmChain
    corner: Array
    cell_m: float
    shape: tuple[int, int, int]
    eighths: NDArray[np.uint8]
    starts: Indices
    configurations: NDArray[np.uint16]
    directions: NDArray[np.uint8]
    palms: NDArray[np.float32]

    @cached_property
    def radius_m(self) -> float:
        """How far from the shoulder the palm gets, and half a cell: nothing farther is reached."""
        cells = np.flatnonzero(self.eighths)
        if not len(cells):
            return 0.0
        index = np.stack(np.unravel_index(cells, self.shape), axis=1)
        low, found = self.corner + index * self.cell_m, 0.0
        for bit in range(8):
            half = np.array((bit >> 2 & 1, bit >> 1 & 1, bit & 1))
            middles = (low + (half + 0.5) * self.cell_m / 2)[self.eighths[cells] >> bit & 1 == 1]
            if len(middles):
                found = max(found, float(np.linalg.norm(middles, axis=1).max()))
        return found + math.sqrt(3) * self.cell_m / 4

    @classmethod
    def of(cls, chain: ArmChain, count: int) -> CapabilityMap:
        """Sample an arm so many times."""
        stretched_m = _longest_m(chain)
        cell_m = CELL_M * max(1.0, stretched_m / LONG_M)
        cells = 2 * math.ceil(stretched_m / cell_m) + 4
        found = _sampled(chain.joints, chain.capsules, chain.palm, chain.wrist, chain.carrier, count, cells, cell_m)
        kept = np.isfinite(found.off)
        grid = (found.eighths > 0) | kept.any(axis=1)
        index = np.stack(np.unravel_index(np.flatnonzero(grid), (cells,) * 3), axis=1)
        if not len(index):
            index = np.zeros((1, 3), dtype=np.intp)
        low, high = index.min(axis=0), index.max(axis=0) + 1
        cut = tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))
        kept = kept.reshape(cells, cells, cells, DIRECTIONS)[cut]
        eighths = found.eighths.reshape(cells, cells, cells)[cut].ravel()
        flat = kept.reshape(-1, DIRECTIONS)
        chosen = found.chosen.reshape(cells, cells, cells, DIRECTIONS, len(chain.joints))[cut][kept]
        return cls(
            chain=chain,
            corner=low * cell_m - cells * cell_m / 2 - SHIFT_M,
            cell_m=cell_m,
            shape=(int(high[0] - low[0]), int(high[1] - low[1]), int(high[2] - low[2])),
            eighths=eighths,
            starts=np.concatenate(((0,), np.cumsum(flat.sum(axis=1)))).astype(np.intp),
            configurations=chosen,
            directions=np.broadcast_to(np.arange(DIRECTIONS, dtype=np.uint8), flat.shape)[flat],
            palms=_palms(chain.joints, chain.palm, chosen),
        )


def _longest_m(chain: ArmChain) -> float:
    """What the palm is never farther away than: the lengths from joint to joint, and what slides."""
    points = np.concatenate((np.zeros((1, 3)), chain.joints[:, :3], chain.palm[None]))
    slides = chain.joints[chain.joints[:, SLIDES] == 1]
    farthest = np.maximum(np.abs(slides[:, LOW]), np.abs(slides[:, LOW] + slides[:, SPAN])).sum()
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum() + farthest) + CELL_M


# --- Maps on request: one for all arms that are alike, kept for the next time.


@dataclass(frozen=True)
class ArmReach:
    """The map of an arm, which may be that of another one that is alike.

    Attributes:
        map: The map.
        mirrored: Whether the arm is that of the other side.
        scale: How many times as large the arm is.
    """

    map: CapabilityMap
    mirrored: bool
    scale: float


USUAL_M = 1.75
"""Stature of the body whose map serves all people of its proportions, metres."""
ALIKE_M = 0.01
"""How far links of people may differ from those of that body, scaled: widths of hands do not scale (ours)."""


def reach_of(chain: ArmChain, side: str, human_stature_m: float | None = None) -> ArmReach:
    """What an arm reaches.

    Args:
        chain: The arm.
        side: ``left`` or ``right``.
        human_stature_m: Stature of a body that may have the usual human proportions; None for other bodies.
    """
    mirrored = side == "right"
    left = chain.mirrored() if mirrored else chain
    if human_stature_m is not None:
        scale = human_stature_m / USUAL_M
        if left.scaled(1.0 / scale).is_about(_usual(), ALIKE_M):
            return ArmReach(capability(_usual()), mirrored, scale)
    return ArmReach(capability(left), mirrored, 1.0)


@lru_cache(maxsize=1)
def _usual() -> ArmChain:
    """The left arm of the usual human body."""
    model = mujoco.MjModel.from_xml_string(human_mjcf(HumanSize.from_stature(USUAL_M)))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    bodies = {"root": "left_clavicle", "hand": "left_hand", "carrier": "torso"}
    indices = {name: int(model.body(body).id) for name, body in bodies.items()}
    sites = {"shoulder": int(model.site("left_shoulder").id), "palm": int(model.site("left_palm").id)}
    arm = ("left_clavicle", "left_upper_arm", "left_forearm", "left_hand")
    geoms = np.flatnonzero(np.isin(model.geom_bodyid, [model.body(name).id for name in arm]))
    return chain_of(model, data, indices | sites, geoms)


@lru_cache(maxsize=32)
def _map_for(digest: str) -> list[CapabilityMap]:  # noqa: ARG001 - one place for each digest
    return []


def capability(chain: ArmChain) -> CapabilityMap:
    """The map of an arm: known, kept from an earlier run, or made now and kept."""
    known = _map_for(chain.digest)
    if not known:
        known.append(_kept(chain) or _made(chain))
    return known[0]


NAMES = ("grid", "shape", "eighths", "starts", "configurations", "directions", "palms")
MOST_BYTES = 2**28


def _file(chain: ArmChain) -> Path:
    return cache_folder().parent / "arms" / f"arm-{chain.digest}.npz"


def _made(chain: ArmChain) -> CapabilityMap:
    log.info("an arm is met for the first time: finding out where it gets to, once")
    found = CapabilityMap.of(chain, SAMPLES)
    file = _file(chain)
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with writing(file, replace=True) as stream:
            np.savez(
                stream,
                grid=np.array((*found.corner, found.cell_m)),
                shape=np.array(found.shape),
                eighths=found.eighths,
                starts=found.starts.astype(np.int64),
                configurations=found.configurations,
                directions=found.directions,
                palms=found.palms,
            )
    except (OSError, InputError) as error:
        log.info("where an arm gets to is not kept for the next time: %s", error)
    return found


def _kept(chain: ArmChain) -> CapabilityMap | None:
    """The map that an earlier run left; None where there is none, or none of use."""
    file = _file(chain)
    if not file.is_file():
        return None
    with suppress(InputError, OSError, ValueError, KeyError):
        arrays = ArrayFile(file, most_bytes=MOST_BYTES)
        grid, shape, eighths, starts, configurations, directions, palms = (arrays.array(name) for name in NAMES)
        size = (int(shape[0]), int(shape[1]), int(shape[2]))
        whole = (
            grid.shape == (4,)
            and eighths.shape == (math.prod(size),)
            and starts.shape == (len(eighths) + 1,)
            and starts[0] == 0
            and bool((np.diff(starts) >= 0).all())
            and configurations.shape == (starts[-1], len(chain.joints))
            and directions.shape == (starts[-1],)
            and palms.shape == (starts[-1], 3)
        )
        if whole and min(size) > 0:
            return CapabilityMap(
                chain,
                grid[:3].astype(np.float64),
                float(grid[3]),
                size,
                eighths.astype(np.uint8),
                starts.astype(np.intp),
                configurations.astype(np.uint16),
                directions.astype(np.uint8),
                palms.astype(np.float32),
            )
    return None
