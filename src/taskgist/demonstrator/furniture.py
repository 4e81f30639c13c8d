"""Furniture and small things of a room, as MJCF text."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

OAK, WHITE, GREY = "0.62 0.45 0.28 1", "0.93 0.92 0.89 1", "0.45 0.47 0.50 1"
SEAT_M = 0.45
"""Height of a chair's seat."""
CHAIR_M = (0.42, 0.42, 0.04)
"""Depth and width of the seat, and the thickness of its boards."""
BACK_M = 0.45
"""Height of a chair's back above its seat."""
LEG_M = 0.05
"""Thickness of the legs of tables and chairs."""


@dataclass(frozen=True)
class Thing:
    """A small object that can be moved.

    Attributes:
        name: Its name.
        size_m: Full size of a box (x, y, z), or diameter and height of a cylinder.
        position_m: Where the middle of its underside is, (3,).
        yaw_rad: Heading.
        rgba: Colour as MJCF text.
    """

    name: str
    size_m: tuple[float, ...]
    position_m: tuple[float, float, float]
    yaw_rad: float = 0.0
    rgba: str = OAK

    @property
    def height_m(self) -> float:
        """Height."""
        return self.size_m[-1]

    def mjcf(self) -> str:
        """A free body whose frame is in its middle."""
        x, y, z = self.position_m
        is_box = len(self.size_m) == 3
        size = [s / 2 for s in self.size_m]
        kind = "box" if is_box else "cylinder"
        shape = f'<geom name="{self.name}" type="{kind}" size="{text(size)}" rgba="{self.rgba}"/>'
        place = placed((x, y, z + self.height_m / 2), self.yaw_rad)
        return f'<body name="{self.name}" {place}><freejoint/>{shape}</body>'

    def meshes(self) -> Mapping[str, bytes]:
        """The files of its meshes by name; none."""
        return {}


@dataclass(frozen=True)
class Table:
    """A table with four legs; also any other board on legs.

    Attributes:
        name: Its name.
        centre_m: Floor point beneath its middle, (2,).
        size_m: Full size (x, y) of its top, and the height of its upper face.
        yaw_rad: Heading.
        board_m: Thickness of its top.
    """

    name: str
    centre_m: tuple[float, float] = (0.0, 0.0)
    size_m: tuple[float, float, float] = (0.70, 1.40, 0.72)
    yaw_rad: float = 0.0
    board_m: float = 0.03

    @property
    def height_m(self) -> float:
        """Height of its upper face."""
        return self.size_m[2]

    def mjcf(self) -> str:
        """A fixed body whose frame is on the floor."""
        depth, width, height = self.size_m
        board = box((depth, width, self.board_m), (0, 0, height - self.board_m / 2), OAK)
        legs = _legs(depth, width, height - self.board_m)
        return fixed(self.name, (*self.centre_m, 0.0), self.yaw_rad, (board, *legs))


def chair(name: str, centre_m: tuple[float, float], yaw_rad: float) -> str:
    """A chair that faces ``yaw_rad``, with its seat over a floor point."""
    depth, width, board = CHAIR_M
    seat = box((depth, width, board), (0, 0, SEAT_M - board / 2), GREY)
    back = box((board, width, BACK_M), (-(depth + board) / 2, 0, SEAT_M + BACK_M / 2), GREY)
    return fixed(name, (*centre_m, 0.0), yaw_rad, (seat, back, *_legs(depth, width, SEAT_M - board)))


def sideboard(name: str, centre_m: tuple[float, float], yaw_rad: float) -> str:
    """A closed cupboard at the wall."""
    return fixed(name, (*centre_m, 0.0), yaw_rad, (box((0.40, 1.60, 0.80), (0, 0, 0.40), WHITE),))


def _legs(depth_m: float, width_m: float, height_m: float) -> Iterable[str]:
    for x in (-1, 1):
        for y in (-1, 1):
            place = (x * (depth_m - LEG_M) / 2, y * (width_m - LEG_M) / 2, height_m / 2)
            yield box((LEG_M, LEG_M, height_m), place, GREY)


def fixed(name: str, place_m: tuple[float, float, float], yaw_rad: float, parts: Iterable[str]) -> str:
    """A body that does not move, of some parts."""
    return f'<body name="{name}" {placed(place_m, yaw_rad)}>{"".join(parts)}</body>'


def placed(position_m: Iterable[float], yaw_rad: float) -> str:
    """Attributes that say where something is, and how it is turned about the vertical."""
    quaternion = (math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2))
    return f'pos="{text(position_m)}" quat="{text(quaternion)}"'


def box(size_m: tuple[float, float, float], centre_m: tuple[float, float, float], rgba: str) -> str:
    """A part: a box of full size (x, y, z)."""
    half = text(s / 2 for s in size_m)
    return f'<geom type="box" size="{half}" pos="{text(centre_m)}" rgba="{rgba}"/>'


def cylinder(radius_m: float, height_m: float, centre_m: tuple[float, float, float], rgba: str) -> str:
    """A part: an upright cylinder."""
    size = text((radius_m, height_m / 2))
    return f'<geom type="cylinder" size="{size}" pos="{text(centre_m)}" rgba="{rgba}"/>'


def text(values: Iterable[float]) -> str:
    """Numbers as MJCF text."""
    return " ".join(f"{value:.6g}" for value in values)
