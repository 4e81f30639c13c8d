"""Arrays of MATLAB: files of version 5 to 7, read by SciPy once it is known how much they hold.

A variable is an array by its name, and so is a field of a structure: ``take.Trajectories.Labeled.Data``. Files of
version 7.3 are HDF5, which is not read.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from taskgist.common.files import reading, shown_path
from taskgist.errors import MappingError, UnknownNameError, most_read

BEGINNING, VERSION_7_3 = b"MATLAB 5.0", b"MATLAB 7.3"
HEADER_BYTES, ORDER_AT = 128, 126
COMPRESSED = 15
"""Type of an element that is packed."""
CHUNK_BYTES = 2**20
DEEPEST = 8
"""Structures within structures that are looked into."""
HINT = "save plain arrays or structures of them with save(..., '-v7')"


class MatFile:
    """The arrays of a file of MATLAB.

    Args:
        path: The file.
        most_bytes: What it may take, unpacked.
        where: How messages name it; by default its path.

    Attributes:
        names: Of the arrays of numbers; those of structures with dots.

    Raises:
        MappingError: It cannot be read, is damaged, too large, or of another version.
    """

    def __init__(self, path: Path, *, most_bytes: int, where: str | None = None) -> None:
        self._where = where or shown_path(path)
        try:
            with reading(path, error=MappingError) as stream:
                self._arrays = self._read(stream, most_bytes)
        except MappingError as problem:
            problem.where = self._where
            raise
        self.names = tuple(self._arrays)

    def _read(self, stream: BinaryIO, most_bytes: int) -> dict[str, NDArray[Any]]:
        _check_size(stream, most_bytes, self._where)
        stream.seek(0)
        try:
            return dict(_flat(_loaded(stream)))
        except Exception as problem:  # SciPy fails in many ways on what is damaged
            text = f"{type(problem).__name__}: {problem}"
            raise MappingError("not a file of MATLAB 5 to 7", where=self._where, value=text, hint=HINT) from problem

    def array(self, name: str) -> NDArray[Any]:
        """One of the arrays.

        Raises:
            UnknownNameError: There is no such array.
        """
        if name not in self._arrays:
            raise UnknownNameError("array", name, self.names, where=self._where)
        return self._arrays[name]


def _loaded(stream: BinaryIO) -> dict[str, Any]:
    from scipy.io import loadmat

    loaded = loadmat(stream, squeeze_me=True, struct_as_record=False, mat_dtype=True)
    return {name: value for name, value in loaded.items() if not name.startswith("__")}


def _flat(values: dict[str, Any], prefix: str = "", depth: int = 0) -> Iterator[tuple[str, NDArray[Any]]]:
    """Arrays of numbers by their names, structures opened."""
    for name, value in values.items():
        if hasattr(value, "_fieldnames"):
            if depth < DEEPEST:
                inner = {field: getattr(value, field) for field in value._fieldnames}
                yield from _flat(inner, f"{prefix}{name}.", depth + 1)
        elif (array := np.asarray(value)).dtype.kind in "fiub" and array.ndim:
            yield f"{prefix}{name}", array.astype(np.float64)


def _check_size(stream: BinaryIO, most_bytes: int, where: str) -> None:
    """Refuse a file that would unpack to more than it may take, before anything of it is kept.

    Raises:
        MappingError: It would, or is of another version.
    """
    header = stream.read(HEADER_BYTES)
    if header.startswith(VERSION_7_3):
        raise MappingError("a file of MATLAB 7.3, which is HDF5", where=where, hint=HINT)
    if not header.startswith(BEGINNING) or len(header) < HEADER_BYTES:
        raise MappingError("not a file of MATLAB 5 to 7", where=where, hint=HINT)
    order = "<" if header[ORDER_AT:] == b"IM" else ">"
    total = 0
    while len(tag := stream.read(8)) == 8:
        kind, size = struct.unpack(f"{order}II", tag)
        sizes = _unpacked(stream, size) if kind == COMPRESSED else _skipped(stream, size)
        for more in sizes:
            total += more
            if total > most_bytes:
                hint = most_read(most_bytes, "table_bytes")
                raise MappingError("is too large", where=where, value=f"over {total:,} bytes", hint=hint)


def _unpacked(stream: BinaryIO, size: int) -> Iterator[int]:
    """How much a packed element holds, piece by piece."""
    unpacker = zlib.decompressobj()
    with suppress(zlib.error):  # what is damaged is told when it is read
        while size > 0 and (packed := stream.read(min(size, CHUNK_BYTES))):
            size -= len(packed)
            while packed:
                yield len(unpacker.decompress(packed, CHUNK_BYTES))
                packed = unpacker.unconsumed_tail


def _skipped(stream: BinaryIO, size: int) -> Iterator[int]:
    yield size
    stream.seek(size, 1)
