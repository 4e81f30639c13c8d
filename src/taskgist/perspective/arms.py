"""Arms as compiled functions take them: which points they reach, and whether there is a way for the arm to get there.

Two models of reach (``settings.reach.model``):

- ``capability``: the arm's own joints, as its capability map has them (``world.bodies.capability``), and *closed is
  closed*: a point is reached if some configuration that brings the palm near it is free. Its links, as capsules, push
  into nothing solid, and the straight way from the palm to the point, ``settings.reach.touch_m`` at most, is free.
  What is to be reached is not in its own way, nor is what the agent holds.
- ``sector``: the paper's rough reach (5.1.2), the arm's length and a sector of azimuth and elevation about the
  shoulder; nothing is in the way of it.

Shoulders are given as rows of 12: where they are, and the frame of what carries the arm, x forward and z up.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.settings import ReachModel
from taskgist.world.bodies.agent import ArmIndices
from taskgist.world.bodies.arm_chain import CARRIED, END, THICK, put, put_frames
from taskgist.world.bodies.capability import CapabilityMap
from taskgist.world.geometry.solids import AT, BALL, TURNED, line_meets, outside_m

ROUNDING = 1e-9
NOTHING = -1


class Arms(NamedTuple):
    """Some arms of an agent.

    Attributes:
        sectors: How far each arm reaches in metres, whether it is mirrored, and lowest and highest azimuth and
            elevation in radians, (a, 6).
        grids: Lowest corner of its map and edge of a cell, metres, and how many times as large the arm is, (a, 5).
        places: Where what belongs to it stands: first cell, cells along x, y and z (none: its sector counts), first
            of ``starts``, first joint and their number, first capsule and their number, (a, 9).
        eighths: Of the cells of all maps, a bit for each eighth that is reached.
        starts: Where the configurations of each cell begin.
        configurations: Steps of the joints' spans, (n, j).
        palms: Where they bring the palm, metres, (n, 3).
        joints: Rows of the chains.
        capsules: Rows of the chains.
        insides: Where in each arm's hand the way to the palm begins, metres, (a, 3).
    """

    sectors: Array
    grids: Array
    places: Indices
    eighths: NDArray[np.uint8]
    starts: Indices
    configurations: NDArray[np.uint16]
    palms: NDArray[np.float32]
    joints: Array
    capsules: Array
    insides: Array


@lru_cache(maxsize=64)
def arms_of(arms: tuple[ArmIndices, ...], model: ReachModel) -> Arms:
    """Some arms of an agent, by one of the models of reach."""
    sectors = np.array([arm.sector for arm in arms]).reshape(-1, 6)
    grids, places = np.ones((len(arms), 5)), np.zeros((len(arms), 9), dtype=np.intp)
    if model == "sector":
        return Arms(sectors, grids, places, *_joined(()), np.zeros((len(arms), 3)))
    reaches = [arm.reach for arm in arms]
    maps = tuple(dict.fromkeys(reach.map for reach in reaches))
    for row, reach in enumerate(reaches):
        index, found = maps.index(reach.map), reach.map
        before, chain = maps[:index], found.chain
        cell, joint, capsule = (
            (
                sum(len(part) for part in parts)
                for parts in zip(
                    *((each.eighths, each.chain.joints, each.chain.capsules) for each in before), strict=True
                )
            )
            if before
            else (0, 0, 0)
        )
        sizes = (len(chain.joints), len(chain.capsules))
        places[row] = (cell, *found.shape, cell + index, joint, sizes[0], capsule, sizes[1])
        grids[row] = (*found.corner, found.cell_m, reach.scale)
        sectors[row, 0] = found.radius_m * reach.scale
    insides = np.array([reach.map.chain.inside for reach in reaches]).reshape(-1, 3)
    return Arms(sectors, grids, places, *_joined(maps), insides)


Joined = tuple[NDArray[np.uint8], Indices, NDArray[np.uint16], NDArray[np.float32], Array, Array]


@lru_cache(maxsize=16)
def _joined(maps: tuple[CapabilityMap, ...]) -> Joined:
    """The tables of some maps, one behind the other."""
    joints = max((each.configurations.shape[1] for each in maps), default=0)
    rows = np.cumsum([0, *(len(each.configurations) for each in maps)])
    configurations = np.zeros((int(rows[-1]), joints), dtype=np.uint16)
    for each, first in zip(maps, rows.tolist(), strict=False):
        configurations[first : first + len(each.configurations), : each.configurations.shape[1]] = each.configurations
    starts = [each.starts + first for each, first in zip(maps, rows.tolist(), strict=False)]
    chains = [each.chain for each in maps]
    return (
        np.concatenate([np.zeros(0, np.uint8), *(each.eighths for each in maps)]),
        np.concatenate([np.zeros(0, np.intp), *starts]),
        configurations,
        np.concatenate([np.zeros((0, 3), np.float32), *(each.palms for each in maps)]),
        np.concatenate([np.zeros((0, 9)), *(chain.joints for chain in chains)]),
        np.concatenate([np.zeros((0, 9)), *(chain.capsules for chain in chains)]),
    )


@compiled
def distance_m(pose: Array, point: Array) -> float:
    """How far a point is from where a pose is."""
    x, y, z = point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]
    return math.sqrt(x * x + y * y + z * z)


@compiled_part
def seen_by(pose: Array, arms: Arms, arm: int, point: Array) -> tuple[float, float, float]:
    """A point of the world in the frame of an arm, not scaled: the right arm's y is turned about."""
    dx, dy, dz = point[0] - pose[0], point[1] - pose[1], point[2] - pose[2]
    x = dx * pose[3] + dy * pose[6] + dz * pose[9]
    y = dx * pose[4] + dy * pose[7] + dz * pose[10]
    z = dx * pose[5] + dy * pose[8] + dz * pose[11]
    return x, -y if arms.sectors[arm, 1] else y, z


@compiled_part
def in_reach(pose: Array, arms: Arms, arm: int, point: Array) -> bool:
    """Whether an arm reaches a point, (3,), from a shoulder, (12,), whatever is in the way."""
    sectors, places = arms.sectors, arms.places
    if distance_m(pose, point) > sectors[arm, 0] + ROUNDING:
        return False
    x, y, z = seen_by(pose, arms, arm, point)
    if places[arm, 1] == 0:
        azimuth, elevation = math.atan2(y, x), math.atan2(z, math.hypot(x, y))
        return bool(
            sectors[arm, 2] - ROUNDING <= azimuth <= sectors[arm, 3] + ROUNDING
            and sectors[arm, 4] - ROUNDING <= elevation <= sectors[arm, 5] + ROUNDING
        )
    half, scale = arms.grids[arm, 3] / 2, arms.grids[arm, 4]
    i = math.floor((x / scale - arms.grids[arm, 0] + ROUNDING) / half)
    j = math.floor((y / scale - arms.grids[arm, 1] + ROUNDING) / half)
    k = math.floor((z / scale - arms.grids[arm, 2] + ROUNDING) / half)
    if min(i, j, k) < 0 or i >= 2 * places[arm, 1] or j >= 2 * places[arm, 2] or k >= 2 * places[arm, 3]:
        return False
    cell = places[arm, 0] + ((i // 2) * places[arm, 2] + j // 2) * places[arm, 3] + k // 2
    return bool(arms.eighths[cell] >> (4 * (i % 2) + 2 * (j % 2) + k % 2) & 1)


# --- The way of an arm: whether some configuration that brings the palm near a point pushes into nothing.


class Around(NamedTuple):
    """What may be in the way of arms.

    Attributes:
        solids: The shapes, (n, 17); see ``geometry.solids``.
        usual: Whether what hangs on each arm's carrier itself, a collarbone, touches each shape now, (a, n).
        touch_m: How far a palm may be from what it is to touch.
        squeeze_m: How deep an arm may push into things.
        asked: Whether anything is in the way at all: not by the sector's model.
        felt: Lowest and highest corner of a box, made to hold all arms that are held against the shapes, (2, 3).
    """

    solids: Array
    usual: Mask
    touch_m: float
    squeeze_m: float
    asked: bool
    felt: Array


@compiled_part
def _feel(felt: Array, x: float, y: float, z: float, radius_m: float) -> None:
    felt[0, 0], felt[1, 0] = min(felt[0, 0], x - radius_m), max(felt[1, 0], x + radius_m)
    felt[0, 1], felt[1, 1] = min(felt[0, 1], y - radius_m), max(felt[1, 1], y + radius_m)
    felt[0, 2], felt[1, 2] = min(felt[0, 2], z - radius_m), max(felt[1, 2], z + radius_m)


@compiled
def free_configuration(pose: Array, arms: Arms, arm: int, point: Array, around: Around, met: Indices) -> int:
    """The first free configuration of an arm that brings its palm near a point.

    Args:
        pose: Its shoulder, (12,).
        arms: The arms.
        arm: Which of them.
        point: Metres, (3,).
        around: What may be in the way.
        met: Counted up: how many configurations each shape is in the way of, (n,).

    Returns:
        Its index, −1 if there is none.
    """
    places, grids, scale = arms.places, arms.grids, arms.grids[arm, 4]
    joints = arms.joints[places[arm, 5] : places[arm, 5] + places[arm, 6]]
    frames = np.empty((len(joints) + 1, 12))
    for k in range(12):
        frames[0, k] = 1.0 if k in (3, 7, 11) else 0.0
    lines = np.empty((places[arm, 8], 7))
    row = links_meet(pose, arms, arm, frames, lines, around, True, NOTHING)
    if row >= 0:
        met[row] += 1
        return NOTHING
    x, y, z = seen_by(pose, arms, arm, point)
    x, y, z, cell_m = x / scale, y / scale, z / scale, grids[arm, 3]
    fx, fy, fz = (x - grids[arm, 0]) / cell_m, (y - grids[arm, 1]) / cell_m, (z - grids[arm, 2]) / cell_m
    ci, cj, ck = math.floor(fx + ROUNDING), math.floor(fy + ROUNDING), math.floor(fz + ROUNDING)
    si = 1 if fx - ci >= 0.5 else -1
    sj = 1 if fy - cj >= 0.5 else -1
    sk = 1 if fz - ck >= 0.5 else -1
    near, last = (around.touch_m / scale) ** 2, NOTHING
    for beside in range(8):  # the point's own cell, then those beside it on its side
        i, j, k = ci + si * (beside & 1), cj + sj * (beside >> 1 & 1), ck + sk * (beside >> 2 & 1)
        if min(i, j, k) < 0 or i >= places[arm, 1] or j >= places[arm, 2] or k >= places[arm, 3]:
            continue
        first = places[arm, 4] + (i * places[arm, 2] + j) * places[arm, 3] + k
        for chosen in range(arms.starts[first], arms.starts[first + 1]):
            px, py, pz = float(arms.palms[chosen, 0]), float(arms.palms[chosen, 1]), float(arms.palms[chosen, 2])
            if (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2 > near:
                continue
            put_frames(joints, arms.configurations[chosen], frames)
            row = links_meet(pose, arms, arm, frames, lines, around, False, last)
            if row < 0:
                hx, hy, hz = put(frames[len(joints)], arms.insides[arm, 0], arms.insides[arm, 1], arms.insides[arm, 2])
                hx, hy, hz = in_world(pose, arms, arm, hx, hy, hz)
                wx, wy, wz = in_world(pose, arms, arm, px, py, pz)
                _feel(around.felt, hx, hy, hz, 0.0)
                _feel(around.felt, wx, wy, wz, 0.0)
                _feel(around.felt, point[0], point[1], point[2], 0.0)
                row = first_met(around.solids, hx, hy, hz, wx, wy, wz, 0.0)
                if row < 0:
                    row = first_met(around.solids, wx, wy, wz, point[0], point[1], point[2], 0.0)
            if row < 0:
                return chosen
            met[row] += 1
            last = row
    return NOTHING


@compiled_part
def squeezed_m(radius_m: float, squeeze_m: float) -> float:
    """Radius of a link where it pushes into something: thin ones give way by a quarter at most."""
    return radius_m - min(squeeze_m, radius_m / 4)


@compiled_part
def in_world(pose: Array, arms: Arms, arm: int, x: float, y: float, z: float) -> tuple[float, float, float]:
    """A point of an arm's map in the world."""
    scale = arms.grids[arm, 4]
    x, y, z = scale * x, scale * (-y if arms.sectors[arm, 1] else y), scale * z
    return (
        pose[0] + pose[3] * x + pose[4] * y + pose[5] * z,
        pose[1] + pose[6] * x + pose[7] * y + pose[8] * z,
        pose[2] + pose[9] * x + pose[10] * y + pose[11] * z,
    )


@compiled_part
def links_meet(
    pose: Array, arms: Arms, arm: int, frames: Array, lines: Array, around: Around, fixed: bool, first: int
) -> int:
    """The first shape, by row, that links push into, those that no joint moves or the others; −1 for none.

    The lines through the links, (c, 7), are written; shapes are tried from one that is likely to be met on.
    """
    start, scale, count = arms.places[arm, 7], arms.grids[arm, 4], 0
    for link in range(start + arms.places[arm, 8] - 1, start - 1, -1):  # hands are mostly the first to meet something
        c = arms.capsules[link]
        carried = int(c[CARRIED])
        if (carried == 0) == fixed:
            ax, ay, az = put(frames[carried], c[0], c[1], c[2])
            bx, by, bz = put(frames[carried], c[END], c[END + 1], c[END + 2])
            lines[count, 0], lines[count, 1], lines[count, 2] = in_world(pose, arms, arm, ax, ay, az)
            lines[count, 3], lines[count, 4], lines[count, 5] = in_world(pose, arms, arm, bx, by, bz)
            lines[count, 6] = squeezed_m(c[THICK] * scale, around.squeeze_m)
            for end in range(0, 6, 3):
                _feel(around.felt, lines[count, end], lines[count, end + 1], lines[count, end + 2], lines[count, 6])
            count += 1
    for k in range(-1, len(around.solids)):
        row = first if k < 0 else k
        if row < 0 or (fixed and around.usual[arm, row]):
            continue
        for n in range(count):
            w = lines[n]
            if line_meets(around.solids, row, w[0], w[1], w[2], w[3], w[4], w[5], w[6]):
                return row
    return NOTHING


@compiled
def first_met(solids: Array, ax: float, ay: float, az: float, bx: float, by: float, bz: float, radius_m: float) -> int:
    """The first shape, by row, that a thick line meets; −1 for none."""
    for row in range(len(solids)):
        if line_meets(solids, row, ax, ay, az, bx, by, bz, radius_m):
            return row
    return NOTHING


WITHIN_M = 1e-6
"""More than what is within a shape may seem outside by rounding."""


@compiled
def all_within(points: Array, solids: Array) -> bool:
    """Whether all of some points, (k, 3), are within solid shapes, (n, 17): no straight way ends there."""
    for k in range(len(points)):
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        if first_met(solids, x, y, z, x, y, z, -WITHIN_M) < 0:
            return False
    return True


@compiled
def usually_met(shoulders: Array, arms: Arms, solids: Array, squeeze_m: float, felt: Array) -> Mask:
    """Whether what hangs on each arm's carrier itself touches each shape; shoulders are (a, 12), ``felt`` as above.

    Returns:
        By arm and shape, (a, n).
    """
    found = np.zeros((len(shoulders), len(solids)), dtype=np.bool_)
    for arm in range(len(shoulders)):
        for link in range(arms.places[arm, 7], arms.places[arm, 7] + arms.places[arm, 8]):
            c = arms.capsules[link]
            if c[CARRIED] != 0.0:
                continue
            radius_m = squeezed_m(c[THICK] * arms.grids[arm, 4], squeeze_m)
            ax, ay, az = in_world(shoulders[arm], arms, arm, c[0], c[1], c[2])
            bx, by, bz = in_world(shoulders[arm], arms, arm, c[END], c[END + 1], c[END + 2])
            _feel(felt, ax, ay, az, radius_m)
            _feel(felt, bx, by, bz, radius_m)
            for row in range(len(solids)):
                found[arm, row] |= line_meets(solids, row, ax, ay, az, bx, by, bz, radius_m)
    return found


# --- What is shut in: no hand gets at it from outside, wherever the agent stands.

VOXEL_M = 0.012
BALL_M = 0.007
"""A ball of more than half a voxel's radius passes no wall between two voxels, however thin, and every gap that a
finger passes."""
SIDES = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))


@compiled
def shut_in(
    points: Array, middle: Array, radius_m: float, inside: Array, solids: Array, met: Indices, felt: Array
) -> bool:
    """Whether no way leads from an object to where an arm comes from: a flood of the free space around it ends.

    Args:
        points: In the object, metres, (k, 3).
        middle: Of a ball, (3,).
        radius_m: Its radius: whatever leads out of it is a way.
        inside: Points to which a way is one as well: shoulders, (s, 3).
        solids: What may be in the way, (n, 17).
        met: Counted up: how many ends of the flood each shape makes, (n,).
        felt: Lowest and highest corner of a box, made to hold the flood, (2, 3).
    """
    half = math.ceil(radius_m / VOXEL_M) + 1
    across = 2 * half + 1
    done = np.zeros(across**3, dtype=np.uint8)
    stack, goals = np.empty(across**3, dtype=np.int32), np.empty(len(inside), dtype=np.int64)
    for s in range(len(inside)):
        goals[s] = _voxel(inside[s], middle, half, across)
    for k in range(len(points)):
        _feel(felt, points[k, 0], points[k, 1], points[k, 2], VOXEL_M)
    count = begun = _start(points, middle, half, solids, done, stack)
    order = np.empty(6, dtype=np.intp)
    while count:
        count -= 1
        at = int(stack[count])
        i, j, k = at // (across * across) - half, at // across % across - half, at % across - half
        if i * i + j * j + k * k >= (half - 1) ** 2:
            return False
        for s in range(len(goals)):
            if goals[s] == at:
                return False
        _outwards_last(i, j, k, order)
        for side in order:
            a, b, c = i + SIDES[side][0], j + SIDES[side][1], k + SIDES[side][2]
            following = ((a + half) * across + b + half) * across + c + half
            if done[following]:
                continue
            done[following] = 1
            x, y, z = middle[0] + a * VOXEL_M, middle[1] + b * VOXEL_M, middle[2] + c * VOXEL_M
            _feel(felt, x, y, z, BALL_M)
            row = _ball_met(solids, x, y, z)
            if row >= 0:
                met[row] += 1
                continue
            stack[count] = following
            count += 1
    return begun > 0


@compiled_part
def _start(
    points: Array, middle: Array, half: int, solids: Array, done: NDArray[np.uint8], stack: NDArray[np.int32]
) -> int:
    """Put the free voxels of some points on the stack, and tell how many."""
    count, across = 0, 2 * half + 1
    for k in range(len(points)):
        at = _voxel(points[k], middle, half, across)
        if at < 0 or done[at]:
            continue
        done[at] = 1
        x = middle[0] + (at // (across * across) - half) * VOXEL_M
        y = middle[1] + (at // across % across - half) * VOXEL_M
        z = middle[2] + (at % across - half) * VOXEL_M
        if _ball_met(solids, x, y, z) < 0:
            stack[count] = at
            count += 1
    return count


@compiled_part
def _outwards_last(i: int, j: int, k: int, order: Indices) -> None:
    """Order the sides of a voxel: what is pushed last is looked at first, and most things are open."""
    first, last = 0, 5
    for side in range(6):
        if SIDES[side][0] * i + SIDES[side][1] * j + SIDES[side][2] * k > 0:
            order[last] = side
            last -= 1
        else:
            order[first] = side
            first += 1


@compiled_part
def _voxel(point: Array, middle: Array, half: int, across: int) -> int:
    i = int(np.rint((point[0] - middle[0]) / VOXEL_M)) + half
    j = int(np.rint((point[1] - middle[1]) / VOXEL_M)) + half
    k = int(np.rint((point[2] - middle[2]) / VOXEL_M)) + half
    inside = min(i, j, k) >= 1 and max(i, j, k) < across - 1
    return (i * across + j) * across + k if inside else NOTHING


@compiled_part
def _ball_met(solids: Array, x: float, y: float, z: float) -> int:
    """The first shape that a ball about a point meets; −1 for none."""
    for row in range(len(solids)):
        dx, dy, dz = x - solids[row, AT], y - solids[row, AT + 1], z - solids[row, AT + 2]
        most = max(solids[row, BALL] + BALL_M, 0.0)
        if dx * dx + dy * dy + dz * dz > most * most:
            continue
        lx = dx * solids[row, TURNED] + dy * solids[row, TURNED + 3] + dz * solids[row, TURNED + 6]
        ly = dx * solids[row, TURNED + 1] + dy * solids[row, TURNED + 4] + dz * solids[row, TURNED + 7]
        lz = dx * solids[row, TURNED + 2] + dy * solids[row, TURNED + 5] + dz * solids[row, TURNED + 8]
        if outside_m(solids, row, lx, ly, lz) < BALL_M:
            return row
    return NOTHING
