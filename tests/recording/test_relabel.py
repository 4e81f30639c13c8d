"""A label is changed in place: all else that a file holds stays, byte for byte, whoever wrote it."""

from __future__ import annotations

import dataclasses
import io
import json
import threading
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import NonSeekingReader, SeekingReader, make_reader
from mcap.records import Chunk, Statistics
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType, Writer

from taskgist.errors import LabelError, RecordingError
from taskgist.recording import Label, Recording, read, relabel, write
from tests.importing.recordings import LABEL, recording

OTHER = dataclasses.replace(LABEL, task="show, with a longer name", how="by hand: task")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "handover.mcap"
    write(recording(label=LABEL), path)
    return path


def foreign(source: Path, target: Path, *, labelled: bool, **options: Any) -> None:
    """A recording to which another program has added a camera, files and notes of its own."""
    content = make_reader(io.BytesIO(source.read_bytes()))
    with target.open("wb") as stream:
        writer = Writer(stream, chunk_size=5_000, enable_data_crcs=True, **options)
        writer.start(profile="ros2", library="another program")
        writer.add_attachment(5, 6, "calibration.bin", "application/x", bytes(range(256)) * 20)
        for file in content.iter_attachments():
            writer.add_attachment(file.create_time, file.log_time, file.name, file.media_type, file.data)
        for record in content.iter_metadata():
            if labelled or record.name != "taskgist.label":
                writer.add_metadata(record.name, record.metadata)
        writer.add_metadata("site", {"room": "7"})
        camera = writer.register_channel(
            "/camera", "raw", writer.register_schema("picture", "raw", b"xyz"), {"fps": "3"}
        )
        channels: dict[int, int] = {}
        for number, (schema, channel, message) in enumerate(content.iter_messages()):
            if channel.id not in channels:
                assert schema
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, schema_id)
            writer.add_message(
                channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence
            )
            writer.add_message(camera, message.log_time + 3, bytes([number]) * 999, message.publish_time + 9, number)
        writer.add_attachment(7, 8, "late.bin", "x", b"late")
        writer.add_metadata("late", {"a": "b"})
        writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped


def all_but_the_label(path: Path) -> dict[str, Any]:
    """What a file holds for three readers of the library that defines the format, every checksum verified."""
    data = path.read_bytes()
    seeking = SeekingReader(io.BytesIO(data), validate_crcs=True)
    streaming = NonSeekingReader(io.BytesIO(data), validate_crcs=True)
    chunks = [
        (record.data, record.compression)
        for record in StreamReader(io.BytesIO(data), emit_chunks=True, validate_crcs=True).records
        if isinstance(record, Chunk)
    ]
    header = seeking.get_header()
    return {
        "header": (header.profile, header.library),
        "chunks": chunks,
        "attachments": [dataclasses.astuple(each) for each in seeking.iter_attachments()],
        "metadata": [dataclasses.astuple(each) for each in seeking.iter_metadata() if each.name != "taskgist.label"],
        "messages": [_everything(*each) for each in seeking.iter_messages()],
        "streamed": [_everything(*each) for each in streaming.iter_messages()],
    }


def _everything(schema: Any, channel: Any, message: Any) -> tuple[Any, ...]:
    return (dataclasses.astuple(schema), repr(channel), dataclasses.astuple(message))


def statistics(path: Path) -> Statistics:
    summary = make_reader(io.BytesIO(path.read_bytes())).get_summary()
    assert summary
    assert summary.statistics
    return summary.statistics


def labels_in(path: Path) -> list[dict[str, str]]:
    reader = make_reader(io.BytesIO(path.read_bytes()))
    return [record.metadata for record in reader.iter_metadata() if record.name == "taskgist.label"]


@pytest.mark.parametrize("labelled", [True, False])
@pytest.mark.parametrize("compression", list(CompressionType))
@pytest.mark.parametrize("use_chunking", [True, False])
def test_all_else_stays(
    file: Path, tmp_path: Path, *, labelled: bool, compression: CompressionType, use_chunking: bool
) -> None:
    path = tmp_path / "foreign.mcap"
    foreign(file, path, labelled=labelled, compression=compression, use_chunking=use_chunking)
    before, counted = all_but_the_label(path), statistics(path)
    assert relabel(path, lambda _: OTHER) == OTHER
    assert all_but_the_label(path) == before
    (record,) = labels_in(path)
    assert json.loads(record["task"]) == OTHER.task
    assert read(path).label == OTHER
    assert read(path).digest == read(file).digest
    added = 0 if labelled else 1
    assert statistics(path) == dataclasses.replace(counted, metadata_count=counted.metadata_count + added)


def test_a_file_without_indexes(file: Path, tmp_path: Path) -> None:
    path = tmp_path / "bare.mcap"
    options: dict[str, Any] = {"index_types": IndexType.NONE, "use_statistics": False, "use_summary_offsets": False}
    foreign(file, path, labelled=True, repeat_channels=False, repeat_schemas=False, **options)
    relabel(path, lambda _: OTHER)
    assert read(path).label == OTHER
    records = StreamReader(io.BytesIO(path.read_bytes()), validate_crcs=True).records
    assert [type(record).__name__ for record in records][-2:] == ["DataEnd", "Footer"]


def test_the_file_is_the_one_that_would_be_written(file: Path, tmp_path: Path) -> None:
    relabel(file, lambda _: OTHER)
    write(recording(label=OTHER), tmp_path / "anew.mcap")
    assert file.read_bytes() == (tmp_path / "anew.mcap").read_bytes()


def test_the_same_label_writes_nothing(file: Path) -> None:
    before = file.stat()
    assert relabel(file, lambda opened: opened.label or LABEL) == LABEL
    after = file.stat()
    assert (after.st_ino, after.st_mtime_ns) == (before.st_ino, before.st_mtime_ns)


def test_a_wrong_label_writes_nothing(file: Path) -> None:
    before = file.read_bytes()
    with pytest.raises(LabelError, match="outside"):
        relabel(file, lambda _: dataclasses.replace(LABEL, end_s=99.0))
    with pytest.raises(RecordingError, match="No such file"):
        relabel(file.with_name("none.mcap"), lambda _: LABEL)
    assert file.read_bytes() == before
    assert list(file.parent.iterdir()) == [file]


def test_two_at_once_lose_nothing(file: Path) -> None:
    """The second waits until the first is done, and changes what the first has written."""
    inside, others_turn = threading.Event(), threading.Event()

    def slow(opened: Recording) -> Label:
        inside.set()
        others_turn.wait(0.2)  # the second has begun, and must not have got in
        assert opened.label
        return dataclasses.replace(opened.label, task="show")

    def quick(opened: Recording) -> Label:
        others_turn.set()
        assert opened.label
        return dataclasses.replace(opened.label, end_s=0.12)

    first = threading.Thread(target=lambda: relabel(file, slow))
    first.start()
    inside.wait()
    relabel(file, quick)
    first.join()
    label = read(file).label
    assert label == dataclasses.replace(LABEL, task="show", end_s=0.12)
