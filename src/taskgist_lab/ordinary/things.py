"""Small things of ordinary rooms, by what people call them, and how an adult takes each."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from taskgist_lab.simulator.room import BLACK, BLUE, GREEN, GREY, PINE, RED, WHITE, Colour, Thing


@dataclass(frozen=True)
class Kind:
    """A kind of thing: its full size (box, or diameter and height of a cylinder), its colour, and how it is taken."""

    size_m: tuple[float, ...]
    rgba: Colour
    taken: str = "one hand"

    @property
    def radius_m(self) -> float:
        """Of the circle around its middle that it stays in."""
        return math.hypot(*self.size_m[:2]) / 2 if len(self.size_m) == 3 else self.size_m[0] / 2

    @property
    def height_m(self) -> float:
        """Height."""
        return self.size_m[-1]


FLAT, TWO_HANDS = "flat", "two hands"
KINDS: Mapping[str, Kind] = {
    "cup": Kind((0.075, 0.10), RED),
    "glass": Kind((0.065, 0.13), GREY),
    "bottle": Kind((0.07, 0.24), GREEN),
    "tin": Kind((0.085, 0.08), GREY),
    "apple": Kind((0.075, 0.07), RED),
    "packet": Kind((0.06, 0.09, 0.15), PINE),
    "book": Kind((0.15, 0.22, 0.03), BLUE, FLAT),
    "phone": Kind((0.075, 0.15, 0.008), BLACK, FLAT),
    "plate": Kind((0.24, 0.02), WHITE, FLAT),
    "pen": Kind((0.01, 0.14, 0.01), BLUE, FLAT),
    "keys": Kind((0.03, 0.06, 0.008), GREY, FLAT),
    "carton": Kind((0.24, 0.30, 0.20), PINE, TWO_HANDS),
    "pot": Kind((0.22, 0.14), GREY, TWO_HANDS),
}
"""Kinds by name. Sizes are ours, of things at hand."""


def thing_of(kind: str, name: str, position_m: tuple[float, float, float], yaw_rad: float = 0.0) -> Thing:
    """A thing of a kind; its place is that of the middle of its underside."""
    chosen = KINDS[kind]
    return Thing(name, chosen.size_m, position_m, yaw_rad, chosen.rgba)
