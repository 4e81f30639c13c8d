"""Reading agent profiles: each field by name, every problem found."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from taskgist.errors import InputError
from taskgist.world.body.attempts import UNREADABLE, Attempts
from taskgist.world.body.frames import Frame
from taskgist.world.body.hands import parse_hand
from taskgist.world.body.profile import AgentProfile, Axis, Eye, Legs
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
    if problems:
        raise problems[0]
    assert profile is not None
    return profile


def examine_profile(
    text: bytes | str, *, where: str | Path, stature_m: float | None = None
) -> tuple[AgentProfile | None, tuple[InputError, ...]]:
    """As ``parse_profile``, with every problem instead of the first one.

    Beside problems, what could not be read is left open in the profile: names are ``UNREADABLE``. None if nothing can
    be read at all.
    """
    attempt = Attempts()
    try:
        table = TomlTable.parse(text, where)
    except InputError as error:
        return None, (error,)
    attempt(lambda: table.only(TABLES | RESTS), table)
    eye = attempt(lambda: read_eye(table.table("eye"), attempt), NO_EYE)
    fields = {name: attempt(partial(read, table), otherwise) for name, (read, otherwise) in READERS.items()}
    axes: dict[str, Any] = {key: _axis(table, part, key, attempt) for part, keys in AXES.items() for key in keys}
    no_arms: tuple[TomlTable, ...] = ()
    entries = attempt(lambda: table.tables("arms"), no_arms)
    arms = tuple(read_arm(entry, stature_m, attempt) for entry in entries)
    attempt(lambda: check_sides(table, arms), None)
    return AgentProfile(eye=eye, arms=arms, **axes, **fields), tuple(attempt.problems)


def _axis(table: TomlTable, part: str, key: str, attempt: Attempts) -> Axis | None:
    """A joint of head or torso; fields that neither has are told of once."""

    def read() -> Axis | None:
        joints = table.table(part)
        if key == AXES[part][0]:
            attempt(lambda: joints.only(AXES[part]), joints)
        return read_axis(joints, key, attempt)

    return attempt(read, None)


AXES = {"head": ("pan", "tilt"), "torso": ("turn", "lean")}
NO_EYE = Eye(Frame(UNREADABLE), UNREADABLE, (), (1.0, 1.0), (1, 1), 1.0)

READERS: dict[str, tuple[Callable[[TomlTable], Any], Any]] = {
    "name": (lambda table: table.text("name"), UNREADABLE),
    "model": (lambda table: table.text("model"), UNREADABLE),
    "shapes": (read_shapes, "visual"),
    "legs": (lambda table: read_legs(table.table("posture")), Legs()),
    "moves": (lambda table: table.table("base").only({"moves"}).flag("moves", default=False), False),
    "hand": (lambda table: parse_hand(table.table("hand")) if "hand" in table else None, None),
    "parts": (read_parts, ()),
    "rest_rad": (read_rest_rad, ()),
    "rest_m": (read_rest_m, ()),
}
"""How the fields of a profile are read from its document, and what stands in for one that cannot be; more apart."""
