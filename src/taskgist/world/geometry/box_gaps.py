"""Gaps between boxes around shapes: which pairs of shapes need not be measured, being surely apart, or surely not."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.boxes import EXACT, HALF, INNER, RADIUS, TURNED, ball_around, near_ball
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
PARALLEL = 1e-4
"""Sine of the angle below which edges of two boxes count as parallel: faces keep such boxes apart as well."""


@compiled
def next_near(first: Array, second: Array, limit_m: float, start: int) -> int:
    """The first pair, from a number on, whose gap may be below a limit; −1 if there is none.

    Neither their balls nor their boxes keep its shapes apart. Pairs count along ``second`` first.
    """
    count = max(len(second), 1)
    begin = start % count
    for i in range(start // count, len(first)):
        for j in range(begin, len(second)):
            x, y, z = first[i, 0] - second[j, 0], first[i, 1] - second[j, 1], first[i, 2] - second[j, 2]
            reach = max(first[i, RADIUS] + second[j, RADIUS] + limit_m, 0.0)
            if x * x + y * y + z * z > reach * reach:
                continue
            if ball_gap_m(first, i, first[i, RADIUS], second, j) >= limit_m:
                continue
            if ball_gap_m(second, j, second[j, RADIUS], first, i) >= limit_m:
                continue
            if boxes_gap_m(first, i, second, j, limit_m) < limit_m:
                return i * count + j
        begin = 0
    return -1


@compiled
def any_near(first: Array, offset_m: tuple[float, float], second: Array, limit_m: float) -> bool:
    """Whether any of some shapes, moved along x and y by an offset, may come nearer to any of others than a limit."""
    moved = first.copy()
    for row in range(len(moved)):
        moved[row, 0], moved[row, 1] = moved[row, 0] + offset_m[0], moved[row, 1] + offset_m[1]
    cx, cy, cz, radius_m = ball_around(moved)
    near = second[near_ball(second, cx, cy, cz, radius_m)]
    return next_near(moved, near, limit_m, 0) >= 0


@compiled
def surely_overlap(first: Array, i: int, second: Array, j: int, deeper_than_m: float) -> bool:
    """Whether a box, and another shape, overlap deeper than that for sure; False if they do not, or in doubt."""
    if second[j, EXACT] == 1.0:
        return boxes_gap_m(first, i, second, j, np.inf) < -deeper_than_m
    inner_m = second[j, INNER]
    return inner_m > deeper_than_m and ball_gap_m(second, j, inner_m, first, i) < -deeper_than_m


@compiled
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


@compiled
def _along(first: Array, i: int, second: Array, j: int, axis: int) -> float:
    """From the first box's middle to the second's, along one of the first one's axes."""
    gap = 0.0
    for k in range(3):
        gap += first[i, TURNED + 3 * k + axis] * (second[j, k] - first[i, k])
    return gap


@compiled
def _turned(first: Array, i: int, second: Array, j: int, axis: int) -> tuple[float, float, float]:
    """One of the first box's axes along those of the second."""
    x, y, z = first[i, TURNED + axis], first[i, TURNED + 3 + axis], first[i, TURNED + 6 + axis]
    return (
        x * second[j, TURNED] + y * second[j, TURNED + 3] + z * second[j, TURNED + 6],
        x * second[j, TURNED + 1] + y * second[j, TURNED + 4] + z * second[j, TURNED + 7],
        x * second[j, TURNED + 2] + y * second[j, TURNED + 5] + z * second[j, TURNED + 8],
    )
