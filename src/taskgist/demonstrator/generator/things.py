"""Small things of random rooms: what is on tables, in random sizes and colours."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from taskgist.demonstrator.furniture import Thing, box, placed
from taskgist.demonstrator.generator.meshes import extent_m, mesh_text

WALL_M = 0.008
"""Thickness of the walls of boxes, bins and covers."""
COLOURS = (
    "0.78 0.16 0.13 1",
    "0.18 0.32 0.62 1",
    "0.25 0.50 0.30 1",
    "0.12 0.12 0.13 1",
    "0.85 0.68 0.42 1",
    "0.93 0.92 0.89 1",
    "0.92 0.72 0.15 1",
    "0.55 0.30 0.55 1",
    "0.20 0.55 0.60 1",
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

    def mjcf(self) -> str:
        """A free body whose frame is in its middle."""
        deep, wide, tall = self.size_m
        up = -1.0 if self.upside_down else 1.0
        parts = [box((deep, wide, WALL_M), (0, 0, -up * (tall - WALL_M) / 2), self.rgba)]
        for sign in (-1, 1):
            x, y = sign * (deep - WALL_M) / 2, sign * (wide - WALL_M) / 2
            parts.append(box((WALL_M, wide, tall - WALL_M), (x, 0, up * WALL_M / 2), self.rgba))
            parts.append(box((deep - 2 * WALL_M, WALL_M, tall - WALL_M), (0, y, up * WALL_M / 2), self.rgba))
        x, y, z = self.position_m
        place = placed((x, y, z + tall / 2), self.yaw_rad)
        return f'<body name="{self.name}" {place}><freejoint/>{"".join(parts)}</body>'


@dataclass(frozen=True)
class MeshThing(Thing):
    """A thing whose shape is a mesh; its size is that of the cylinder around it.

    Attributes:
        mesh: Name of the mesh.
    """

    mesh: str = ""

    def mjcf(self) -> str:
        """A free body whose frame is in its middle."""
        x, y, z = self.position_m
        place = placed((x, y, z + self.height_m / 2), self.yaw_rad)
        shape = f'<geom name="{self.name}" type="mesh" mesh="{self.mesh}" rgba="{self.rgba}"/>'
        return f'<body name="{self.name}" {place}><freejoint/>{shape}</body>'

    def meshes(self) -> Mapping[str, bytes]:
        """The mesh's file."""
        return {f"{self.mesh}.obj": mesh_text(self.mesh)}


def radius_m(thing: Thing) -> float:
    """Radius of the circle around a thing's outline, seen from above."""
    if len(thing.size_m) == 2:
        return thing.size_m[0] / 2
    return math.hypot(thing.size_m[0], thing.size_m[1]) / 2


Kind = Callable[[np.random.Generator], Thing]


def _box(name: str, low: tuple[float, ...], high: tuple[float, ...]) -> Kind:
    """A kind of things between two sizes."""

    def draw(rng: np.random.Generator) -> Thing:
        size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
        return Thing(name, size, NOWHERE, rgba=str(rng.choice(COLOURS)))

    return draw


def _mesh(name: str) -> Kind:
    """A kind of things of one shape, in any colour."""

    def draw(rng: np.random.Generator) -> Thing:
        size = tuple(round(each, 4) for each in extent_m(name))
        return MeshThing(name, size, NOWHERE, rgba=str(rng.choice(COLOURS)), mesh=name)

    return draw


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
    return OpenBox("bin", size, NOWHERE, rgba=str(rng.choice(COLOURS)))


def cover_for(rng: np.random.Generator, thing: Thing) -> OpenBox:
    """A cover that goes over a thing however it is turned, open below."""
    wide = 2 * (radius_m(thing) + WALL_M + rng.uniform(*COVER_GAP_M))
    tall = thing.height_m + WALL_M + rng.uniform(0.01, 0.06)
    size = (round(wide, 3), round(wide, 3), round(tall, 3))
    return OpenBox("cover", size, NOWHERE, rgba=str(rng.choice(COLOURS)), upside_down=True)


def any_of(rng: np.random.Generator, kinds: Mapping[str, Kind], *, but: frozenset[str] = frozenset()) -> Thing:
    """A thing of any kind."""
    names = [name for name in kinds if name not in but]
    return kinds[str(rng.choice(names))](rng)


def at(thing: Thing, place: np.ndarray, yaw_rad: float) -> Thing:
    """The thing with the middle of its underside at a place (3,)."""
    x, y, z = (round(float(each), 4) for each in place)
    return replace(thing, position_m=(x, y, z), yaw_rad=round(yaw_rad, 4))
