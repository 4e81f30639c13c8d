"""Meshes of small things: mugs, bowls, carafes and figures, each a set of convex pieces.

Walls are made of staves, as those of a barrel are. Because each piece is convex and apart from the others, scenes need
no search for convex parts: what collides is exactly what is seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Piece = tuple[Array, Indices]
"""Vertices in metres, (n, 3), and triangles that turn counter-clockwise seen from outside, (m, 3)."""
Ring = tuple[float, float]
"""Radius and height, metres."""

AROUND = 12
"""Staves of a wall, and corners of a disc."""
OVERLAP_M = 2e-4
"""Pieces reach so far into each other: there are no cracks, and no corners in common."""
CORNERS = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)]
    + [(2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)]
)


@cache
def mesh_text(name: str) -> bytes:
    """A mesh as an OBJ document, its middle height in the origin.

    Args:
        name: One of ``SHAPES``.
    """
    lines, count = [], 1
    for vertices, faces in SHAPES[name]:
        lines += [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in vertices]
        lines += [f"f {a} {b} {c}" for a, b, c in faces + count]
        count += len(vertices)
    return ("\n".join(lines) + "\n").encode()


def extent_m(name: str) -> tuple[float, float]:
    """Diameter of the circle around a mesh's axis that it stays in, and its height, metres."""
    vertices = np.concatenate([piece[0] for piece in SHAPES[name]])
    return 2 * float(np.linalg.norm(vertices[:, :2], axis=1).max()), float(np.ptp(vertices[:, 2]))


def disc(lower: Ring, upper: Ring) -> Piece:
    """A convex piece between two rings."""
    angles = 2 * math.pi * np.arange(AROUND) / AROUND
    rings = [np.stack((r * np.cos(angles), r * np.sin(angles), np.full(AROUND, z)), axis=1) for r, z in (lower, upper)]
    vertices = np.concatenate((*rings, [(0, 0, lower[1]), (0, 0, upper[1])]))
    ahead = (np.arange(AROUND) + 1) % AROUND
    own, above, above_ahead = np.arange(AROUND), np.arange(AROUND) + AROUND, ahead + AROUND
    bottom, top = np.full(AROUND, 2 * AROUND), np.full(AROUND, 2 * AROUND + 1)
    faces = [(own, ahead, above_ahead), (own, above_ahead, above), (ahead, own, bottom), (above, above_ahead, top)]
    return vertices, np.concatenate([np.stack(face, axis=1) for face in faces])


def wall(lower: Ring, upper: Ring, thick_m: float) -> Iterable[Piece]:
    """The staves of a wall between two rings, which are its outside."""
    half = math.pi / AROUND + OVERLAP_M / max(lower[0], upper[0])
    for middle in 2 * math.pi * np.arange(AROUND) / AROUND:
        vertices = []
        for inner, turn, is_upper in ((x < 0, y, z > 0) for x, y, z in CORNERS):
            radius, height = upper if is_upper else lower
            radius, height = radius - inner * thick_m, height + (OVERLAP_M if is_upper else -OVERLAP_M)
            vertices.append((radius * math.cos(middle + turn * half), radius * math.sin(middle + turn * half), height))
        yield np.array(vertices), FACES


def board(centre_m: Sequence[float], size_m: Sequence[float]) -> Piece:
    """A box."""
    return CORNERS * np.array(size_m) / 2 + centre_m, FACES


def _mug() -> Iterable[Piece]:
    radius, half, thick = 0.040, 0.046, 0.005
    yield disc((radius - thick, -half), (radius - thick, -half + 0.006))
    yield from wall((radius, -half + OVERLAP_M), (radius, half - OVERLAP_M), thick)
    out, grip = radius + 0.030, 0.010
    yield board((out, 0, 0), (grip, grip, 0.055))
    for z in (-0.024, 0.024):
        yield board((radius + 0.012, 0, z), (0.028, grip - 0.001, grip))


def _bowl() -> Iterable[Piece]:
    thick, low, middle, high = 0.005, -0.034, -0.012, 0.034
    yield disc((0.036, low), (0.036, low + 0.007))
    yield from wall((0.042, low + OVERLAP_M), (0.066, middle), thick)
    yield from wall((0.066, middle), (0.080, high - OVERLAP_M), thick)


def _carafe() -> Iterable[Piece]:
    yield disc((0.042, -0.11), (0.045, 0.0))
    yield disc((0.045, -OVERLAP_M), (0.018, 0.06))
    yield disc((0.0175, 0.06 - OVERLAP_M), (0.020, 0.11))


def _figure() -> Iterable[Piece]:
    yield disc((0.030, -0.07), (0.028, -0.055))
    yield disc((0.024, -0.055 - OVERLAP_M), (0.010, 0.03))
    yield disc((0.009, 0.03 - OVERLAP_M), (0.020, 0.045))
    yield disc((0.0195, 0.045 - OVERLAP_M), (0.010, 0.07))


SHAPES: dict[str, tuple[Piece, ...]] = {
    "mug": tuple(_mug()),
    "bowl": tuple(_bowl()),
    "carafe": tuple(_carafe()),
    "figure": tuple(_figure()),
}
"""The meshes by name."""
