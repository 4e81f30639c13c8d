"""TSV of Qualisys Track Manager, 3D and 6D (https://docs.qualisys.com/qtm, Motion data (.tsv) and 6DOF data).

Lines of a name, a tabulator and values (NO_OF_FRAMES, FREQUENCY, DATA_INCLUDED, MARKER_NAMES or BODY_NAMES, ...), maybe
a row of column names that begins with Frame, then a row for each frame. 6D has 16 columns for each body: X, Y, Z, three
angles, a residual, and the rotation matrix by *columns*. Lengths are millimetres, z is up unless the project says
otherwise; what was lost is empty or all zeros.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.formats.text import begins, cells, header_number, number_rows, read_lines
from taskgist.importing.mapping import Columns, Rotation
from taskgist.importing.table_values import wxyz_from_numbers
from taskgist.importing.takes import Take, TakeTrack

KEYS = (b"FILE_VERSION\t", b"NO_OF_FRAMES\t")
NAMES = {"3D": "MARKER_NAMES", "6D": "BODY_NAMES"}
WIDTH = {"3D": 3, "6D": 16}
MATRIX = slice(7, 16)


def is_qualisys(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return begins(head, KEYS)


def read_qualisys(path: Path, where: str, most_bytes: int) -> Take:
    """Markers or bodies of a TSV of Qualisys.

    Raises:
        MappingError: It cannot be read, is too large, no text, holds 2D data, or its rows do not fit its header.
    """
    lines = read_lines(path, where, most_bytes)
    at, about = _header(lines)
    kind = about.get("DATA_INCLUDED", [""])[0].strip()
    if kind not in NAMES:
        hint = "export 3D data or 6D data, with the header"
        raise MappingError("holds no places", where=where, field="DATA_INCLUDED", value=kind, hint=hint)
    names = [name for name in about.get(NAMES[kind], []) if name]
    if not names:
        raise MappingError("names nothing", where=where, field=NAMES[kind], hint="export it with the header")
    rate_hz = header_number(about.get("FREQUENCY", [""])[0], where, "FREQUENCY")
    rows = [(number, line) for number, line in enumerate(lines[at:], start=at + 1) if line.strip()]
    counted = bool(rows) and rows[0][1].lower().startswith("frame")
    columns = ["Frame", "Time"] if counted else []
    columns += [f"{name} {k}" for name in names for k in range(WIDTH[kind])]
    values = number_rows(rows[1:] if counted else rows, columns, "\t", where, whole=WIDTH[kind])
    times_s = values[:, 1] if counted else np.arange(len(values)) / rate_hz
    blocks = values[:, 2 if counted else 0 :].reshape(len(values), len(names), WIDTH[kind])
    tracks = {name: _track(times_s, blocks[:, k], kind) for k, name in enumerate(names)}
    if len(tracks) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise MappingError("two have one name", where=where, field=NAMES[kind], value=twice, hint="rename one")
    return Take("qualisys", tracks, frozenset(names if kind == "6D" else ()), "mm", "z")


def _header(lines: Sequence[str]) -> tuple[int, Mapping[str, list[str]]]:
    """Index of the first line below the header, and its values by name."""
    about: dict[str, list[str]] = {}
    for at, line in enumerate(lines):
        row = cells(line, "\t")
        if line.strip() and not (row[0].replace("_", "").isupper() and len(row) > 1):
            return at, about
        about.setdefault(row[0], row[1:])
    return len(lines), about


def _track(times_s: Array, block: Array, kind: str) -> TakeTrack:
    """A marker or body, (rows, columns), NaN where lost."""
    position = block[:, :3].copy()
    lost = (block == 0.0).all(axis=1)
    position[lost] = np.nan
    if kind == "3D":
        return TakeTrack(times_s, position)
    by_row = block[:, MATRIX].reshape(-1, 3, 3).transpose(0, 2, 1).reshape(-1, 9)
    by_row = np.where((lost | (by_row == 0.0).all(axis=1))[:, None], np.nan, by_row)
    wxyz, bad = wxyz_from_numbers(by_row, Rotation(Columns(()), "matrix"))
    wxyz[bad] = np.nan
    return TakeTrack(times_s, position, wxyz)
