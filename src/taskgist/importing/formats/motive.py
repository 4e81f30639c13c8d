"""CSV of OptiTrack Motive, format versions 1.2 and later (https://docs.optitrack.com, Data Export: CSV).

A line of names and values (Format Version, Take Name, Rotation Type, Length Units, ...), then rows that say of each
column its Type (Marker, Rigid Body, Bone, ...), Name, ID, Parent, whether it is Position or Rotation, and its axis; the
row of axes begins with Frame. Cells are empty where nothing was tracked. Quaternions are x, y, z, w; other rotation
types are Euler angles about moving axes. Motive's world has y up; an export may say otherwise, and no field tells.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.formats.text import begins, cells, number_rows, read_lines, unit_of
from taskgist.importing.mapping import Columns, Rotation
from taskgist.importing.table_values import wxyz_from_numbers
from taskgist.importing.takes import OWNER, Take, TakeTrack

BEGIN = b"Format Version,"
MOST_HEADER_LINES = 12
ORDER = ("Bone", "Rigid Body", "Marker", "Rigid Body Marker", "Bone Marker")
"""Types of columns that are read; where two have a name in common, the one that stands first here has it."""


def is_motive(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return begins(head, BEGIN)


def read_motive(path: Path, where: str, most_bytes: int) -> Take:
    """Bones, rigid bodies and markers of a CSV of Motive.

    Raises:
        MappingError: It cannot be read, is too large, no text, or its rows do not fit its header.
    """
    lines = read_lines(path, where, most_bytes)
    first = cells(lines[0], ",") if lines else []
    about = dict(zip(first[::2], first[1::2], strict=False))
    at, rows = _header(lines, where)
    axes = rows[-1]
    columns = [f"{rows[1][k]} {rows[-2][k]} {axes[k]}".strip() for k in range(len(axes))]
    data = [(number, line) for number, line in enumerate(lines[at + 1 :], start=at + 2) if line.strip(", \t")]
    values = number_rows([(n, _without_timecode(line, axes)) for n, line in data], columns, ",", where)
    groups = _groups(rows)
    tracks: dict[str, TakeTrack] = {}
    things: set[str] = set()
    for kind in ORDER:
        for (type_, name), parts in groups.items():
            if type_ == kind and name not in tracks and (track := _track(values, parts, about, where)) is not None:
                tracks[name] = track
                things |= {name} if kind == "Rigid Body" else set()
    return Take("motive", tracks, frozenset(things), unit=unit_of(about.get("Length Units", "")))


def _header(lines: Sequence[str], where: str) -> tuple[int, list[list[str]]]:
    """Index of the row of axes, and the rows that describe the columns, from Type down to it, equally long."""
    for at, line in enumerate(lines[: MOST_HEADER_LINES + 1]):
        if line.lower().startswith("frame,"):
            axes = cells(line, ",")
            rows = [row for text in lines[1:at] if any(row := cells(text, ","))]
            if len(rows) >= 3:
                return at, [(row + [""] * len(axes))[: len(axes)] for row in rows] + [axes]
    hint = "export it with its header, markers, rigid bodies and bones"
    raise MappingError("has no rows of types, names and axes", where=where, hint=hint)


def _without_timecode(line: str, axes: Sequence[str]) -> str:
    """The row with an empty cell in place of a time code, which is no number."""
    if "TimeCode" not in axes:
        return line
    row = line.split(",")
    row[axes.index("TimeCode")] = ""
    return ",".join(row)


def _groups(rows: Sequence[Sequence[str]]) -> dict[tuple[str, str], dict[str, dict[str, int]]]:
    """Columns by type and name, then by what they are ("Position", "Rotation"), then by axis."""
    types, names, kinds, axes = rows[0], rows[1], rows[-2], rows[-1]
    groups: dict[tuple[str, str], dict[str, dict[str, int]]] = {}
    for column in range(2, len(axes)):
        if axes[column] in ("X", "Y", "Z", "W"):
            key = (types[column], _name(names[column]))
            groups.setdefault(key, {}).setdefault(kinds[column], {}).setdefault(axes[column], column)
    return groups


def _name(name: str) -> str:
    """The bone at the hips has the name of its skeleton in older versions, "Anna:Anna"."""
    owner, _, point = name.partition(OWNER)
    return f"{owner}{OWNER}Hip" if owner and owner == point else name


def _track(
    values: Array, parts: Mapping[str, Mapping[str, int]], about: Mapping[str, str], where: str
) -> TakeTrack | None:
    """A point or body; None for what has no place."""
    place = parts.get("Position", {})
    if not {"X", "Y", "Z"} <= place.keys():
        return None
    position = values[:, [place[axis] for axis in "XYZ"]]
    turn = parts.get("Rotation", {})
    wxyz = _wxyz(values, turn, about.get("Rotation Type", "Quaternion"), where) if turn else None
    return TakeTrack(values[:, 1], position, wxyz)


def _wxyz(values: Array, turn: Mapping[str, int], kind: str, where: str) -> Array:
    """Orientations, NaN where lost."""
    if kind.lower() == "quaternion":
        rotation, letters = Rotation(Columns(()), "xyzw"), "XYZW"
    else:
        letters = kind.upper()
        rotation = Rotation(Columns(()), "euler_intrinsic", letters.lower(), np.pi / 180.0)
    if not set(letters) <= turn.keys() or len(letters) < 3:
        hint = "export rotations as Quaternion"
        raise MappingError("cannot be read", where=where, field="Rotation Type", value=kind, hint=hint)
    wxyz, bad = wxyz_from_numbers(values[:, [turn[letter] for letter in letters]], rotation)
    if bad.any():
        row = int(np.argmax(bad))
        numbers = values[row, [turn[letter] for letter in letters]].tolist()
        hint = "export rotations as Quaternion"
        raise MappingError("is no rotation", where=f"{where}, frame {row}", field=kind, value=numbers, hint=hint)
    return wxyz
