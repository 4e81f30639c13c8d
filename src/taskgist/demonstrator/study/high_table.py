"""A high table, at which people stand."""

from __future__ import annotations

from dataclasses import replace

from taskgist.demonstrator.furniture import Table, Thing
from taskgist.demonstrator.living_room import TABLE, on_table

HIGH_TABLE = Table("table", size_m=(*TABLE.size_m[:2], 0.92))
"""As high as a kitchen's worktop."""


def on_high_table(name: str, x: float, y: float, yaw_deg: float = 0.0) -> Thing:
    """One of the living room's things, on the high table; see ``living_room.on_table``."""
    return replace(on_table(name, x, y, yaw_deg), position_m=(x, y, HIGH_TABLE.height_m))
