"""One metadata record of a file replaced, and all else copied byte for byte: by pieces, so that no size matters.

What stands behind the new record moves by some bytes. Chunks and what is in them tell their places from where they
begin, and stay as they are; the summary at the end of a file tells places from where the file begins::

    magic, header, attachments ...  old record  ... chunks ... end of data │ summary: indexes, statistics │ footer
    └──────────── copied ────────┘└─ replaced ─┘└──────── copied ─────────┘ └──────── places moved ───────┘
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, groupby
from pathlib import Path
from typing import IO

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import DataEnd, Footer, McapRecord, Metadata, MetadataIndex, SummaryOffset

from taskgist.recording.container import HEAD, MAGIC, OURS, Place, Survey, content, damage_reported, pieces, walk


@dataclass(frozen=True)
class _Splice:
    """Bytes of a file that are replaced.

    Attributes:
        start: Where they begin.
        end: Where they end; ``start``, if the new ones are only put in.
        new: What comes in their place.
    """

    start: int
    end: int
    new: bytes

    def moved(self, place: int) -> int:
        """Where something stands afterwards that begins at this place."""
        return place if place < self.end else place + len(self.new) - (self.end - self.start)


def with_metadata(
    stream: IO[bytes], target: IO[bytes], name: str, values: Mapping[str, str], found: Survey, path: Path
) -> None:
    """Copy a file with one metadata record replaced, or put in behind the others of taskgist.

    Args:
        stream: The file.
        target: The new file.
        name: Name of the record, of which there is one at most.
        values: What it holds from now on.
        found: What stands where in the file.
        path: Name of the file, for messages.

    Raises:
        RecordingError: The summary of the file is damaged.
    """
    old = found.places.get(name.removeprefix(OURS))
    last = max(place.end for place in found.places.values())
    splice = _Splice(old.start if old else last, old.end if old else last, _bytes_of(Metadata(name, dict(values))))
    assert found.data_end
    assert found.footer
    with damage_reported(path):
        checksum = _copy_data(stream, target, splice, found.data_end)
        (had_checksum,) = struct.unpack("<I", content(stream, found.data_end)[:4])
        target.write(_bytes_of(DataEnd(checksum if had_checksum else 0)))
        records = (place for place in walk(stream) if found.data_end.end <= place.start < found.footer.start)
        _write_end(stream, target, records, found.footer, splice, MetadataIndex(splice.start, len(splice.new), name))


def _copy_data(stream: IO[bytes], target: IO[bytes], splice: _Splice, data_end: Place) -> int:
    """Copy all data with the bytes replaced; their checksum."""
    checksum = 0
    before, behind = pieces(stream, 0, splice.start), pieces(stream, splice.end, data_end.start)
    for piece in chain(before, [splice.new], behind):
        checksum = zlib.crc32(piece, checksum)
        target.write(piece)
    return checksum


class _Summary:
    """Writes the summary of a file, and keeps in mind where its groups stand.

    Args:
        target: The new file, behind the end of its data.
        splice: What was replaced before.
    """

    def __init__(self, target: IO[bytes], splice: _Splice) -> None:
        self._target, self._splice = target, splice
        self.start = self.end = target.tell()
        self.checksum = 0
        self.groups: dict[int, tuple[int, int]] = {}

    def write(self, data: bytes, kind: int | None = None) -> None:
        """Write some bytes, of a record of some kind."""
        self._target.write(data)
        self.checksum = zlib.crc32(data, self.checksum)
        if kind is not None:
            first, _ = self.groups.get(kind, (self.end, 0))
            self.groups[kind] = (first, self.end + len(data))
        self.end += len(data)

    def copy(self, stream: IO[bytes], place: Place, name: str) -> None:
        """Write a record with the places that it tells as they are now; that of the old metadata record is left out.

        Args:
            stream: The old file.
            place: Where the record stands in it.
            name: Name of the metadata record that was replaced.
        """
        if place.kind not in _TELL_PLACES:
            for piece in pieces(stream, place.start, place.end):
                self.write(piece, place.kind)
            return
        data = bytearray(content(stream, place))
        if place.kind == Opcode.METADATA_INDEX and _name_in(data) == name:
            return
        if place.kind == Opcode.STATISTICS and self._splice.start == self._splice.end:
            _change(data, 18, "<I", lambda count: count + 1)  # metadata records
        elif place.kind == Opcode.CHUNK_INDEX:
            _change(data, 16, "<Q", self._splice.moved)
            (length,) = struct.unpack_from("<I", data, 32)
            for at in range(36, 36 + length, 10):
                _change(data, at + 2, "<Q", self._splice.moved)
        elif place.kind != Opcode.STATISTICS:
            _change(data, 0, "<Q", self._splice.moved)
        self.write(HEAD.pack(place.kind, len(data)) + data, place.kind)


_TELL_PLACES = frozenset({Opcode.STATISTICS, Opcode.CHUNK_INDEX, Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX})


def _write_end(
    stream: IO[bytes], target: IO[bytes], records: Iterator[Place], footer: Place, splice: _Splice, index: MetadataIndex
) -> None:
    """Write summary and footer, as they are with these bytes replaced."""
    _, offsets_start, had_checksum = struct.unpack("<QQI", content(stream, footer)[:20])
    summary = _Summary(target, splice)
    for kind, group in groupby(records, key=lambda place: place.kind):
        if kind == Opcode.SUMMARY_OFFSET:
            continue
        for place in group:
            summary.copy(stream, place, index.name)
        if kind == Opcode.METADATA_INDEX:  # without one the writer makes no such index
            summary.write(_bytes_of(index), kind)
    start = summary.start if summary.groups else 0
    offsets_start = summary.end if offsets_start else 0
    for kind, (first, end) in list(summary.groups.items()) if offsets_start else ():
        summary.write(_bytes_of(SummaryOffset(kind, first, end - first)))
    checksum = zlib.crc32(HEAD.pack(Opcode.FOOTER, 20) + struct.pack("<QQ", start, offsets_start), summary.checksum)
    target.write(_bytes_of(Footer(start, offsets_start, checksum if had_checksum else 0)) + MAGIC)


def _change(data: bytearray, at: int, kind: str, change: Callable[[int], int]) -> None:
    struct.pack_into(kind, data, at, change(struct.unpack_from(kind, data, at)[0]))


def _name_in(data: bytearray) -> str:
    """The name in the content of a metadata index."""
    (length,) = struct.unpack_from("<I", data, 16)
    return data[20 : 20 + length].decode("utf-8")


def _bytes_of(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    written: bytes = builder.end()  # type: ignore[no-untyped-call]  # mcap leaves it untyped
    return written
