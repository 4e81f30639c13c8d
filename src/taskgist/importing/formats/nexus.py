"""CSV of Vicon Nexus and Tracker: sections, each with a rate, rows of names, axes and units, and a row for each frame.

    Trajectories
    100
    ,,Anna:LASI,,,Anna:RASI,,
    Frame,Sub Frame,X,Y,Z,X,Y,Z
    ,,mm,mm,mm,mm,mm,mm
    1,0,612.1,...

An empty line ends a section (Vicon Nexus User Guide, Export ASCII). Of the section *Model Outputs* what has a place is
read, in millimetres; angles, forces and moments are not, nor are *Devices*. *Objects* of Tracker have RX ... TZ: with
RW the rotation is a quaternion; without it nothing says which kind of angles they are, and only places are read. A
segment that is called as its subject, "cup:cup", is a thing. Vicon's world has z up.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.formats.text import cells, header_number, number_rows, read_lines, unit_of
from taskgist.importing.mapping import Columns, Rotation
from taskgist.importing.table_values import wxyz_from_numbers
from taskgist.importing.takes import OWNER, Take, TakeTrack

HEADER = re.compile(
    rb"(?:\xef\xbb\xbf)?[^\n]{3,60}\r?\n\s*\d[\d.]*[,\t]*\r?\n[^\n]*\r?\n\s*\"?Frame\"?\s*[,\t]\s*\"?Sub Frame",
    re.IGNORECASE,
)
"""How such a file begins: title, rate, names, axes."""
PLACES = (("X", "Y", "Z"), ("TX", "TY", "TZ"))


def is_nexus(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return HEADER.match(head) is not None


@dataclass(frozen=True)
class _Section:
    """A section, its lines with their numbers in the file."""

    title: str
    lines: Sequence[tuple[int, str]]


def read_nexus(path: Path, where: str, most_bytes: int) -> Take:
    """Trajectories, modelled points and objects of a CSV of Vicon.

    Raises:
        MappingError: It cannot be read, is too large, no text, or a section's rows do not fit its header.
    """
    lines = read_lines(path, where, most_bytes)
    tracks: dict[str, TakeTrack] = {}
    things: set[str] = set()
    units: set[str] = set()
    notes: list[str] = []
    for section in _sections(lines):
        if len(section.lines) < 4 or section.title == "Devices":
            continue
        found, unit, note = _tracks(section, where)
        tracks |= {name: track for name, track in found.items() if name not in tracks}
        whole = section.title == "Objects"
        things |= {name for name in found if whole or (section.title == "Segments" and OWNER not in name)}
        units |= unit
        notes += note
    if not tracks:
        hint = "export trajectories, model outputs or objects"
        raise MappingError("has no section with places", where=where, hint=hint)
    return Take("nexus", tracks, frozenset(things), units.pop() if len(units) == 1 else None, "z", tuple(notes))


def _sections(lines: Sequence[str]) -> Iterator[_Section]:
    title, found = "", list[tuple[int, str]]()
    for number, line in enumerate(lines, start=1):
        blank = not line.strip(", \t;")
        if blank and title and len(found) < 2:
            continue  # the row of names of a section without names
        if blank:
            if title:
                yield _Section(title, found)
            title, found = "", []
        elif not title:
            title = cells(line, "\t" if "\t" in line else ",")[0]
        else:
            found.append((number, line))
    if title:
        yield _Section(title, found)


def _tracks(section: _Section, where: str) -> tuple[dict[str, TakeTrack], set[str], list[str]]:
    """What has a place in a section, the units of places, and what a user should know."""
    (at, rate), (_, names), (_, axes), (_, units) = section.lines[:4]
    delimiter = "\t" if "\t" in axes else ","
    axis_row = cells(axes, delimiter)
    width = len(axis_row)
    name_row = _carried((cells(names, delimiter) + [""] * width)[:width])
    unit_row = (cells(units, delimiter) + [""] * width)[:width]
    columns = [f"{name} {axis}".strip() for name, axis in zip(name_row, axis_row, strict=True)]
    values = number_rows(section.lines[4:], columns, delimiter, where, whole=3)
    rate_hz = header_number(rate.strip(", \t"), f"{where}, line {at}", "rate")
    tracks: dict[str, TakeTrack] = {}
    seen: set[str] = set()
    unturned: list[str] = []
    for name in dict.fromkeys(name for name in name_row if name):
        of = {axis_row[k].upper(): k for k in range(width) if name_row[k] == name}
        place = next((three for three in PLACES if set(three) <= of.keys()), None)
        unit = {unit_of(unit_row[of[axis]]) for axis in place} if place else {None}
        if place is None or None in unit:
            continue
        seen |= {known for known in unit if known}
        wxyz = _wxyz(values, [of[axis] for axis in ("RX", "RY", "RZ", "RW")]) if "RW" in of else None
        unturned += [name] if "RX" in of and "RW" not in of else []
        times_s = (values[:, 0] - 1.0) / rate_hz
        tracks[_plain(name)] = TakeTrack(times_s, values[:, [of[axis] for axis in place]], wxyz)
    note = [f"rotations of {', '.join(unturned)} are not read: export them as quaternions (RX, RY, RZ, RW)"]
    return tracks, seen, note if unturned else []


def _carried(row: Sequence[str]) -> list[str]:
    """Each column's name: that of the last cell that is not empty, but for the two columns of frames."""
    names, last = ["", ""], ""
    for cell in row[2:]:
        last = cell or last
        names.append(last)
    return names[: len(row)]


def _plain(name: str) -> str:
    """A name without what Tracker writes before it, and without its second half where that repeats the first."""
    text = name.removeprefix("Global Angle").strip()
    owner, _, point = text.partition(":")
    return owner if owner == point else text


def _wxyz(values: Array, columns: Sequence[int]) -> Array:
    wxyz, bad = wxyz_from_numbers(values[:, list(columns)], Rotation(Columns(()), "xyzw"))
    wxyz[bad] = np.nan
    return wxyz
