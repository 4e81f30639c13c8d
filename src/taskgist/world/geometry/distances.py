"""Signed distances between shapes: bounds and boxes first, which settle most pairs, then the gaps of the others."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled, compiled_part
from taskgist.world.geometry.rays import BOX, CAPSULE, SPHERE, local
from taskgist.world.geometry.transforms import conjugate, rotate

# --- Bounds that hold all that is seen.
#
# MuJoCo casts many rays at once past bodies whose box they miss, and makes that box of the shapes that collide. What
# a body only shows may stick out of it, as the visual meshes of most robots do, and rays would pass through.

SIGNS = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))


def bound_all_shapes(model: mujoco.MjModel) -> None:
    """Widen each body's box in a compiled model to all of its shapes."""
    for body in range(model.nbody):
        geoms = np.flatnonzero(model.geom_bodyid == body)
        if model.body_bvhnum[body] and not _collide(model, geoms).all() and _bounded(model, geoms).all():
            box = model.bvh_aabb[model.body_bvhadr[body]]
            corners = [_corners(model, body, int(geom)) for geom in geoms]
            points = np.concatenate([box[:3] + SIGNS * box[3:], *corners])
            low, high = points.min(axis=0), points.max(axis=0)
            model.bvh_aabb[model.body_bvhadr[body]] = (*(low + high) / 2, *(high - low) / 2)


def _collide(model: mujoco.MjModel, geoms: Indices) -> Mask:
    return np.asarray((model.geom_contype[geoms] != 0) | (model.geom_conaffinity[geoms] != 0))


def _bounded(model: mujoco.MjModel, geoms: Indices) -> Mask:
    """Planes have no end."""
    return np.asarray(model.geom_rbound[geoms] > 0)


def _corners(model: mujoco.MjModel, body: int, geom: int) -> Array:
    """Corners (8, 3) of a shape's box in the frame of the body's inertia, in which MuJoCo keeps its boxes."""
    box = model.geom_aabb[geom]
    in_body = model.geom_pos[geom] + rotate(model.geom_quat[geom], box[:3] + SIGNS * box[3:])
    return rotate(conjugate(model.body_iquat[body]), in_body - model.body_ipos[body])


# --- Boxes around shapes: two shapes are no nearer, and overlap no deeper, than their boxes.
#
# Boxes are rows of one table, (n, 18), so that compiled functions pass two numbers instead of many arrays:
#
# ======= ==============================================================================================
# columns what
# ======= ==============================================================================================
# 0-2     middle, metres
# 3-11    how the box is turned, a matrix row by row: its columns are the box's axes
# 12-14   half sizes, metres
# 15      radius of a ball about the middle that holds the shape, metres
# 16      radius of a ball about the middle that lies within the shape, metres; 0 where none is known
# 17      1 if the shape is a box itself: then what is said of the box is said of the shape
# ======= ==============================================================================================
#
# An endless plane is a block of ``ENDLESS_M`` beneath it.

COLUMNS = 18
TURNED, HALF, RADIUS, INNER, EXACT = 3, 12, 15, 16, 17
ENDLESS_M = 1e5


@compiled
def boxes_of(
    geoms: Indices, kinds: NDArray[np.int64], radii: Array, bounds: Array, positions: Array, matrices: Array
) -> Array:
    """Boxes around shapes, (n, 18).

    Args:
        geoms: Indices of the shapes, (n,).
        kinds: MuJoCo's type of every shape of the model, (ngeom,).
        radii: Radii of balls that hold the shapes, metres, infinite for planes, (ngeom,).
        bounds: Middles and half sizes of their boxes, in their own frames, (ngeom, 6).
        positions: Where they are, metres, (ngeom, 3).
        matrices: How they are turned, (ngeom, 9).
    """
    table = np.empty((len(geoms), COLUMNS))
    for row in range(len(geoms)):
        geom = geoms[row]
        endless = np.isinf(radii[geom])
        centred = SPHERE <= kinds[geom] <= BOX  # MuJoCo's order: neither plane, height field nor mesh
        off, across, inner = 0.0, 0.0, math.inf if centred else 0.0
        for axis in range(3):
            half = ENDLESS_M if endless else bounds[geom, 3 + axis]
            table[row, HALF + axis] = half
            across, inner = across + half * half, min(inner, half)
            table[row, axis] = positions[geom, axis]
        for k in range(3):
            middle = (-ENDLESS_M if k == 2 else 0.0) if endless else bounds[geom, k]
            off += middle * middle
            for axis in range(3):
                table[row, TURNED + 3 * axis + k] = matrices[geom, 3 * axis + k]
                table[row, axis] += matrices[geom, 3 * axis + k] * middle
        table[row, RADIUS] = min(math.sqrt(across), radii[geom] + math.sqrt(off))
        table[row, INNER], table[row, EXACT] = inner, 1.0 if kinds[geom] == BOX else 0.0
    return table


def seen_from(table: Array, position: Array, matrix: Array) -> Array:
    """The same boxes in a frame that is at a position (3,), turned by a matrix (3, 3)."""
    seen = table.copy()
    x, y, z = (table[:, :3] - position).T[:, :, None]
    seen[:, :3] = x * matrix[0] + y * matrix[1] + z * matrix[2]
    x, y, z = table[:, TURNED:HALF].reshape(-1, 3, 1, 3).swapaxes(0, 1)
    turned = x * matrix[0, :, None] + y * matrix[1, :, None] + z * matrix[2, :, None]
    seen[:, TURNED:HALF] = turned.reshape(-1, 9)
    return seen


@compiled
def ball_around_boxes(table: Array) -> tuple[float, float, float, float]:
    """Middle and radius of a ball that holds the shapes in some boxes, at least one, metres."""
    cx, cy, cz, radius_m = 0.0, 0.0, 0.0, 0.0
    for row in range(len(table)):
        cx, cy, cz = cx + table[row, 0], cy + table[row, 1], cz + table[row, 2]
    cx, cy, cz = cx / len(table), cy / len(table), cz / len(table)
    for row in range(len(table)):
        x, y, z = table[row, 0] - cx, table[row, 1] - cy, table[row, 2] - cz
        radius_m = max(radius_m, math.sqrt(x * x + y * y + z * z) + table[row, RADIUS])
    return cx, cy, cz, radius_m


@compiled
def near_ball(table: Array, cx: float, cy: float, cz: float, radius_m: float) -> Indices:
    """Rows of those boxes whose balls come nearer than a radius to a point, (n,)."""
    found, count = np.empty(len(table), dtype=np.intp), 0
    for row in range(len(table)):
        x, y, z = table[row, 0] - cx, table[row, 1] - cy, table[row, 2] - cz
        reach = radius_m + table[row, RADIUS]
        if x * x + y * y + z * z < reach * reach:
            found[count] = row
            count += 1
    return found[:count]


PARALLEL = 1e-4
"""Sine of the angle below which edges of two boxes count as parallel: faces keep such boxes apart as well."""


@compiled
def next_near(first: Array, second: Array, limit_m: float, start: int) -> int:
    """The first pair, from a number on, whose gap may be below a limit; −1 if there is none.

    Pairs count along ``second`` first.
    """
    count = max(len(second), 1)
    begin = start % count
    for i in range(start // count, len(first)):
        for j in range(begin, len(second)):
            if may_be_near(first, i, second, j, limit_m):
                return i * count + j
        begin = 0
    return -1


@compiled_part
def may_be_near(first: Array, i: int, second: Array, j: int, limit_m: float) -> bool:
    """Whether the gap of two shapes may be below a limit: neither their balls nor their boxes keep them apart."""
    return bool(least_gap_m(first, i, second, j, limit_m) < limit_m)


@compiled_part
def least_gap_m(first: Array, i: int, second: Array, j: int, enough_m: float) -> float:
    """What the gap of two shapes is at least, metres, by their balls and boxes; nothing beyond ``enough_m`` is told."""
    x, y, z = first[i, 0] - second[j, 0], first[i, 1] - second[j, 1], first[i, 2] - second[j, 2]
    reach = max(first[i, RADIUS] + second[j, RADIUS] + enough_m, 0.0)
    if x * x + y * y + z * z > reach * reach:
        return enough_m
    gap = max(ball_gap_m(first, i, first[i, RADIUS], second, j), ball_gap_m(second, j, second[j, RADIUS], first, i))
    return gap if gap >= enough_m else max(gap, boxes_gap_m(first, i, second, j, enough_m))


@compiled
def any_near(first: Array, offset_m: tuple[float, float], second: Array, limit_m: float) -> bool:
    """Whether any of some shapes, moved along x and y by an offset, may come nearer to any of others than a limit."""
    moved = first.copy()
    for row in range(len(moved)):
        moved[row, 0], moved[row, 1] = moved[row, 0] + offset_m[0], moved[row, 1] + offset_m[1]
    cx, cy, cz, radius_m = ball_around_boxes(moved)
    near = second[near_ball(second, cx, cy, cz, radius_m)]
    return next_near(moved, near, limit_m, 0) >= 0


@compiled
def clear_after(first: Array, offsets_m: Array, second: Array, limit_m: float) -> NDArray[np.bool_]:
    """Whether no shape can come nearer to others than a limit after moving along x and y by each offset, (k, 2)."""
    found = np.empty(len(offsets_m), dtype=np.bool_)
    for row in range(len(offsets_m)):
        found[row] = not any_near(first, (offsets_m[row, 0], offsets_m[row, 1]), second, limit_m)
    return found


@compiled
def surely_overlap(first: Array, i: int, second: Array, j: int, deeper_than_m: float) -> bool:
    """Whether a box, and another shape, overlap deeper than that for sure; False if they do not, or in doubt."""
    if second[j, EXACT] == 1.0:
        return boxes_gap_m(first, i, second, j, np.inf) < -deeper_than_m
    inner_m = second[j, INNER]
    return inner_m > deeper_than_m and ball_gap_m(second, j, inner_m, first, i) < -deeper_than_m


@compiled_part
def ball_gap_m(first: Array, i: int, radius_m: float, second: Array, j: int) -> float:
    """Gap in metres between a ball about a box's middle and another box; minus infinity if that middle is inside."""
    x, y, z = first[i, 0] - second[j, 0], first[i, 1] - second[j, 1], first[i, 2] - second[j, 2]
    squared = 0.0
    for k in range(3):
        along = x * second[j, TURNED + k] + y * second[j, TURNED + 3 + k] + z * second[j, TURNED + 6 + k]
        outside = max(abs(along) - second[j, HALF + k], 0.0)
        squared += outside * outside
    return math.sqrt(squared) - radius_m if squared > 0.0 else -math.inf


@compiled
def boxes_gap_m(first: Array, i: int, second: Array, j: int, enough_m: float) -> float:
    """How far two boxes are apart along the direction that keeps them apart best (separating axes [Gottschalk 1996]).

    Positive: the gap is at least that. Negative: they overlap so deep. A direction that gives ``enough_m`` will do.
    """
    at = (_along(first, i, second, j, 0), _along(first, i, second, j, 1), _along(first, i, second, j, 2))
    turn = (_turned(first, i, second, j, 0), _turned(first, i, second, j, 1), _turned(first, i, second, j, 2))
    half = (first[i, HALF], first[i, HALF + 1], first[i, HALF + 2])
    other = (second[j, HALF], second[j, HALF + 1], second[j, HALF + 2])
    gap = -math.inf
    for a in range(3):
        spans = other[0] * abs(turn[a][0]) + other[1] * abs(turn[a][1]) + other[2] * abs(turn[a][2])
        gap = max(gap, abs(at[a]) - half[a] - spans)
    for b in range(3):
        along = at[0] * turn[0][b] + at[1] * turn[1][b] + at[2] * turn[2][b]
        spans = half[0] * abs(turn[0][b]) + half[1] * abs(turn[1][b]) + half[2] * abs(turn[2][b])
        gap = max(gap, abs(along) - other[b] - spans)
    if gap >= enough_m:
        return gap
    for a in range(3):
        a1, a2 = (a + 1) % 3, (a + 2) % 3
        for b in range(3):
            b1, b2 = (b + 1) % 3, (b + 2) % 3
            sine = math.sqrt(max(1.0 - turn[a][b] * turn[a][b], 0.0))
            if sine > PARALLEL:
                along = abs(at[a2] * turn[a1][b] - at[a1] * turn[a2][b])
                spans = half[a1] * abs(turn[a2][b]) + half[a2] * abs(turn[a1][b])
                spans += other[b1] * abs(turn[a][b2]) + other[b2] * abs(turn[a][b1])
                gap = max(gap, (along - spans) / sine)
    return gap


@compiled_part
def _along(first: Array, i: int, second: Array, j: int, axis: int) -> float:
    """From the first box's middle to the second's, along one of the first one's axes."""
    gap = 0.0
    for k in range(3):
        gap += first[i, TURNED + 3 * k + axis] * (second[j, k] - first[i, k])
    return gap


@compiled_part
def _turned(first: Array, i: int, second: Array, j: int, axis: int) -> tuple[float, float, float]:
    """One of the first box's axes along those of the second."""
    x, y, z = first[i, TURNED + axis], first[i, TURNED + 3 + axis], first[i, TURNED + 6 + axis]
    return (
        x * second[j, TURNED] + y * second[j, TURNED + 3] + z * second[j, TURNED + 6],
        x * second[j, TURNED + 1] + y * second[j, TURNED + 4] + z * second[j, TURNED + 7],
        x * second[j, TURNED + 2] + y * second[j, TURNED + 5] + z * second[j, TURNED + 8],
    )


# --- Signed gaps between two shapes.
#
# MuJoCo measures them, except one that it misses: a capsule whose axis goes right through a thin box, as a thigh
# through a table top, counts as free of it, for only its ends are held against the box. There the capsule is at least
# as deep in the box as its radius, and deeper by as much as its axis is.


@compiled
def axis_depth_m(
    middle: Array, matrix: Array, half_length_m: float, position: Array, frame: Array, half: Array
) -> float:
    """How deep in a box the middle of that piece of a capsule's axis is which lies inside; −1 if none does.

    Args:
        middle: Centre of the capsule, metres, (3,).
        matrix: How it is turned, its axis along z, (9,).
        half_length_m: Half length of its axis.
        position: Centre of the box, metres, (3,).
        frame: How it is turned, (9,).
        half: Its half sizes, metres, (3,).
    """
    at = local(frame, middle - position)
    reach = local(frame, half_length_m * matrix[2::3])
    enter, leave = -1.0, 1.0
    for axis in range(3):
        if abs(reach[axis]) < 1e-12:
            if abs(at[axis]) > half[axis]:
                return -1.0
            continue
        near, far = (-half[axis] - at[axis]) / reach[axis], (half[axis] - at[axis]) / reach[axis]
        enter, leave = max(enter, min(near, far)), min(leave, max(near, far))
    if enter > leave:
        return -1.0
    depth_m = math.inf
    for axis in range(3):
        depth_m = min(depth_m, half[axis] - abs(at[axis] + (enter + leave) / 2 * reach[axis]))
    return depth_m


# --- Clearance: signed gaps between the shapes of a scene in a state.
#
# Balls and boxes around shapes reject most pairs for many at once; MuJoCo measures the rest.

Pair = tuple[int, int]
CROSSING = frozenset({(CAPSULE, BOX), (BOX, CAPSULE)})
"""Kinds of shapes of which one may go right through the other."""


class Clearance:
    """Measures gaps in a model whose shapes are where some data says.

    Attributes:
        measured_count: Pairs measured so far.

    Args:
        model: The model.
        data: Where its shapes are; read anew with every question.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        self._model, self._data = model, data
        self._kinds = np.array(model.geom_type, dtype=np.int64)
        self._kind_of = tuple(self._kinds.tolist())
        self._radii = np.where(model.geom_rbound == 0.0, np.inf, model.geom_rbound)  # endless planes
        self._bounds = np.array(model.geom_aabb)
        self._positions, self._matrices = data.geom_xpos, data.geom_xmat
        self.measured_count = 0

    def gap_m(self, geom: int, other: int, *, limit_m: float) -> float:
        """Signed gap in metres between two shapes (negative: how deep they overlap), at most ``limit_m``."""
        self.measured_count += 1
        if (self._kind_of[geom], self._kind_of[other]) in CROSSING:
            depth_m = self._axis_depth_m(*((geom, other) if self._kind_of[geom] == CAPSULE else (other, geom)))
            if depth_m is not None:
                return -depth_m
        return float(mujoco.mj_geomDistance(self._model, self._data, geom, other, limit_m, None))

    def _axis_depth_m(self, capsule: int, box: int) -> float | None:
        """How deep a capsule is in a box through which its axis goes, metres; None if that does not."""
        data, sizes = self._data, self._model.geom_size
        at = data.geom_xpos[capsule], data.geom_xmat[capsule], float(sizes[capsule, 1])
        depth_m = axis_depth_m(*at, data.geom_xpos[box], data.geom_xmat[box], sizes[box])
        return depth_m + float(sizes[capsule, 0]) if depth_m >= 0.0 else None

    def near_pairs(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> list[Pair]:
        """Pairs of shapes, one of each set, that may come closer than ``limit_m``; all others do not."""
        pairs = near_pairs(
            np.asarray(geoms, dtype=np.intp),
            np.asarray(others, dtype=np.intp),
            self._kinds,
            self._radii,
            self._bounds,
            self._positions,
            self._matrices,
            limit_m,
        )
        return [(first, second) for first, second in pairs.tolist()]

    def boxes(self, geoms: Indices) -> Array:
        """Boxes around shapes where they are now, (n, 18); see ``boxes_of``."""
        return boxes_of(geoms, self._kinds, self._radii, self._bounds, self._positions, self._matrices)

    def closest(self, geoms: ArrayLike, others: ArrayLike, *, limit_m: float) -> tuple[float, int, int]:
        """The smallest signed gap in metres between two sets of shapes, at most ``limit_m``, and the pair or −1."""
        best = (limit_m, -1, -1)
        for geom, other in self.near_pairs(geoms, others, limit_m=limit_m):
            gap = self.gap_m(geom, other, limit_m=limit_m)
            if gap < best[0]:
                best = (gap, geom, other)
        return best

    def overlaps(
        self, geoms: ArrayLike, others: ArrayLike, *, deeper_than_m: float = 0.0
    ) -> Iterator[tuple[int, int, float]]:
        """Pairs of shapes, one of each set, that overlap deeper than that, and how deep in metres."""
        # Half as deep is looked at as well: MuJoCo measures round shapes by iteration, not to the last digit.
        for geom, other in self.near_pairs(geoms, others, limit_m=-deeper_than_m / 2):
            gap = self.gap_m(geom, other, limit_m=0.0)
            if gap < -deeper_than_m:
                yield geom, other, -gap


@compiled
def near_pairs(
    geoms: Indices,
    others: Indices,
    kinds: NDArray[np.int64],
    radii: Array,
    bounds: Array,
    positions: Array,
    matrices: Array,
    limit_m: float,
) -> Indices:
    """Pairs of shapes whose gap may be below a limit, (n, 2); see ``boxes_of``."""
    found, count = np.empty((len(geoms) * len(others), 2), dtype=np.intp), 0
    if not len(geoms) or not len(others):
        return found
    first = boxes_of(geoms, kinds, radii, bounds, positions, matrices)
    cx, cy, cz, radius_m = ball_around_boxes(first)
    near, kept = np.empty(len(others), dtype=np.intp), 0
    for other in others:
        x, y, z = positions[other, 0] - cx, positions[other, 1] - cy, positions[other, 2] - cz
        reach = max(radius_m + radii[other] + limit_m, 0.0)
        if x * x + y * y + z * z <= reach * reach:
            near[kept] = other
            kept += 1
    second = boxes_of(near[:kept], kinds, radii, bounds, positions, matrices)
    pair = next_near(first, second, limit_m, 0)
    while pair >= 0:
        found[count, 0], found[count, 1] = geoms[pair // kept], near[pair % kept]
        count += 1
        pair = next_near(first, second, limit_m, pair + 1)
    return found[:count]
