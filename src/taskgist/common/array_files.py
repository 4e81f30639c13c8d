"""Arrays on disk, from anybody: NPZ and NPY files, whose sizes are looked at before anything is unpacked.

NumPy believes what a file says of itself: a header of a few bytes makes it take gibibytes, and a damaged archive ends
in any of a dozen errors. Here the archive's directory and the array's header are read first, an array is only loaded
if it is asked for, and whatever is wrong comes as one error that names the file and the array.
"""

from __future__ import annotations

import math
import os
import struct
import warnings
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from taskgist.common.files import reading
from taskgist.errors import InputError, UnknownNameError, most_read

SUFFIX = ".npy"
"""How the names of arrays end in an archive."""
MOST_DIRECTORY_BYTES = 2**20
"""Largest directory of an archive: ten thousand arrays."""
END = b"PK\x05\x06"
"""How the end of an archive begins, which tells how large its directory is."""
LONGEST_END = 22 + 2**16
HINT = "save plain arrays of numbers or texts with numpy.savez or numpy.save"


class ArrayFile:
    """The arrays of an NPZ or NPY file; each is loaded when it is asked for.

    Args:
        path: The file.
        most_bytes: What all arrays together may take that are asked for, unpacked.
        where: How messages name the file; by default its path.
        error: The class of the errors.

    Attributes:
        names: Of the arrays; that of an NPY file is the file's.

    Raises:
        InputError: It is no regular file, or cannot be read as an archive of arrays.
    """

    def __init__(
        self, path: Path, *, most_bytes: int, where: str | None = None, error: type[InputError] = InputError
    ) -> None:
        self._path, self._most_bytes, self._error = path, most_bytes, error
        self._where = where or str(path)
        self._loaded: dict[str, NDArray[Any]] = {}
        with self._told(), self._opened() as (stream, archive):
            if archive is None:
                self.names: tuple[str, ...] = (path.name,)
                np.lib.format.read_magic(stream)
            else:
                members = dict.fromkeys(archive.namelist())
                self.names = tuple(name.removesuffix(SUFFIX) for name in members if name.endswith(SUFFIX))

    def array(self, name: str) -> NDArray[Any]:
        """One of the arrays, read-only.

        Raises:
            UnknownNameError: There is no such array.
            InputError: It is damaged, holds objects, or is too large.
        """
        if name not in self.names:
            raise UnknownNameError("array", name, self.names, where=self._where)
        if name not in self._loaded:
            with self._told(name), self._opened() as (stream, archive):
                if archive is None:
                    self._loaded[name] = self._read(stream, name)
                else:
                    with archive.open(f"{name}{SUFFIX}") as packed:
                        self._loaded[name] = self._read(packed, name)
                        packed.read(1)  # at its end, the checksum is compared
        return self._loaded[name]

    @contextmanager
    def _opened(self) -> Iterator[tuple[BinaryIO, zipfile.ZipFile | None]]:
        with reading(self._path, error=self._error) as stream:
            if stream.read(2) != b"PK":
                stream.seek(0)
                yield stream, None
                return
            if _directory_bytes(stream) > MOST_DIRECTORY_BYTES:
                raise ValueError("an archive of too many arrays")
            with zipfile.ZipFile(stream) as archive:
                yield stream, archive

    def _read(self, stream: IO[bytes], name: str) -> NDArray[Any]:
        version = np.lib.format.read_magic(stream)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }[version]
        shape, by_column, dtype = read_header(stream)
        if dtype.hasobject:
            raise ValueError("it holds objects of Python")
        size = math.prod(shape) * dtype.itemsize
        free = self._most_bytes - sum(array.nbytes for array in self._loaded.values())
        if size > free:
            raise self._error(
                "is too large",
                where=self._where,
                field=name,
                value=f"{size:,} bytes",
                hint=most_read(self._most_bytes, "table_bytes"),
            )
        content = stream.read(size)
        if len(content) < size:
            raise ValueError(f"it is cut off: {len(content):,} bytes instead of {size:,}")
        flat = np.frombuffer(content, dtype=dtype)
        return flat.reshape(shape[::-1]).T if by_column else flat.reshape(shape)

    @contextmanager
    def _told(self, name: str | None = None) -> Iterator[None]:
        """Any error as one of ours; what libraries warn of is part of it, or does not matter."""
        try:
            with warnings.catch_warnings(action="ignore"):
                yield
        except InputError as problem:
            problem.where = self._where
            raise
        except Exception as problem:  # zipfile, its decompressors and numpy fail in many ways on what is damaged
            problem_text = f"{type(problem).__name__}: {problem}" if str(problem) else type(problem).__name__
            raise self._error(
                "not a file of plain arrays" if name is None else "not a plain array",
                where=self._where,
                field=name,
                value=problem_text,
                hint=HINT,
            ) from problem


def _directory_bytes(stream: BinaryIO) -> int:
    """How large the directory of an archive says that it is; 0 if there is none."""
    stream.seek(max(0, os.fstat(stream.fileno()).st_size - LONGEST_END))
    tail = stream.read(LONGEST_END)
    at = tail.rfind(END)
    stream.seek(0)
    return int(struct.unpack_from("<I", tail, at + 12)[0]) if 0 <= at <= len(tail) - 22 else 0
