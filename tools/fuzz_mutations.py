"""How the fuzzer spoils what has a structure: documents, archives, recordings and databases; and what fits which file.

A mutation is a function of a seeded random generator and a file's content. Those of bytes and text are in
``fuzz_tokens``.
"""

from __future__ import annotations

import gzip
import hashlib
import io
import json
import random
import re
import sqlite3
import tempfile
import warnings
import zipfile
import zlib
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.reader import make_reader
from mcap.records import Attachment, Chunk, Metadata
from mcap.writer import CompressionType, Writer

from tools.fuzz_tokens import (
    LARGEST,
    OF_BYTES,
    OF_TEXT,
    Mutation,
    deepened,
    element_moved,
    flipped,
    line_moved,
    number_replaced,
    quoted_replaced,
    word_replaced,
)

# --- JSON documents.

VALUES: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 2**63, 10**400, 1.5, -0.0, 1e308, float("nan"), float("inf"), "", "x", "1"),
    *("\x1b[31mred", "\x9b", "\x00", "\ud800", "a" * 100_000, [], [[]], {}, {"a": 1}, [None], ["x", 1], {"": None}),
    *(
        [0] * 1000,
        {"value": None},
        {"value": {"value": 1}},
        "show",
        "  show  ",
        "P1",
        "Head_Effort",
        "../x",
        "/etc/passwd",
    ),
)
DEEP = object()
"""Stands for something very deep, which no value of Python can be."""


def json_changed(rng: random.Random, data: bytes) -> bytes:
    """A value of a document is another, missing, twice, under another name, or very deep."""
    document = json.loads(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        document = _changed(rng, document)
    text = json.dumps(document, ensure_ascii=rng.random() < 0.5, default=lambda _: "\x00deep\x00")
    depth = rng.choice((200, 5_000, 100_000))
    text = text.replace('"\\u0000deep\\u0000"', "[" * depth + "]" * depth)
    return text.encode("utf-8", "surrogatepass")


def _changed(rng: random.Random, document: Any) -> Any:
    inner = isinstance(document, dict | list) and document
    if inner and rng.random() < 0.85:
        keys = list(document) if isinstance(document, dict) else range(len(document))
        key = rng.choice(keys)
        if rng.random() < 0.15:
            if isinstance(document, dict):
                document[rng.choice((*map(str, keys), "new", "", "\x1b[0m", "a" * 1000))] = document.pop(key)
            else:
                document.append(document.pop(key)) if rng.random() < 0.5 else document.pop(key)
        else:
            document[key] = _changed(rng, document[key])
        return document
    return rng.choice((*VALUES, DEEP, DEEP))


# --- Archives: NPZ, compressed documents.

PIECE, PIECES = 2**24, 192
"""What unpacks to 3 GiB is made of so many pieces of zeros."""


def array_changed(rng: random.Random, data: bytes) -> bytes:
    """An array's header, or its entry in the archive, says something else; or it unpacks to very much."""
    if not data.startswith(b"PK"):
        return _header_changed(rng, data)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice(sorted(content) or ["x.npy"])
    what = rng.randrange(6)
    if what == 0:
        content.pop(name, None)
    elif what == 1:
        content[rng.choice(("unused.npy", "t.npy", "body.npy", "", "../x.npy", "\x1b[31m.npy", "no array"))] = content[
            name
        ]
    elif what == 2:
        content[name] = content[rng.choice(sorted(content))]
    elif what == 3:
        content[name] = flipped(rng, content[name])
    else:
        content[name] = _header_changed(rng, content[name])
    stream = io.BytesIO()
    with zipfile.ZipFile(
        stream, "w", rng.choice((zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_STORED))
    ) as packed:
        for key, value in content.items():
            packed.writestr(key, value)
    archived = stream.getvalue()
    return _directory_changed(rng, archived) if rng.random() < 0.3 else archived


def _header_changed(rng: random.Random, data: bytes) -> bytes:
    """The header of an NPY file, of which the length stays right."""
    start = data.find(b"{'descr'")
    end = data.find(b"\n", start)
    if start < 0 or end < 0:
        return flipped(rng, data)
    header = data[start:end].decode("latin-1")
    old, new = rng.choice(
        (
            (r"\(.*?\)", "()"),
            (r"\(.*?\)", f"({rng.choice((0, 1, 7, 10**6, 10**9, 10**12, 2**62, -1))}, 3)"),
            (r"\(\d+", f"({rng.choice((0, 1, 2, 10**9, 10**15, -5))}"),
            (r"\(", "(0, "),
            (
                r"'[<|]\w+'",
                f"'{rng.choice(('|O', '<f4', '<c16', '<U999', '|V0', '|S0', '<M8[ns]', '<i8', '|b1', '>f8'))}'",
            ),
            (r"False", "True"),
            (r"'descr'", "'desc'"),
            (r"\{", "[" * 90),
            (r"\(.*?\)", "(" * 200),
        )
    )
    changed = re.sub(old, new, header, count=1)[: len(header)]
    return data[:start] + changed.ljust(len(header)).encode("latin-1") + data[end:]


def _directory_changed(rng: random.Random, data: bytes) -> bytes:
    """A field of an entry in the archive's directory, or of its local header, is another."""
    places = [hit.start() for hit in re.finditer(b"PK\x01\x02|PK\x03\x04", data)]
    at = rng.choice(places)
    offset, size = rng.choice(((6, 2), (8, 2), (10, 2), (16, 4), (18, 4), (20, 4), (22, 4), (24, 4), (28, 2), (42, 4)))
    spoiled = bytearray(data)
    spoiled[at + offset : at + offset + size] = rng.choice((rng.randbytes(size), b"\xff" * size, b"\x00" * size))
    return bytes(spoiled)


def array_swollen(rng: random.Random, data: bytes) -> bytes:
    """An archive with one more array, which unpacks to 3 GiB."""
    header = io.BytesIO()
    shape = (PIECE * PIECES // 8,)
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": shape})
    packer = zlib.compressobj(wbits=-15)
    first = packer.compress(header.getvalue()) + packer.flush(zlib.Z_FULL_FLUSH)
    piece = packer.compress(bytes(PIECE)) + packer.flush(zlib.Z_FULL_FLUSH)
    stream = io.BytesIO(data if data.startswith(b"PK") else b"")
    with zipfile.ZipFile(stream, "a") as archive, warnings.catch_warnings(action="ignore"):
        entry = zipfile.ZipInfo(rng.choice(("body.npy", "levels.npy", "unused.npy", "extra.npy")))
        archive.writestr(entry, first + piece * PIECES + packer.flush())
        entry.compress_type, entry.file_size = zipfile.ZIP_DEFLATED, len(header.getvalue()) + PIECE * PIECES
    return stream.getvalue()


def packed_json_changed(rng: random.Random, data: bytes) -> bytes:
    """A compressed document holds something else, or unpacks to very much."""
    spoil = rng.choice((json_changed, json_changed, deepened, number_replaced, word_replaced))
    return gzip.compress(_digest_mended(spoil(rng, gzip.decompress(data))), mtime=0)


def _digest_mended(text: bytes) -> bytes:
    """A document that says its own digest says it rightly, so that the rest of it is looked at, too."""
    try:
        document = json.loads(text)
        document.pop("digest")
        content = json.dumps(document, ensure_ascii=False, sort_keys=True)
        document["digest"] = hashlib.sha256(content.encode("utf-8", "surrogatepass")).hexdigest()[:16]
        return json.dumps(document).encode()
    except Exception:  # it is none
        return text


def packed_json_swollen(_rng: random.Random, data: bytes) -> bytes:
    """A compressed document behind 3 GiB of blanks."""
    return gzip.compress(b" " * PIECE) * PIECES + data


# --- Recordings.


def recording_swollen(rng: random.Random, data: bytes) -> bytes:
    """A recording with a chunk that unpacks to 3 GiB, somewhere between its records."""
    builder = RecordBuilder()
    Chunk("zstd", zstandard.compress(bytes(PIECE)) * PIECES, 1, 0, 0, PIECE * PIECES).write(builder)
    place = rng.choice([end for _, end in _places(data)][:20] or [len(data)])
    chunk: bytes = builder.end()  # type: ignore[no-untyped-call]  # mcap leaves it untyped
    return data[:place] + chunk + data[place:]


def record_changed(rng: random.Random, data: bytes) -> bytes:
    """A record is of another kind or length, holds another number, stands elsewhere, not at all, or many times."""
    start, end = rng.choice(_places(data))
    record, others = data[start:end], data[:start] + data[end:]
    what = rng.randrange(6)
    if what == 0:
        return data[:start] + bytes([rng.choice((*range(1, 16), 0, 128))]) + data[start + 1 :]
    if what == 1:
        length = rng.choice((0, 1, len(record) - 8, len(record) - 10, 2**31, 2**40, 2**63, 2**64 - 1))
        return data[: start + 1] + max(0, length).to_bytes(8, "little") + data[start + 9 :]
    if what == 2 and end - start > 9:
        at, size = rng.randrange(start + 9, end), rng.choice((1, 2, 4, 8))
        number = rng.choice((0, 1, 2**31 - 1, 2**63, rng.getrandbits(64), 2**64 - 1)) % (1 << 8 * size)
        return (data[:at] + number.to_bytes(size, "little") + data[at + size :])[: len(data)]
    if what == 3:
        return data[:start] + record * rng.choice((0, 2, min(50_000, LARGEST // len(record)))) + data[end:]
    if what == 4:
        at = rng.choice([start for start, _ in _places(others)])
        return others[:at] + record + others[at:]
    other_start, other_end = rng.choice(_places(data))
    return data[:start] + data[other_start:other_end] + data[end:]


def _places(data: bytes) -> list[tuple[int, int]]:
    """Where each record of a recording begins and ends: its kind, its length, and so many bytes."""
    found, at = [], 8
    while at + 9 <= len(data):
        end = at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        found.append((at, end))
        at = end
    return found


def recording_rebuilt(rng: random.Random, data: bytes) -> bytes:
    """A recording whose records are right as such, and one or more of which hold something else."""
    reader = make_reader(io.BytesIO(data))
    messages: list[Any] = list(reader.iter_messages())
    metadata, attachments = list(reader.iter_metadata()), list(reader.iter_attachments())
    for _ in range(rng.choice((1, 1, 2))):
        rng.choice((_metadata_changed, _metadata_changed, _attachments_changed, _messages_changed))(
            rng, metadata, attachments, messages
        )
    compression = rng.choice((CompressionType.ZSTD, CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE))
    return _recording(messages, metadata, attachments, compression, rng.choice((1, 1024, 2**24)))


def copied(data: bytes, add: Callable[[Writer], None]) -> bytes:
    """A recording with what it holds, and more."""
    reader = make_reader(io.BytesIO(data))
    return _recording(
        list(reader.iter_messages()), list(reader.iter_metadata()), list(reader.iter_attachments()), more=add
    )


def _recording(
    messages: Iterable[Any],
    metadata: Iterable[Metadata],
    attachments: Iterable[Attachment],
    compression: CompressionType = CompressionType.ZSTD,
    chunk_size: int = 2**20,
    more: Callable[[Writer], None] = lambda _: None,
) -> bytes:
    stream = io.BytesIO()
    writer = Writer(stream, chunk_size=chunk_size, compression=compression)
    writer.start(profile="", library="taskgist")
    for attached in attachments:
        writer.add_attachment(0, 0, attached.name, attached.media_type, attached.data)
    for record in metadata:
        writer.add_metadata(record.name, record.metadata)
    channels: dict[int, int] = {}
    for schema, channel, message in messages:
        if channel.id not in channels:
            schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
            channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, schema_id)
        writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time)
    more(writer)
    writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped
    return stream.getvalue()


def _metadata_changed(rng: random.Random, metadata: list[Metadata], _attachments: Any, _messages: Any) -> None:
    if not metadata:
        return
    at = rng.randrange(len(metadata))
    record = metadata[at]
    values = dict(record.metadata)
    what = rng.randrange(5)
    if what == 0:
        metadata.pop(at)
    elif what == 1:
        metadata.append(record)
    elif what == 2:
        metadata[at] = Metadata(name=rng.choice(("taskgist.label", "taskgist.", "x", "\x1b[31m")), metadata=values)
    else:
        key = rng.choice(sorted(values) or ["x"])
        old = values.get(key, "null").encode()
        spoil = rng.choice((json_changed, json_changed, json_changed, word_replaced, number_replaced, deepened))
        values[rng.choice((key, key, key, key, "new"))] = spoil(rng, old).decode("utf-8", "replace")
        metadata[at] = Metadata(name=record.name, metadata=values)


def _attachments_changed(rng: random.Random, _metadata: Any, attachments: list[Attachment], _messages: Any) -> None:
    if not attachments:
        return
    at = rng.randrange(len(attachments))
    old = attachments[at]
    what = rng.randrange(6)
    name, data = old.name, old.data
    if what == 0:
        attachments.pop(at)
        return
    if what == 1:
        attachments.append(replace(old, name=rng.choice((old.name, "x", "\x1b[0m", "scene/"))))
        return
    if what == 2:
        name = rng.choice(
            ("../x", "/etc/passwd", "scene/../../x", "scene//etc/passwd", "scene/\x00", "scene/\x1b[31m.xml")
        )
    elif what == 3:
        data = rng.choice((b"", bytes(1000), data * 3))
    else:
        data = rng.choice((number_replaced, word_replaced, quoted_replaced, element_moved, line_moved, deepened))(
            rng, data
        )
    attachments[at] = replace(old, name=name, data=data)


def _messages_changed(rng: random.Random, _metadata: Any, _attachments: Any, messages: list[Any]) -> None:
    if not messages:
        return
    at = rng.randrange(len(messages))
    _, _, message = messages[at]
    what = rng.randrange(7)
    if what == 0:
        messages.pop(at)
    elif what == 1:
        messages.insert(at, messages[at])
    elif what == 2:
        message.log_time = rng.choice((0, 1, 2**63, 2**64 - 1, message.log_time + 10**18))
    elif what == 3:
        message.data = rng.choice((b"", b"null", b"[]", b"\xff", b"[" * 100_000, b" " * 2**20))
    elif what == 4:
        del messages[: rng.choice((1, len(messages) // 2, len(messages)))]
    else:
        message.data = json_changed(rng, message.data)


# --- Knowledge.


def database_changed(rng: random.Random, data: bytes) -> bytes:
    """A database whose rows, tables or columns hold something else, are missing, or are others'."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "knowledge.db"
        path.write_bytes(data)
        with closing(sqlite3.connect(path, isolation_level=None)) as connection:
            for _ in range(rng.choice((1, 1, 2))):
                _rows_changed(rng, connection)
        return path.read_bytes()


def _rows_changed(rng: random.Random, connection: sqlite3.Connection) -> None:
    named = connection.execute("select name from sqlite_master where type = 'table'").fetchall()
    table = rng.choice(sorted(name for (name,) in named))
    columns = [row[1] for row in connection.execute(f'pragma table_info("{table}")')]
    column = rng.choice(columns)
    what = rng.randrange(8)
    if what == 0:
        connection.execute(f'drop table "{table}"')
    elif what == 1:
        connection.execute(f'alter table "{table}" rename column "{column}" to other')
    elif what == 2:
        connection.execute(f'delete from "{table}"')
    elif what == 3:  # as it is, but without its constraints
        _loosened(connection, table)
        connection.execute(f'update "{table}" set "{column}" = ?', (rng.choice((None, 1, 1.5, b"\xff\x00", "", "x")),))
    elif what == 4:
        _loosened(connection, table)
        connection.execute(f'insert into "{table}" select * from "{table}"')
    else:
        documents = [row[0] for row in connection.execute(f'select "{column}" from "{table}" limit 3')]
        if documents:
            spoil = rng.choice((json_changed, json_changed, json_changed, word_replaced, deepened))
            new = spoil(rng, str(documents[0]).encode()).decode("utf-8", "replace")
            _loosened(connection, table)
            connection.execute(f'update "{table}" set "{column}" = ? where "{column}" = ?', (new, documents[0]))


def _loosened(connection: sqlite3.Connection, table: str) -> None:
    connection.execute(f'create table loose as select * from "{table}"')
    connection.execute(f'drop table "{table}"')
    connection.execute(f'alter table loose rename to "{table}"')


# --- All of them, and which fit which file.

OF_SUFFIX: Mapping[str, Mapping[str, Mutation]] = {
    ".json": {"json_changed": json_changed, **OF_TEXT},
    ".npz": {"array_changed": array_changed, "array_swollen": array_swollen},
    ".npy": {"array_changed": array_changed},
    ".gz": {"packed_json_changed": packed_json_changed, "packed_json_swollen": packed_json_swollen},
    ".mcap": {
        "recording_rebuilt": recording_rebuilt,
        "record_changed": record_changed,
        "recording_swollen": recording_swollen,
    },
    ".db": {"database_changed": database_changed},
    ".stl": {},
}
SWOLLEN_SHARE = 0.03
"""How often something that unpacks to gibibytes is tried, beside what else fits: each takes seconds if it works."""
BYTES_SHARE = 0.2
"""How often bytes are spoiled; they find least."""


def mutated(rng: random.Random, name: str, data: bytes) -> tuple[bytes, tuple[str, ...]]:
    """A spoiled file, and by which mutations."""
    fitting = OF_SUFFIX.get(Path(name).suffix, OF_TEXT)
    used = []
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        chosen = OF_BYTES if not fitting or rng.random() < BYTES_SHARE else fitting
        names = sorted(chosen)
        mutation = rng.choices(names, [SWOLLEN_SHARE if name.endswith("_swollen") else 1.0 for name in names])[0]
        try:
            data = chosen[mutation](rng, data)
        except Exception:  # what is spoiled already cannot always be taken apart
            mutation, data = "flipped", flipped(rng, data)
        used.append(mutation)
        if mutation.endswith("_swollen"):
            break  # what is done to it next would unpack it here
    return data, tuple(used)
