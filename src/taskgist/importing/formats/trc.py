"""TRC, "track row column": text of Motion Analysis, OpenSim, OpenCap and Pose2Sim.

See https://opensimconfluence.atlassian.net, Marker (.trc) Files. Two rows of names and values (DataRate, Units, ...), a
row that begins with Frame# and names each marker over its three columns, a row X1 Y1 Z1 ..., then a row for each frame.
OpenSim's convention is y up; others write z up, and no field says which.
"""

from __future__ import annotations

from pathlib import Path

from taskgist.errors import MappingError
from taskgist.importing.formats.text import begins, cells, header_number, number_rows, read_lines, unit_of
from taskgist.importing.takes import Take, TakeTrack

BEGIN = b"PathFileType"


def is_trc(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return begins(head, BEGIN)


def read_trc(path: Path, where: str, most_bytes: int) -> Take:
    """The markers of a TRC file.

    Raises:
        MappingError: It cannot be read, is too large, no text, or its rows do not fit its header.
    """
    lines = read_lines(path, where, most_bytes)
    if len(lines) < 5 or not lines[0].startswith(BEGIN.decode()):
        hint = "a TRC of motion capture begins with PathFileType: export it again"
        raise MappingError("is no TRC file of markers", where=where, hint=hint)
    about = dict(zip(cells(lines[1], "\t"), cells(lines[2], "\t"), strict=False))
    names = [name for name in cells(lines[3], "\t")[2:] if name]
    if not names:
        raise MappingError("names no markers", where=f"{where}, line 4", hint="names stand beside Frame# and Time")
    columns = ["Frame#", "Time", *(f"{name} {axis}" for name in names for axis in "XYZ")]
    rows = [(number, line) for number, line in enumerate(lines[5:], start=6) if line.strip()]
    values = number_rows(rows, columns, "\t", where, whole=3)
    times_s = values[:, 1]
    if not (times_s[1:] > times_s[:-1]).all():
        times_s = (values[:, 0] - 1.0) / header_number(about.get("DataRate", ""), f"{where}, line 3", "DataRate")
    tracks = {name: TakeTrack(times_s, values[:, 2 + 3 * k : 5 + 3 * k]) for k, name in enumerate(names)}
    if len(tracks) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise MappingError("two markers have one name", where=f"{where}, line 4", value=twice, hint="rename one")
    return Take("trc", tracks, unit=unit_of(about.get("Units", "")))
