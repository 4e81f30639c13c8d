"""Reads an MCAP file of taskgist into plain values, and says in one clear error why another file is not one."""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import zstandard
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader

from taskgist.errors import RecordingError

FORMAT = 1
"""Version of the format; files of a newer one are refused."""

_MAGIC = b"\x89MCAP0\r\n"
_OURS = "taskgist."
_DAMAGE = (
    McapError,
    zstandard.ZstdError,
    struct.error,
    EOFError,
    ValueError,  # UnicodeDecodeError and JSONDecodeError among them
    KeyError,
    IndexError,
    MemoryError,
    OverflowError,  # a length that no file has
)


@dataclass(frozen=True, eq=False)
class Content:
    """What a recording's file holds.

    Attributes:
        attachments: By name.
        metadata: Records of taskgist by name without "taskgist.", each value parsed.
        times_ns: Time of each state.
        states: The states, as JSON values.
        signals: The signals, likewise; none if there are none.
    """

    attachments: dict[str, bytes]
    metadata: dict[str, dict[str, Any]]
    times_ns: tuple[int, ...]
    states: tuple[Any, ...]
    signals: tuple[Any, ...]


def read_content(path: Path, states: str, signals: str) -> Content:
    """Read a file from start to end, so that every checksum in it is verified.

    Args:
        path: The file.
        states: Topic of the states.
        signals: Topic of the signals.

    Raises:
        RecordingError: It is missing, empty, no MCAP file, cut off or damaged, of something else, or of a newer format.
    """
    found = _Found()
    with _opened(path) as stream:
        _check_magic(stream, path)
        with _damage_reported(path):
            size = path.stat().st_size
            for record in StreamReader(stream, validate_crcs=True, record_size_limit=size).records:
                if isinstance(record, Message) and "recording" not in found.metadata:
                    break  # ours stand first
                found.add(record, states, signals)
    _check_ours(found, path)
    return Content(found.attachments, found.metadata, tuple(found.times_ns), tuple(found.states), tuple(found.signals))


class _Found:
    """What has been read of a file so far."""

    def __init__(self) -> None:
        self.attachments: dict[str, bytes] = {}
        self.metadata: dict[str, dict[str, Any]] = {}
        self.topics: dict[int, str] = {}
        self.times_ns: list[int] = []
        self.states: list[Any] = []
        self.signals: list[Any] = []

    def add(self, record: McapRecord, states: str, signals: str) -> None:
        if isinstance(record, Attachment):
            self.attachments[record.name] = record.data
        elif isinstance(record, Metadata) and record.name.startswith(_OURS):
            values = {key: json.loads(value) for key, value in record.metadata.items()}
            self.metadata[record.name.removeprefix(_OURS)] = values
        elif isinstance(record, Channel):
            self.topics[record.id] = record.topic
        elif isinstance(record, Message) and self.topics[record.channel_id] == states:
            self.times_ns.append(record.log_time)
            self.states.append(json.loads(record.data))
        elif isinstance(record, Message) and self.topics[record.channel_id] == signals:
            self.signals.append(json.loads(record.data))


@contextmanager
def _opened(path: Path) -> Iterator[IO[bytes]]:
    try:
        stream = path.open("rb")
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise RecordingError("cannot read the recording", where=path, value=reason, hint="check the path") from None
    with stream:
        yield stream


def _check_magic(stream: IO[bytes], path: Path) -> None:
    start = stream.read(len(_MAGIC))
    stream.seek(0)
    if not start:
        raise RecordingError("the file is empty", where=path, hint="copy or import the recording again")
    if start != _MAGIC:
        hint = "import tables of motion with: taskgist import MAPPING.toml -o RECORDING.mcap"
        raise RecordingError("not an MCAP file", where=path, value=start, hint=hint)


@contextmanager
def _damage_reported(path: Path) -> Iterator[None]:
    try:
        yield
    except _DAMAGE as problem:
        hint = "copy it again from where it came from, or import it again"
        value = f"{type(problem).__name__}: {problem}"
        raise RecordingError("the file is cut off or damaged", where=path, value=value, hint=hint) from None


def _check_ours(found: _Found, path: Path) -> None:
    if "recording" not in found.metadata:
        topics = ", ".join(sorted(found.topics.values())) or "none"
        hint = "taskgist reads recordings that it has written; import other motion as tables (docs/import.md)"
        problem = "an MCAP file, but not a recording of taskgist"
        raise RecordingError(problem, where=path, value=f"topics: {topics}", hint=hint)
    version = found.metadata["recording"].get("format")
    if not isinstance(version, int) or version > FORMAT:
        hint = f"this taskgist reads formats up to {FORMAT}: install a newer one"
        raise RecordingError("the recording is of a newer format", where=path, field="format", value=version, hint=hint)
