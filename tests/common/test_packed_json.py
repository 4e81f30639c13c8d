"""Compressed JSON of anybody: bounded while it is unpacked, and told in one error where it is none."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from taskgist.common.documents import read_packed_json
from taskgist.errors import InputError

MOST = 2**16


def read(path: Path) -> dict[str, object]:
    return read_packed_json(path, most_bytes=MOST, problem="not a list of things", hint="make one")


def test_gives_what_was_written(tmp_path: Path) -> None:
    path = tmp_path / "a.json.gz"
    path.write_bytes(gzip.compress(b'{"a": ') + gzip.compress('[1, "é"]}'.encode()))  # two members, as gzip allows
    assert read(path) == {"a": [1, "é"]}


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{}",
        gzip.compress(b"[]"),
        gzip.compress(b"\xff"),
        gzip.compress(b"[" * 10_000),
        gzip.compress(json.dumps({"a": 1}).encode())[:-6],
        gzip.compress(bytes(MOST * 4)),
        gzip.compress(b" " * MOST) * 100 + gzip.compress(b"{}"),
    ],
    ids=["empty", "plain", "a list", "no text", "deep", "cut off", "large", "many members"],
)
def test_what_is_none_is_told(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "a.json.gz"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"a\.json\.gz: not a list of things: ") as told:
        read(path)
    assert len(str(told.value)) < 500


def test_the_largest_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.json.gz"
    path.write_bytes(gzip.compress(b"{}".ljust(MOST)))
    assert read(path) == {}
