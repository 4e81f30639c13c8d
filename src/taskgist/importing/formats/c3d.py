"""C3D: the binary format of Vicon, Qualisys, OptiTrack, BTS and others (https://www.c3d.org, C3D User Guide).

A header block tells where parameters and data begin; parameters are records in groups (POINT:LABELS, POINT:UNITS);
data are frames of points, x, y, z and a word that is negative where the point was lost, and of analog channels, which
are not read. Numbers are those of Intel, DEC or MIPS processors.

Read by our own code: ezc3d, with which the tests compare it, runs for ever on some files that are cut off or damaged.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.files import read_whole
from taskgist.errors import MappingError
from taskgist.importing.formats.text import unit_of
from taskgist.importing.takes import Take, TakeTrack

BLOCK = 512
MARK = 0x50
"""Second byte of every C3D file."""
INTEL, DEC, MIPS = 84, 85, 86
LONGEST = 0xFFFF
"""Frames that the header can count; files with more say so in parameters."""
MODELLED = ("ANGLES", "FORCES", "MOMENTS", "POWERS", "SCALARS", "REACTIONS")
"""Parameters of POINT that name those of its labels that are no places (Vicon's model outputs)."""
AXES = ("x", "y", "z")

Parameters = Mapping[str, Any]


def is_c3d(head: bytes) -> bool:
    """Whether a file that begins so is one."""
    return len(head) > 1 and head[1] == MARK and 2 <= head[0] < MARK


def read_c3d(path: Path, where: str, most_bytes: int) -> Take:
    """The points of a C3D file.

    Raises:
        MappingError: It cannot be read, is too large, damaged or cut off, or holds no points.
    """
    content = read_whole(path, most_bytes=most_bytes, setting="table_bytes", error=MappingError)
    if not is_c3d(content[:2]) or len(content) < 2 * BLOCK:
        raise _damaged(where, "is no C3D file")
    start = BLOCK * (content[0] - 1)
    if start + 4 > len(content) or content[start + 3] not in (INTEL, DEC, MIPS):
        raise _damaged(where, "the kind of processor is not known")
    numbers = _Numbers(content[start + 3])
    try:
        parameters = dict(_parameters(content, start + 4, numbers))
        header = _header(content, numbers, parameters, where)
    except (struct.error, IndexError, ValueError) as problem:
        raise _damaged(where, "the parameters cannot be read") from problem
    position = _points(content, header, numbers, where)
    times_s = (header.first - 1 + np.arange(len(position))) / header.rate_hz
    dropped = {label for key in MODELLED for label in _texts(parameters, f"POINT:{key}")}
    tracks = {
        label: TakeTrack(times_s, position[:, index])
        for index, label in enumerate(_labels(parameters, header.points))
        if label not in dropped
    }
    return Take("c3d", tracks, unit=_unit(parameters), up=_up(parameters))


def _damaged(where: str, problem: str) -> MappingError:
    return MappingError(problem, where=where, hint="the file is damaged or cut off: export it again as C3D")


@dataclass(frozen=True)
class _Numbers:
    """How a processor stores numbers."""

    processor: int

    @property
    def order(self) -> str:
        return ">" if self.processor == MIPS else "<"

    def floats(self, content: bytes) -> Array:
        """32-bit floats; DEC's have the halves of each exchanged, and an exponent that is larger by two."""
        if self.processor != DEC:
            return np.frombuffer(content, f"{self.order}f4").astype(np.float64)
        halves = np.frombuffer(content, "<u2").reshape(-1, 2)[:, ::-1]
        return np.ascontiguousarray(halves).view("<f4")[:, 0].astype(np.float64) / 4.0

    def words(self, content: bytes) -> Array:
        """Signed 16-bit integers."""
        return np.frombuffer(content, f"{self.order}i2").astype(np.float64)

    def unsigned(self, content: bytes, at: int) -> int:
        return int(struct.unpack_from(f"{self.order}H", content, at)[0])


def _parameters(content: bytes, at: int, numbers: _Numbers) -> Iterator[tuple[str, Any]]:
    """Every parameter as ("GROUP:NAME", value): numbers as an array, texts as a list; groups may follow theirs."""
    groups: dict[int, str] = {}
    found: list[tuple[int, str, Any]] = []
    while at + 4 <= len(content):
        length, group = struct.unpack_from("bb", content, at)
        size = abs(length)
        if not size or not group:
            break
        name = content[at + 2 : at + 2 + size].decode("latin-1").strip().upper()
        after = at + 2 + size
        if group < 0:
            groups[-group] = name
        else:
            found.append((group, name, _value(content, after + 2, numbers)))
        step = numbers.unsigned(content, after)
        if not step:
            break
        at = after + step
    return ((f"{groups.get(group, '')}:{name}", value) for group, name, value in found)


def _value(content: bytes, at: int, numbers: _Numbers) -> Any:
    kind, dimensions = struct.unpack_from("bB", content, at)
    shape = list(content[at + 2 : at + 2 + dimensions])
    start, count = at + 2 + dimensions, math.prod(shape)
    data = content[start : start + count * abs(kind)]
    if len(data) < count * abs(kind):
        raise ValueError("cut off")
    if kind == -1:
        width = shape[0] if shape else 1
        return [data[i : i + width].decode("utf-8", "replace").strip(" \0") for i in range(0, len(data), width or 1)]
    if kind == 4:
        return numbers.floats(data)
    return numbers.words(data) if kind == 2 else np.frombuffer(data, np.int8).astype(np.float64)


@dataclass(frozen=True)
class _Header:
    points: int
    analog: int
    """Analog numbers of each frame."""
    first: int
    frames: int
    scale: float
    """Units per count of points that are stored as integers; negative where they are floats."""
    data: int
    """Byte at which data begin."""
    rate_hz: float


def _header(content: bytes, numbers: _Numbers, parameters: Parameters, where: str) -> _Header:
    words = [numbers.unsigned(content, 2 * k) for k in range(10)]
    first, last = words[3], words[4]
    frames = _frames(parameters, first, last)
    rate_hz = float(_number(parameters, "POINT:RATE", numbers.floats(content[20:24])[0]))
    if not (0.0 < rate_hz < 1e5):
        raise MappingError("the rate cannot be right", where=where, field="POINT:RATE", value=rate_hz, hint="mend it")
    return _Header(
        points=words[1],
        analog=words[2],
        first=max(first, 1),
        frames=frames,
        scale=float(numbers.floats(content[12:16])[0]),
        data=BLOCK * (words[8] - 1),
        rate_hz=rate_hz,
    )


def _frames(parameters: Parameters, first: int, last: int) -> int:
    """Number of frames: of the header, or of the parameters where it is more than the header can count."""
    fields = [parameters.get(f"TRIAL:ACTUAL_{end}_FIELD") for end in ("START", "END")]
    if last == LONGEST and all(field is not None and len(field) == 2 for field in fields):
        low_high = [[int(half) % (LONGEST + 1) for half in field] for field in fields if field is not None]
        start, end = (low + (LONGEST + 1) * high for low, high in low_high)
        return end - start + 1
    if last == LONGEST:
        return int(_number(parameters, "POINT:LONG_FRAMES", last - first + 1))
    return last - first + 1


def _points(content: bytes, header: _Header, numbers: _Numbers, where: str) -> Array:
    """Positions (frames, points, 3), NaN where lost."""
    if not header.points or header.frames < 1:
        raise MappingError("holds no points", where=where, hint="export trajectories, not only analog channels")
    size = 4 if header.scale < 0.0 else 2
    width = 4 * header.points + header.analog
    wanted = header.frames * width * size
    data = content[header.data : header.data + wanted]
    if header.data < BLOCK or len(data) < wanted:
        whole = len(data) // (width * size)
        raise MappingError(f"is cut off: it holds {whole} of {header.frames} frames", where=where, hint="copy it again")
    flat = numbers.floats(data) if size == 4 else numbers.words(data)
    points = flat.reshape(header.frames, width)[:, : 4 * header.points].reshape(header.frames, header.points, 4)
    position = points[..., :3] * (1.0 if size == 4 else header.scale)
    position[points[..., 3] < 0.0] = np.nan
    return np.asarray(position)


def _labels(parameters: Parameters, count: int) -> list[str]:
    """One name for each point; those without one, or with another's, are numbered."""
    texts = [text for more in ("", *map(str, range(2, 10))) for text in _texts(parameters, f"POINT:LABELS{more}")]
    labels: list[str] = []
    for index in range(count):
        text = texts[index] if index < len(texts) else ""
        labels.append(text if text and text not in labels else f"{text or 'point'} {index}".strip())
    return labels


def _texts(parameters: Parameters, key: str) -> list[str]:
    value = parameters.get(key, [])
    return value if isinstance(value, list) else []


def _number(parameters: Parameters, key: str, default: float) -> float:
    value = parameters.get(key)
    return float(value[0]) if isinstance(value, np.ndarray) and value.size and value[0] > 0 else float(default)


def _unit(parameters: Parameters) -> str | None:
    return unit_of(next(iter(_texts(parameters, "POINT:UNITS")), ""))


def _up(parameters: Parameters) -> str | None:
    """The axis that the file shows upwards on a screen."""
    text = next(iter(_texts(parameters, "POINT:Y_SCREEN")), "").lower().lstrip("+")
    return text if text.lstrip("-") in AXES else None
