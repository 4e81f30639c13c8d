"""Recordings from strangers: what lies, contradicts itself or is without bound is refused by name, in little memory."""

from __future__ import annotations

import io
import json
import os
import shutil
import struct
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import lz4.frame
import pytest
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from taskgist.errors import InputError, RecordingError
from taskgist.recording import Recording, read, write
from taskgist.recording.container import MAGIC
from taskgist.settings import Limits
from taskgist.world import Scene
from tests.cli.tampering import tampered
from tests.importing.recordings import LABEL, recording, room

Change = Callable[[dict[str, dict[str, Any]]], object]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "handover.mcap"
    write(recording(label=LABEL), path)
    return path


def refusal(path: Path, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        read(path, **options)
    text = str(caught.value)
    assert text.startswith(str(path))
    return text.removeprefix(str(path))


# --- Metadata.


def without(record: str, field: str) -> Change:
    return lambda metadata: metadata[f"taskgist.{record}"].pop(field)


def with_value(record: str, field: str, value: Any) -> Change:
    return lambda metadata: metadata[f"taskgist.{record}"].update({field: value})


METADATA: list[tuple[Change, str]] = [
    (with_value("provenance", "notes", 3), "taskgist.provenance: notes: must be a list of texts (got 3)"),
    (with_value("provenance", "fit", ["x"]), "taskgist.provenance: fit: must be reports by agent (got ['x'])"),
    (with_value("provenance", "simulated", "no"), "taskgist.provenance: simulated: must be true or false"),
    (with_value("provenance", "sauce", ""), "taskgist.provenance: sauce: no such field; did you mean 'source'?"),
    (with_value("provenance", "fit", {"P1": float("nan")}), "taskgist.provenance: fit: NaN is no number"),
    (with_value("recording", "signals", ["grip"]), "taskgist.recording: signals: must be units by name"),
    (with_value("recording", "signals", {"grip": 3}), "taskgist.recording: signals: must be units by name"),
    (with_value("recording", "name", 7), "taskgist.recording: name: must be a text (got 7)"),
    (with_value("recording", "format", "1"), "format: the recording is of a newer format (got '1')"),
    (with_value("label", "how", None), "taskgist.label: how: must be a text"),
    (with_value("label", "start_s", "1_0"), "start_s: must be a time (got '1_0')"),
    (with_value("label", "task", ["a", "b"]), "task: must be a name (got ['a', 'b'])"),
    (without("label", "task"), "taskgist.label: task: is missing"),
    (without("recording", "name"), "taskgist.recording: name: is missing"),
]


@pytest.mark.parametrize(("change", "expected"), METADATA)
def test_metadata_of_a_wrong_kind(change: Change, expected: str, file: Path, tmp_path: Path) -> None:
    assert expected in refusal(tampered(file, tmp_path / "changed.mcap", metadata=change))


@pytest.mark.parametrize(
    ("record", "field"), [("label", "how"), ("provenance", "fit"), ("provenance", "source"), ("recording", "joints")]
)
def test_what_may_be_left_out(record: str, field: str, file: Path, tmp_path: Path) -> None:
    path = tampered(file, tmp_path / "changed.mcap", metadata=without(record, field))
    assert read(path).digest == read(file).digest


def test_names_of_others_are_cleaned(file: Path, tmp_path: Path) -> None:
    path = tampered(
        file, tmp_path / "changed.mcap", metadata=with_value("label", "task", "  gi\u001b\u202ev\u0065\u0301 ")
    )
    label = read(path).label
    assert label
    assert label.task == "giv\u00e9"


# --- Messages.


def with_data(data: Callable[[dict[str, Any]], bytes], frame: int = 3) -> Callable[[str, int, Any], None]:
    def change(topic: str, number: int, message: Any) -> None:
        if (topic, number) == ("/taskgist/state", frame):
            message.data = data(json.loads(message.data))

    return change


def with_fields(**fields: Any) -> Callable[[str, int, Any], None]:
    return with_data(lambda state: json.dumps(state | fields).encode())


POSE = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
BOX = {"cup": POSE, "box": POSE}
MESSAGES: list[tuple[Callable[[str, int, Any], None], str]] = [
    (with_fields(objects=BOX | {"box": POSE[:6]}), "objects.box: 7 numbers are expected"),
    (with_fields(objects=BOX | {"box": [float("nan"), *POSE[1:]]}), "objects.box: is no finite number (got nan)"),
    (with_fields(objects=BOX | {"box": [float("inf"), *POSE[1:]]}), "objects.box: is no finite number (got inf)"),
    (with_fields(objects=BOX | {"cup": ["1_0", *POSE[1:]]}), "objects.cup: is no finite number (got '1_0')"),
    (with_fields(objects=BOX | {"cup": [True, *POSE[1:]]}), "objects.cup: is no finite number (got True)"),
    (with_fields(objects=BOX | {"cup": [10**400, *POSE[1:]]}), "objects.cup: is no finite number"),
    (with_fields(objects=BOX | {"cup": dict.fromkeys("abcdefg", 1)}), "objects.cup: 7 numbers are expected"),
    (with_fields(objects={"cup": POSE}), "objects.box: is missing"),
    (with_fields(agents={}), "agents.P1.base: is missing"),
    (with_fields(agents=3), "agents.P1.base: is missing"),
    (with_fields(untracked="box"), "untracked: must be a list of names (got 'box')"),
    (with_fields(untracked=["vase"]), "no object, agent or part 'vase'"),
    (with_fields(untracked=[["box"]]), "no object, agent or part"),
    (with_data(lambda _: b"[1, 2]"), "no JSON object"),
    (with_data(lambda _: b"{"), "not JSON"),
    (with_data(lambda _: b'{"objects": {}, "objects": {}}'), "'objects' is given twice"),
    (with_data(lambda _: b'{"untracked":' * 90_000), "nested deeper than"),
]


@pytest.mark.parametrize(("change", "expected"), MESSAGES)
def test_states_that_do_not_fit(change: Any, expected: str, file: Path, tmp_path: Path) -> None:
    text = refusal(tampered(file, tmp_path / "changed.mcap", message=change))
    assert text.startswith(": /taskgist/state, frame 3: ")
    assert expected in text


def test_numbers_without_a_place(file: Path, tmp_path: Path) -> None:
    far = with_fields(objects=BOX | {"box": [1e300, *POSE[1:]]})
    assert "beyond 1,000,000 metres or radians" in refusal(tampered(file, tmp_path / "far.mcap", message=far))


def late(_topic: str, number: int, message: Any) -> None:
    message.log_time = 2**64 - 5 + number


def test_times_without_end(file: Path, tmp_path: Path) -> None:
    assert "times are too large" in refusal(tampered(file, tmp_path / "late.mcap", message=late))


# --- Attachments.


def with_attachments(source: Path, target: Path, *added: tuple[str, bytes]) -> Path:
    content = make_reader(io.BytesIO(source.read_bytes()))
    with target.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        for name, data in [*((each.name, each.data) for each in content.iter_attachments()), *added]:
            writer.add_attachment(0, 0, name, "", data)
        for record in content.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        channel = writer.register_channel("/taskgist/state", "json", 0)
        for _, _, message in content.iter_messages(topics=["/taskgist/state"]):
            writer.add_message(channel, message.log_time, message.data, message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped
    return target


@pytest.mark.parametrize("name", ["", "a\0b", "x\x1b[2J", "\u202egnp.x"])
def test_names_that_nobody_gives(name: str, file: Path, tmp_path: Path) -> None:
    text = refusal(with_attachments(file, tmp_path / "out.mcap", ("scene/" + name, b"x")))
    assert "attachment: an attachment without a name, or with control characters in it" in text
    assert "\x1b" not in text


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "..\\x", "C:/x"])
def test_names_lead_nowhere(name: str, file: Path, tmp_path: Path) -> None:
    """They are keys among the attachments: nothing is opened or written by such a name, and what it holds is kept."""
    recorded = read(with_attachments(file, tmp_path / "out.mcap", ("scene/" + name, b"root:x")))
    assert recorded.scene.bundle[name] == b"root:x"
    assert recorded.digest != read(file).digest


def test_a_model_beside_the_scenes_folder(tmp_path: Path) -> None:
    """The scene of a user may name ``../models/room.xml``; the recording holds that file, and is read anywhere."""
    for folder in ("models", "scenes"):
        (tmp_path / folder).mkdir()
    world = room()
    (tmp_path / "models" / "room.xml").write_bytes(world.bundle["room.xml"])
    text = world.bundle["scene.toml"].decode().replace("room.xml", "../models/room.xml")
    (tmp_path / "scenes" / "scene.toml").write_text(text, encoding="utf-8")
    beside = Scene.load(tmp_path / "scenes" / "scene.toml")
    write(Recording(beside, recording().times_s, recording().qpos), tmp_path / "beside.mcap")
    shutil.rmtree(tmp_path / "models")
    assert read(tmp_path / "beside.mcap").scene.bundle == beside.bundle
    assert "../models/room.xml" in beside.bundle


def test_attachments_that_stand_twice(file: Path, tmp_path: Path) -> None:
    path = with_attachments(file, tmp_path / "twice.mcap", ("scene/scene.toml", b""))
    assert "attachment scene/scene.toml: stands in the file twice" in refusal(path)


def test_attachments_together_are_limited(file: Path, tmp_path: Path) -> None:
    added = [(f"scene/{number}.obj", bytes(200_000)) for number in range(6)]
    path = with_attachments(file, tmp_path / "large.mcap", *added)
    text = refusal(path, limits=Limits(bundle_bytes=1_000_000))
    assert "attachments beneath scene/: is too large" in text
    assert "at most 1,000,000 bytes are read (setting limits.bundle_bytes)" in text


# --- Sizes that are declared.


def with_chunk(source: Path, target: Path, chunk: Chunk) -> Path:
    """A recording with another chunk in place of its own, and nothing behind it."""
    builder = RecordBuilder()
    for record in StreamReader(io.BytesIO(source.read_bytes()), emit_chunks=True).records:
        if isinstance(record, Chunk):
            break
        record.write(builder)
    chunk.write(builder)
    end = struct.pack("<BQI", Opcode.DATA_END, 4, 0) + struct.pack("<BQQQI", Opcode.FOOTER, 20, 0, 0, 0)
    target.write_bytes(MAGIC + builder.end() + end + MAGIC)  # type: ignore[no-untyped-call]
    return target


def chunk_of(compression: str, packed: bytes, declared: int) -> Chunk:
    return Chunk(
        compression, packed, message_end_time=0, message_start_time=0, uncompressed_crc=0, uncompressed_size=declared
    )


ZEROS = bytes(64 * 2**20)
STREAMED = zstandard.ZstdCompressor(write_content_size=False).compress(ZEROS)
BOMBS: list[tuple[str, Chunk]] = [
    ("a chunk, unpacked,: is too large", chunk_of("zstd", zstandard.compress(ZEROS), len(ZEROS))),
    ("unpacks to more than it declares", chunk_of("zstd", zstandard.compress(ZEROS), 1000)),
    ("cut off or damaged", chunk_of("zstd", STREAMED, 1000)),
    ("a chunk, unpacked,: is too large", chunk_of("lz4", lz4.frame.compress(ZEROS), len(ZEROS))),
    ("a chunk of 1,001 bytes declares 1,000", chunk_of("lz4", lz4.frame.compress(ZEROS), 1000)),
    ("a record of no kind in a chunk", chunk_of("zstd", zstandard.compress(ZEROS[: 2**20]), 2**20)),
    ("a chunk of 4 bytes declares 8", chunk_of("", b"1234", 8)),
    ("a chunk is packed as 'rar'", chunk_of("rar", b"1234", 8)),
    ("a chunk, unpacked,: is too large", chunk_of("", b"", 2**63)),
    ("a record of 18,446,744,073,709,551,615 bytes in a chunk", chunk_of("", b"\x05" + b"\xff" * 8, 9)),
]


@pytest.mark.parametrize(("expected", "chunk"), BOMBS)
def test_chunks_that_lie(expected: str, chunk: Chunk, file: Path, tmp_path: Path) -> None:
    path = with_chunk(file, tmp_path / "bomb.mcap", chunk)
    tracemalloc.start()
    try:
        text = refusal(path, limits=Limits(chunk_bytes=2**20))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert expected in text
    assert most < 16 * 2**20


@pytest.mark.parametrize("length", [2**64 - 1, 2**63, 2**40, 10**6])
def test_records_that_reach_beyond_the_file(length: int, file: Path) -> None:
    file.write_bytes(MAGIC + struct.pack("<BQ", Opcode.ATTACHMENT, length) + b"x" * 100)
    assert f"a record of {length:,} bytes begins at byte 8 of 117" in refusal(file)


def test_texts_that_reach_beyond_their_record(file: Path) -> None:
    content = struct.pack("<I", 2**32 - 1) + b"taskgist.recording"
    file.write_bytes(MAGIC + struct.pack("<BQ", Opcode.METADATA, len(content)) + content)
    assert "cut off or damaged" in refusal(file)


def test_frames_in_memory_are_limited(file: Path) -> None:
    text = refusal(file, limits=Limits(frame_bytes=3_000))
    assert "/taskgist/state, frame 3: more than 3 frames" in text
    assert "(setting limits.frame_bytes)" in text


def test_messages_are_limited(file: Path) -> None:
    text = refusal(file, limits=Limits(message_bytes=1_000))
    assert "is too large" in text
    assert "(setting limits.message_bytes)" in text


@pytest.mark.parametrize(
    "kind", [Opcode.STATISTICS, Opcode.CHUNK_INDEX, Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX]
)
def test_records_of_the_summary_are_limited(kind: Opcode, file: Path) -> None:
    """A sparse file, of which no more is read than is there."""
    with file.open("r+b") as stream:
        stream.seek(-len(MAGIC) - 29, io.SEEK_END)
        stream.write(struct.pack("<BQ", kind, 5 * 2**30))
        stream.truncate(stream.tell() + 5 * 2**30)
        stream.seek(0, io.SEEK_END)
        stream.write(struct.pack("<BQQQI", Opcode.FOOTER, 20, 0, 0, 0) + MAGIC)
    assert "a record of its summary: is too large (got '5,368,709,120 bytes')" in refusal(file)


def test_checksums_are_verified(file: Path) -> None:
    """One bit anywhere: the file is refused, or reads as before."""
    content, digest = file.read_bytes(), read(file).digest
    assert zlib.crc32(content)
    refused = 0
    for place in range(len(MAGIC), len(content), len(content) // 60):
        file.write_bytes(content[:place] + bytes([content[place] ^ 16]) + content[place + 1 :])
        try:
            assert read(file).digest == digest
        except InputError:
            refused += 1
    assert refused >= 58


# --- Files that are none.


def test_pipes_devices_and_folders(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    (tmp_path / "itself.mcap").symlink_to(tmp_path / "itself.mcap")
    for path, kind in [
        (tmp_path / "pipe.mcap", "it is a pipe"),
        (Path("/dev/zero"), "it is a device"),
        (tmp_path, "it is a folder"),
        (tmp_path / "itself.mcap", "symbolic links"),
    ]:
        with pytest.raises(RecordingError, match=kind):
            read(path)
    with pytest.raises(RecordingError, match=r"a\\0b: cannot be read"):
        read("a\0b")
