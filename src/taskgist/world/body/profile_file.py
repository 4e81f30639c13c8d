"""Reading agent profiles: each field by name, every problem found."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from taskgist.errors import InputError
from taskgist.world.body.hands import parse_hand
from taskgist.world.body.profile import AgentProfile
from taskgist.world.body.profile_fields import (
    check_sides,
    read_arm,
    read_axis,
    read_eye,
    read_legs,
    read_parts,
    read_rest_m,
    read_rest_rad,
    read_shapes,
)
from taskgist.world.toml_table import TomlTable

TABLES = {"name", "model", "shapes", "eye", "head", "torso", "posture", "base", "arms", "hand", "parts"}
RESTS = {"rest_deg", "rest_m"}


def parse_profile(text: bytes | str, *, where: str | Path, stature_m: float | None = None) -> AgentProfile:
    """Read a profile.

    Args:
        text: The TOML document.
        where: File name for error messages.
        stature_m: Stature of the body, for lengths given as a share of it.

    Raises:
        SceneError: A field is missing or has a value that cannot be.
        UnknownNameError: There is no such field.
    """
    profile, problems = examine_profile(text, where=where, stature_m=stature_m)
    if profile is None:
        raise problems[0]
    return profile


def examine_profile(
    text: bytes | str, *, where: str | Path, stature_m: float | None = None
) -> tuple[AgentProfile | None, tuple[InputError, ...]]:
    """As ``parse_profile``, with every problem instead of the first one; None beside problems."""
    problems: list[InputError] = []
    try:
        table = TomlTable.parse(text, where).only(TABLES | RESTS)
    except InputError as error:
        return None, (error,)

    def attempt(read: Callable[[], Any]) -> Any:
        try:
            return read()
        except InputError as error:
            problems.append(error)

    fields = {name: attempt(partial(read, table)) for name, read in READERS.items()}
    entries = attempt(partial(table.tables, "arms")) or ()
    arms = tuple(attempt(partial(read_arm, entry, stature_m)) for entry in entries)
    attempt(partial(check_sides, table, arms))
    return (None, tuple(problems)) if problems else (AgentProfile(**fields, arms=arms), ())


READERS: dict[str, Callable[[TomlTable], Any]] = {
    "name": lambda table: table.text("name"),
    "model": lambda table: table.text("model"),
    "shapes": read_shapes,
    "eye": lambda table: read_eye(table.table("eye")),
    "pan": lambda table: read_axis(table.table("head").only({"pan", "tilt"}), "pan"),
    "tilt": lambda table: read_axis(table.table("head"), "tilt"),
    "turn": lambda table: read_axis(table.table("torso").only({"turn", "lean"}), "turn"),
    "lean": lambda table: read_axis(table.table("torso"), "lean"),
    "legs": lambda table: read_legs(table.table("posture")),
    "moves": lambda table: table.table("base").only({"moves"}).flag("moves", default=False),
    "hand": lambda table: parse_hand(table.table("hand")) if "hand" in table else None,
    "parts": read_parts,
    "rest_rad": read_rest_rad,
    "rest_m": read_rest_m,
}
"""How each field of a profile is read from its document; arms apart."""
