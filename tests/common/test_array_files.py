"""NPZ and NPY files of anybody: NumPy itself is the witness for good ones, and bad ones are told in one error."""

from __future__ import annotations

import io
import os
import re
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from taskgist.common.array_files import ArrayFile
from taskgist.errors import InputError, UnknownNameError

MOST = 2**20
DTYPES = ["<f8", ">f4", "<i2", "|b1", "<U5", "<c16"]


@given(
    st.sampled_from(DTYPES).flatmap(
        lambda kind: arrays_of.arrays(kind, arrays_of.array_shapes(min_side=0, max_side=4))
    ),
    st.booleans(),
    st.sampled_from(["npz", "packed", "npy"]),
)
def test_gives_what_numpy_wrote(
    tmp_path_factory: pytest.TempPathFactory, array: np.ndarray, by_column: bool, kind: str
) -> None:
    path = tmp_path_factory.mktemp("arrays") / "a.npz"
    written = np.asfortranarray(array) if by_column else array
    with path.open("wb") as stream:
        if kind == "npy":
            np.save(stream, written)
        else:
            (np.savez if kind == "npz" else np.savez_compressed)(stream, x=written, other=np.zeros(2))
    file = ArrayFile(path, most_bytes=MOST)
    found = file.array(file.names[0])
    assert found.dtype == array.dtype
    np.testing.assert_array_equal(found, array)
    assert not found.flags.writeable


def saved(path: Path, **arrays: np.ndarray) -> bytes:
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]  # its other keyword is no array
    return path.read_bytes()


def test_only_what_is_asked_for_is_loaded(tmp_path: Path) -> None:
    saved(tmp_path / "a.npz", small=np.arange(3), large=np.zeros(MOST), more=np.zeros(MOST // 16))
    file = ArrayFile(tmp_path / "a.npz", most_bytes=MOST)
    assert file.names == ("small", "large", "more")
    assert file.array("small").tolist() == [0, 1, 2]
    with pytest.raises(InputError, match=r"a.npz: large: is too large \(got '8,388,608 bytes'\).*limits.table_bytes"):
        file.array("large")
    file.array("more")
    with pytest.raises(UnknownNameError, match="no array 'x'"):
        file.array("x")


def test_all_arrays_together_are_bounded(tmp_path: Path) -> None:
    saved(tmp_path / "a.npz", a=np.zeros(MOST // 16), b=np.zeros(MOST // 16), c=np.zeros(1))
    file = ArrayFile(tmp_path / "a.npz", most_bytes=MOST)
    file.array("a")
    file.array("b")
    with pytest.raises(InputError, match="c: is too large"):
        file.array("c")


def header_lies(_: bytes) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    return archive(stream.getvalue())


def header_is_longer_than_data(_: bytes) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": (100,)})
    return archive(stream.getvalue() + bytes(80))


def archive(content: bytes, name: str = "x.npy") -> bytes:
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as packed:
        packed.writestr(name, content)
    return stream.getvalue()


def entry_changed(offset: int, value: int) -> Callable[[bytes], bytes]:
    """A field of two bytes of the entry in the directory."""

    def changed(data: bytes) -> bytes:
        at = data.index(b"PK\x01\x02") + offset
        return data[:at] + struct.pack("<H", value) + data[at + 2 :]

    return changed


def checksum_changed(data: bytes) -> bytes:
    return entry_changed(16, 0)(data)


def objects(_: bytes) -> bytes:
    stream = io.BytesIO()
    np.save(stream, np.array([{"a": 1}], dtype=object))
    return archive(stream.getvalue())


def directory_of_a_gibibyte(data: bytes) -> bytes:
    at = data.rindex(b"PK\x05\x06") + 12
    return data[:at] + struct.pack("<I", 2**30) + data[at + 4 :]


BAD: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "a lying header": (header_lies, "x: is too large"),
    "cut off": (header_is_longer_than_data, "x: not a plain array .*cut off: 80 bytes instead of 800"),
    "another method": (entry_changed(10, 97), "x: not a plain array .*NotImplementedError"),
    "encrypted": (entry_changed(8, 1), "x: not a plain array"),
    "a wrong checksum": (checksum_changed, "x: not a plain array .*Bad CRC"),
    "objects": (objects, "x: not a plain array .*objects of Python"),
    "no header": (lambda _: archive(b"\x93NUMPY\x01\x00\x10\x00{'descr': ((((((("), "x: not a plain array"),
    "nothing": (lambda _: b"", "not a file of plain arrays"),
    "text": (lambda _: b"x" * 100, "not a file of plain arrays"),
    "half": (lambda data: data[: len(data) // 2], "not a file of plain arrays"),
    "a directory of a gibibyte": (directory_of_a_gibibyte, "not a file of plain arrays .*too many arrays"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_bad_is_told(name: str, tmp_path: Path) -> None:
    spoil, message = BAD[name]
    path = tmp_path / "bad.npz"
    path.write_bytes(spoil(saved(path, x=np.arange(100.0))))
    with pytest.raises(InputError) as told:
        ArrayFile(path, most_bytes=MOST).array("x")
    assert re.search(rf"bad.npz: {message}", str(told.value))


def test_every_flipped_byte_is_told_or_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    whole = saved(path, x=np.arange(30.0))
    told = 0
    for place in range(len(whole)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            found = ArrayFile(path, most_bytes=MOST).array("x")
        except InputError as error:
            told += str(path) in str(error)
        else:
            np.testing.assert_array_equal(found, np.arange(30.0))
            told += 1
    assert told == len(whole)


def test_a_pipe_is_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.npz")
    with pytest.raises(InputError, match=r"pipe.npz: cannot be read: it is a pipe"):
        ArrayFile(tmp_path / "pipe.npz", most_bytes=MOST)
