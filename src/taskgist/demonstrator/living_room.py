"""What is in the living room of the study: people at a table, and things on it. Sizes are ours."""

from __future__ import annotations

import math
from collections.abc import Mapping

from taskgist.demonstrator.furniture import OAK, WHITE, Table, Thing
from taskgist.demonstrator.room import Person
from taskgist.world import Posture

TABLE = Table("table")
HIGH_TABLE = Table("table", size_m=(*TABLE.size_m[:2], 0.92))
"""As high as a kitchen's worktop: people stand at it."""
CLOSE_M, BACK_M, STANDING_M = 0.67, 0.93, 0.63
"""Distances of a pelvis from the middle of the table: sitting with the thighs under it, sitting back with the knees
before it (room to stand up), standing at it."""
RED, BLUE, GREEN, BLACK, PINE = (
    "0.78 0.16 0.13 1",
    "0.18 0.32 0.62 1",
    "0.25 0.50 0.30 1",
    "0.12 0.12 0.13 1",
    "0.85 0.68 0.42 1",
)
SIZES_M: Mapping[str, tuple[tuple[float, ...], str]] = {
    "cup": ((0.075, 0.10), RED),
    "wooden_cube": ((0.07, 0.07, 0.07), PINE),
    "white_box": ((0.16, 0.32, 0.26), WHITE),
    "screen": ((0.06, 0.50, 0.40), OAK),
    "book": ((0.15, 0.22, 0.03), BLUE),
    "bottle": ((0.07, 0.24), GREEN),
    "tape": ((0.09, 0.03), BLACK),
}
"""Full sizes (box, or diameter and height) and colours of the things."""


def on_table(name: str, x: float, y: float, yaw_deg: float = 0.0, *, table: Table = TABLE) -> Thing:
    """One of the things, on the table.

    Args:
        name: One of ``SIZES_M``.
        x: Place across the table, metres from its middle.
        y: Place along it.
        yaw_deg: Heading.
        table: The table; its middle is that of the room.
    """
    size, rgba = SIZES_M[name]
    return Thing(name, size, (x, y, table.height_m), math.radians(yaw_deg), rgba)


def left(stature_m: float, away_m: float, y: float = 0.0, *, posture: Posture = "sitting") -> Person:
    """P1, at the left side of the table and facing it, ``away_m`` from its middle."""
    return Person("P1", stature_m, (-away_m, y), 0.0, posture)


def right(
    stature_m: float, away_m: float, y: float = 0.0, *, posture: Posture = "sitting", turned_deg: float = 0.0
) -> Person:
    """P2, at the right side, facing the table or turned from it (positive: to its left)."""
    return Person("P2", stature_m, (away_m, y), math.pi + math.radians(turned_deg), posture)
