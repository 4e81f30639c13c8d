"""MCAP files as containers: which records stand where, and the messages in them, one by one and within bounds.

A file from a stranger declares sizes before it holds what has them: of a record, of a text in it, of a chunk when
it is unpacked. Each is checked against the file and the limits before memory is taken for it, and every checksum that
a writer has made is verified. What nobody asks for, such as pictures of another program, is passed over and not held.

A file is walked twice. First the records are found (``survey``), which reads none but the attachments and metadata of
taskgist; then the messages are read (``messages``). So it does not matter in which order a program wrote them.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, NamedTuple

import lz4.frame
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, Metadata

from taskgist.common.text import UNSEEN
from taskgist.errors import RecordingError, most_read
from taskgist.settings import Limits

MAGIC = b"\x89MCAP0\r\n"
HEAD = struct.Struct("<BQ")
"""How a record begins: its kind, and the length of its content."""
OURS = "taskgist."
"""How the names of our metadata records begin."""
RECORDS = frozenset(OURS + name for name in ("recording", "label", "provenance"))
"""Those that are read."""
SCENE_FOLDER = "scene/"
"""How the names of our attachments begin."""

_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence, log time, publish time
_LENGTHS = {int(Opcode.FOOTER): 20, int(Opcode.DATA_END): 4}  # bytes of records that all have the same
_LONGEST_NAME = 1024  # bytes; longer ones are not ours
_ENTRY_BYTES = 1024  # what an attachment takes beside its content
_MOST_TOPICS = 20  # that a message tells
_PIECE_BYTES = 2**20
_DAMAGE = (
    McapError,
    zstandard.ZstdError,
    struct.error,
    EOFError,
    ValueError,  # UnicodeDecodeError among them
    KeyError,
    RuntimeError,  # of lz4
    MemoryError,
    OverflowError,
)


class Place(NamedTuple):
    """Where a record stands: its kind, where it starts, in bytes, and how long its content is."""

    kind: int
    start: int
    length: int

    @property
    def end(self) -> int:
        """Where the next record starts."""
        return self.start + HEAD.size + self.length


class Message(NamedTuple):
    """One message, as it was logged."""

    topic: str
    time_ns: int
    data: bytes


@dataclass(eq=False)
class Survey:
    """What stands where in a file.

    Attributes:
        files: Content of the attachments beneath ``scene/``, by name without that.
        metadata: Records of taskgist: by name without "taskgist.", values as the JSON texts that they are.
        places: Where each metadata record of taskgist stands, by the same names.
        topics: Topics of the channels that are told outside of chunks.
        data_end: The record that ends the data.
        footer: The last record.
        held_bytes: What the attachments take.
    """

    files: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    places: dict[str, Place] = field(default_factory=dict)
    topics: set[str] = field(default_factory=set)
    data_end: Place | None = None
    footer: Place | None = None
    held_bytes: int = 0


def survey(stream: IO[bytes], path: Path, limits: Limits) -> Survey:
    """Find out what a file holds, without its messages.

    Args:
        stream: The file.
        path: Its name, for messages.
        limits: Of the attachments together, and of the largest record that is held whole.

    Raises:
        RecordingError: It is no MCAP file, cut off or damaged, or holds more than is read.
    """
    _check_magic(stream, path)
    found = Survey()
    with damage_reported(path):
        for place in walk(stream):
            if place.kind in _SURVEYED:
                _SURVEYED[Opcode(place.kind)](found, stream, place, path, limits)
        if not found.data_end or not found.footer:
            raise ValueError("its data have no end")
        _check_summary(stream, found.footer)
    return found


def walk(stream: IO[bytes]) -> Iterator[Place]:
    """Every record of a file in order, from behind the magic to the footer; none reaches beyond the file.

    Raises:
        ValueError: One does, or the file does not end as it should.
        struct.error: It ends within a record's head.
    """
    size, start = os.fstat(stream.fileno()).st_size, len(MAGIC)
    while True:
        stream.seek(start)
        kind, length = HEAD.unpack(stream.read(HEAD.size))
        place = Place(kind, start, length)
        if place.end > size:
            raise ValueError(f"a record of {length:,} bytes begins at byte {start:,} of {size:,}")
        if length != _LENGTHS.get(kind, length):
            raise ValueError(f"a record of kind {kind} has {length:,} bytes instead of {_LENGTHS[kind]}")
        if kind == 0:
            raise ValueError(f"no record begins at byte {start:,}")
        yield place
        start = place.end
        if kind == Opcode.FOOTER:
            stream.seek(start)
            if stream.read(len(MAGIC)) != MAGIC:
                raise ValueError("the closing bytes are missing")
            return


def content(stream: IO[bytes], place: Place) -> bytes:
    """The content of a record."""
    stream.seek(place.start + HEAD.size)
    return stream.read(place.length)


def _check_magic(stream: IO[bytes], path: Path) -> None:
    stream.seek(0)
    start = stream.read(len(MAGIC))
    if not start:
        raise RecordingError("the file is empty", where=path, hint="copy or import the recording again")
    if start != MAGIC:
        hint = "import tables of motion with: taskgist import MAPPING.toml -o RECORDING.mcap"
        raise RecordingError("not an MCAP file", where=path, value=start, hint=hint)


@contextmanager
def damage_reported(path: Path) -> Iterator[None]:
    """Let what fails on damaged bytes be one clear error."""
    try:
        yield
    except _DAMAGE as problem:
        hint = "copy it again from where it came from, or import it again"
        value = f"{type(problem).__name__}: {problem}"
        raise RecordingError("the file is cut off or damaged", where=path, value=value, hint=hint) from None


def refuse_size(what: str, size: int, limit: int, setting: str, path: Path) -> None:
    """Refuse what is larger than it may be.

    Raises:
        RecordingError: It is.
    """
    if size > limit:
        raise RecordingError(
            "is too large",
            where=path,
            field=what,
            value=f"{size:,} bytes",
            hint=most_read(limit, setting),
        )


# --- What is surveyed.


def _attachment(found: Survey, stream: IO[bytes], place: Place, path: Path, limits: Limits) -> None:
    name = _name(stream, place, 16)
    if not name.startswith(SCENE_FOLDER):
        return
    found.held_bytes += place.length + _ENTRY_BYTES
    refuse_size("attachments beneath scene/", found.held_bytes, limits.bundle_bytes, "bundle_bytes", path)
    name = name.removeprefix(SCENE_FOLDER)
    _check_file_name(name, path)
    if name in found.files:
        raise _twice(f"attachment {SCENE_FOLDER}{name}", path)
    data = content(stream, place)
    attachment = Attachment.read(_fields(data))
    (checksum,) = struct.unpack("<I", data[-4:])
    if checksum not in (0, zlib.crc32(memoryview(data)[:-4])):
        raise ValueError(f"checksum of attachment {name!r}")
    found.files[name] = attachment.data


def _metadata(found: Survey, stream: IO[bytes], place: Place, path: Path, limits: Limits) -> None:
    name = _name(stream, place, 0)
    short = name.removeprefix(OURS)
    if name not in RECORDS:
        return
    refuse_size(f"metadata record {name}", place.length, limits.message_bytes, "message_bytes", path)
    if short in found.metadata:
        raise _twice(f"metadata record {name}", path)
    found.metadata[short] = Metadata.read(_fields(content(stream, place))).metadata
    found.places[short] = place


def _channel(found: Survey, stream: IO[bytes], place: Place, path: Path, limits: Limits) -> None:
    if len(found.topics) < _MOST_TOPICS:
        refuse_size("a channel", place.length, limits.message_bytes, "message_bytes", path)
        found.topics.add(Channel.read(_fields(content(stream, place))).topic)


def _index(_found: Survey, _stream: IO[bytes], place: Place, path: Path, limits: Limits) -> None:
    refuse_size("a record of its summary", place.length, limits.message_bytes, "message_bytes", path)


def _data_end(found: Survey, _stream: IO[bytes], place: Place, _path: Path, _limits: Limits) -> None:
    found.data_end = found.data_end or place


def _footer(found: Survey, _stream: IO[bytes], place: Place, _path: Path, _limits: Limits) -> None:
    found.footer = place


_SURVEYED: dict[Opcode, Callable[[Survey, IO[bytes], Place, Path, Limits], None]] = {
    Opcode.ATTACHMENT: _attachment,
    Opcode.METADATA: _metadata,
    Opcode.CHANNEL: _channel,
    Opcode.STATISTICS: _index,
    Opcode.CHUNK_INDEX: _index,
    Opcode.ATTACHMENT_INDEX: _index,
    Opcode.METADATA_INDEX: _index,
    Opcode.DATA_END: _data_end,
    Opcode.FOOTER: _footer,
}


def _name(stream: IO[bytes], place: Place, before: int) -> str:
    """The name that a record's content begins with, behind some bytes; empty where it is too long to be ours."""
    begins = content(stream, place._replace(length=min(place.length, before + 4 + _LONGEST_NAME)))[before:]
    (length,) = struct.unpack_from("<I", begins)
    return begins[4 : 4 + length].decode("utf-8") if length <= _LONGEST_NAME else ""


def _fields(data: bytes | memoryview) -> ReadDataStream:
    """Bytes as mcap's records read them; no field reaches beyond them."""
    return ReadDataStream(BytesIO(data))


def _check_file_name(name: str, path: Path) -> None:
    """Refuse names that nobody gives a file.

    Names are only ever looked up among the attachments of the same recording: the scene of a user whose model is
    ``../models/room.xml`` has one of that name, which leads nowhere.
    """
    if not name or UNSEEN.search(name):
        raise RecordingError(
            "an attachment without a name, or with control characters in it",
            where=path,
            field="attachment",
            value=SCENE_FOLDER + name,
            hint="names are such as scene/room.xml",
        )


def _twice(what: str, path: Path) -> RecordingError:
    return RecordingError("stands in the file twice", where=path, field=what, hint="write the recording anew")


def _check_summary(stream: IO[bytes], footer: Place) -> None:
    """Verify the checksum of what follows the data, where there is one."""
    start, _, checksum = struct.unpack("<QQI", content(stream, footer)[:20])
    if not checksum:
        return
    found = checksum_of(stream, start or footer.start, footer.start + HEAD.size + 16)
    if found != checksum:
        raise ValueError("checksum of the summary")


def checksum_of(stream: IO[bytes], start: int, end: int, before: int = 0) -> int:
    """CRC of a range of bytes, appended to others of which the CRC is known."""
    for piece in pieces(stream, start, end):
        before = zlib.crc32(piece, before)
    return before


def pieces(stream: IO[bytes], start: int, end: int) -> Iterator[bytes]:
    """A range of bytes, a piece at a time."""
    stream.seek(start)
    left = end - start
    while left > 0:
        piece = stream.read(min(left, _PIECE_BYTES))
        if not piece:
            raise EOFError("a range beyond the file")
        yield piece
        left -= len(piece)


# --- Messages.


def messages(stream: IO[bytes], path: Path, limits: Limits, topics: frozenset[str]) -> Iterator[Message]:
    """The messages of some topics, in the order in which they stand in the file.

    Args:
        stream: The file.
        path: Its name, for messages.
        limits: Of a chunk, and of a message.
        topics: The topics; messages of others are passed over.

    Raises:
        RecordingError: The file is damaged, or a chunk or message is larger than what is read.
    """
    reader = _Messages(path, limits, topics)
    records = walk(stream)
    checksum = zlib.crc32(MAGIC)
    while True:
        with damage_reported(path):
            place = next(records)
            if place.kind == Opcode.DATA_END:
                (expected,) = struct.unpack("<I", content(stream, place)[:4])
                if expected not in (0, checksum):
                    raise ValueError("checksum of the data")
                return
            if place.kind not in (Opcode.CHUNK, Opcode.CHANNEL, Opcode.MESSAGE):
                checksum = checksum_of(stream, place.start, place.end, checksum)
                continue
            reader.check(place)
            data = content(stream, place)
            checksum = zlib.crc32(data, zlib.crc32(HEAD.pack(place.kind, place.length), checksum))
        yield from reader.read(place.kind, memoryview(data))


class _Messages:
    """Reads messages, and knows the channels that were told so far."""

    def __init__(self, path: Path, limits: Limits, topics: frozenset[str]) -> None:
        self._path, self._limits, self._wanted = path, limits, topics
        self._topics: dict[int, str] = {}

    def check(self, place: Place) -> None:
        """Refuse a record that is too large to be looked into."""
        refuse_size(
            f"record at byte {place.start:,}", place.length, self._limits.chunk_bytes, "chunk_bytes", self._path
        )

    def read(self, kind: int, data: memoryview) -> Iterator[Message]:
        """The messages in the content of one record."""
        with damage_reported(self._path):
            records = self._unpacked(data) if kind == Opcode.CHUNK else iter([(kind, data)])
        while True:
            with damage_reported(self._path):
                record = next(records, None)
                if record is None:
                    return
                kind, data = record
                message = self._message(data) if kind == Opcode.MESSAGE else None
                if kind == Opcode.CHANNEL:
                    channel = Channel.read(_fields(data))
                    self._topics[channel.id] = channel.topic if channel.topic in self._wanted else ""
            if message:
                yield message

    def _message(self, data: memoryview) -> Message | None:
        channel, _, time_ns, _ = _MESSAGE.unpack_from(data)
        topic = self._topics[channel]
        if not topic:
            return None
        refuse_size(f"a message of {topic}", len(data), self._limits.message_bytes, "message_bytes", self._path)
        return Message(topic, time_ns, bytes(data[_MESSAGE.size :]))

    def _unpacked(self, data: memoryview) -> Iterator[tuple[int, memoryview]]:
        """Kind and content of the records in a chunk."""
        chunk = Chunk.read(_fields(data))
        size = chunk.uncompressed_size
        refuse_size("a chunk, unpacked,", size, self._limits.chunk_bytes, "chunk_bytes", self._path)
        unpacked = _unpack(chunk)
        if len(unpacked) != size:
            raise ValueError(f"a chunk of {len(unpacked):,} bytes declares {size:,}")
        if chunk.uncompressed_crc not in (0, zlib.crc32(unpacked)):
            raise ValueError("checksum of a chunk")
        return _records_in(memoryview(unpacked))


def _records_in(unpacked: memoryview) -> Iterator[tuple[int, memoryview]]:
    start = 0
    while start < len(unpacked):
        kind, length = HEAD.unpack_from(unpacked, start)
        if not kind:  # no format has it, but bytes that were never written look so, millions of them
            raise ValueError("a record of no kind in a chunk")
        start += HEAD.size
        if length > len(unpacked) - start:
            raise ValueError(f"a record of {length:,} bytes in a chunk of {len(unpacked):,}")
        yield kind, unpacked[start : start + length]
        start += length


def _unpack(chunk: Chunk) -> bytes:
    """The records of a chunk, in no more memory than the chunk declares.

    Raises:
        ValueError: It is packed in an unknown way, or holds more.
    """
    size: int = chunk.uncompressed_size
    data: bytes = chunk.data
    if not chunk.compression or not data:
        return data
    if chunk.compression == "zstd":
        if zstandard.frame_content_size(data) > size:  # what the frame itself declares is taken, whatever is asked for
            raise ValueError("a chunk unpacks to more than it declares")
        return zstandard.ZstdDecompressor().decompress(data, max_output_size=size)
    if chunk.compression == "lz4":
        unpacked: bytes = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
        return unpacked
    raise ValueError(f"a chunk is packed as {chunk.compression!r}")
