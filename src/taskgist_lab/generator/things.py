"""Small things of random rooms: what is on tables, in random sizes and colours, and the meshes of some."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

import mujoco
import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist_lab.simulator.room import BLACK, BLUE, GREEN, PINE, RED, WHITE, Colour, Thing, add_box

# --- Meshes of small things: mugs, bowls, carafes and figures, each a set of convex pieces.
#
# Walls are made of staves, as those of a barrel are. Because each piece is convex and apart from the others, scenes
# need no search for convex parts: what collides is exactly what is seen.

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

WALL_M = 0.008
"""Thickness of the walls of boxes, bins and covers."""
COLOURS: tuple[Colour, ...] = (
    RED,
    BLUE,
    GREEN,
    BLACK,
    PINE,
    WHITE,
    (0.92, 0.72, 0.15, 1.0),
    (0.55, 0.30, 0.55, 1.0),
    (0.20, 0.55, 0.60, 1.0),
)
NOWHERE = (0.0, 0.0, 0.0)
"""Where a thing is before it has been put somewhere."""


@dataclass(frozen=True)
class OpenBox(Thing):
    """A box with thin walls and one open side: a bin that opens upwards, or a cover that opens downwards.

    Its size is the outer one.

    Attributes:
        upside_down: Whether it opens downwards.
    """

    upside_down: bool = False

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        """Give its body its shapes."""
        deep, wide, tall = self.size_m
        up = -1.0 if self.upside_down else 1.0
        add_box(body, (deep, wide, WALL_M), (0, 0, -up * (tall - WALL_M) / 2), self.rgba)
        for sign in (-1, 1):
            x, y = sign * (deep - WALL_M) / 2, sign * (wide - WALL_M) / 2
            add_box(body, (WALL_M, wide, tall - WALL_M), (x, 0, up * WALL_M / 2), self.rgba)
            add_box(body, (deep - 2 * WALL_M, WALL_M, tall - WALL_M), (0, y, up * WALL_M / 2), self.rgba)


@dataclass(frozen=True)
class MeshThing(Thing):
    """A thing whose shape is a mesh; its size is that of the cylinder around it.

    Attributes:
        mesh: Name of the mesh.
    """

    mesh: str = ""

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        """Give its body its shape."""
        body.add_geom(name=self.name, type=mujoco.mjtGeom.mjGEOM_MESH, meshname=self.mesh, rgba=self.rgba)

    def meshes(self) -> Mapping[str, bytes]:
        """The mesh's file."""
        return {f"{self.mesh}.obj": mesh_text(self.mesh)}


def any_colour(rng: np.random.Generator) -> Colour:
    """One of ``COLOURS``."""
    return COLOURS[int(rng.choice(len(COLOURS)))]


def radius_m(thing: Thing) -> float:
    """Radius of the circle around a thing's outline, seen from above."""
    if len(thing.size_m) == 2:
        return thing.size_m[0] / 2
    return math.hypot(thing.size_m[0], thing.size_m[1]) / 2


Kind = Callable[[np.random.Generator], Thing]


def _box(name: str, low: tuple[float, ...], high: tuple[float, ...]) -> Kind:
    """A kind of things between two sizes."""

    def chosen(rng: np.random.Generator) -> Thing:
        size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
        return Thing(name, size, NOWHERE, rgba=any_colour(rng))

    return chosen


def _mesh(name: str) -> Kind:
    """A kind of things of one shape, in any colour."""

    def chosen(rng: np.random.Generator) -> Thing:
        size = tuple(round(each, 4) for each in extent_m(name))
        return MeshThing(name, size, NOWHERE, rgba=any_colour(rng), mesh=name)

    return chosen


SMALL: Mapping[str, Kind] = {
    "cube": _box("cube", (0.05, 0.05, 0.05), (0.08, 0.08, 0.08)),
    "packet": _box("packet", (0.04, 0.06, 0.09), (0.06, 0.09, 0.15)),
    "tin": _box("tin", (0.06, 0.07), (0.08, 0.12)),
    "bottle": _box("bottle", (0.055, 0.16), (0.075, 0.25)),
    "tape": _box("tape", (0.08, 0.025), (0.10, 0.05)),
    "mug": _mesh("mug"),
    "carafe": _mesh("carafe"),
    "figure": _mesh("figure"),
}
"""What one hand takes and carries."""
TALL = frozenset({"bottle", "carafe", "figure"})
"""Kinds of them that stick out of bins and over what they are hidden behind."""
LARGE: Mapping[str, Kind] = {
    "book": _box("book", (0.13, 0.19, 0.015), (0.18, 0.25, 0.04)),
    "box": _box("box", (0.10, 0.14, 0.08), (0.18, 0.26, 0.20)),
    "bowl": _mesh("bowl"),
}
"""What stands about."""
OCCLUDERS: Mapping[str, Kind] = {
    "box": _box("box", (0.08, 0.22, 0.24), (0.15, 0.36, 0.36)),
    "screen": _box("screen", (0.03, 0.34, 0.26), (0.06, 0.50, 0.40)),
    "crate": _box("crate", (0.16, 0.24, 0.22), (0.22, 0.34, 0.32)),
}
"""What something can be hidden behind."""

PEDESTALS: Mapping[str, Kind] = {
    "box": _box("box", (0.12, 0.18, 0.14), (0.18, 0.30, 0.28)),
    "stand": _box("stand", (0.14, 0.12), (0.20, 0.24)),
}
"""What something can be put on top of."""
PICTURES: Mapping[str, Kind] = {
    "picture": _box("picture", (0.010, 0.15, 0.18), (0.016, 0.21, 0.26)),
    "book": _box("book", (0.014, 0.15, 0.20), (0.022, 0.18, 0.25)),
}
"""What stands upright and has a face, which looks along its x axis."""
CARTONS: Mapping[str, Kind] = {
    "carton": _box("carton", (0.05, 0.16, 0.22), (0.09, 0.22, 0.30)),
    "folder": _box("folder", (0.04, 0.24, 0.26), (0.08, 0.28, 0.33)),
}
"""What hides small things, and can be carried by one hand at its narrow side."""

COVERABLE: Mapping[str, Kind] = {
    "cube": _box("cube", (0.04, 0.04, 0.04), (0.06, 0.06, 0.06)),
    "tin": _box("tin", (0.05, 0.04), (0.08, 0.09)),
    "tape": _box("tape", (0.07, 0.025), (0.09, 0.05)),
}
"""What a cover of a hand's breadth goes over."""
BIN_M = ((0.18, 0.18, 0.19), (0.25, 0.25, 0.29))
"""Least and largest size of bins and boxes that things are put into."""
COVER_GAP_M = (0.006, 0.015)
"""Gap between a thing and the walls of a cover over it."""


def bin_of(rng: np.random.Generator) -> OpenBox:
    """A bin, open above."""
    size = tuple(round(float(each), 3) for each in rng.uniform(*BIN_M))
    return OpenBox("bin", size, NOWHERE, rgba=any_colour(rng))


def cover_for(rng: np.random.Generator, thing: Thing) -> OpenBox:
    """A cover that goes over a thing however it is turned, open below."""
    wide = 2 * (radius_m(thing) + WALL_M + rng.uniform(*COVER_GAP_M))
    tall = thing.height_m + WALL_M + rng.uniform(0.01, 0.06)
    size = (round(wide, 3), round(wide, 3), round(tall, 3))
    return OpenBox("cover", size, NOWHERE, rgba=any_colour(rng), upside_down=True)


def any_of(rng: np.random.Generator, kinds: Mapping[str, Kind], *, but: frozenset[str] = frozenset()) -> Thing:
    """A thing of any kind."""
    names = [name for name in kinds if name not in but]
    return kinds[str(rng.choice(names))](rng)


def at(thing: Thing, place: np.ndarray, yaw_rad: float) -> Thing:
    """The thing with the middle of its underside at a place (3,)."""
    x, y, z = (round(float(each), 4) for each in place)
    return replace(thing, position_m=(x, y, z), yaw_rad=round(yaw_rad, 4))
