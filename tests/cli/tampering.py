"""Recordings that taskgist would never write: its files with other metadata or messages."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mcap.reader import make_reader
from mcap.records import Message
from mcap.writer import Writer

Metadata = dict[str, dict[str, Any]]


def tampered(
    source: Path,
    target: Path,
    *,
    metadata: Callable[[Metadata], object] = lambda _: None,
    message: Callable[[str, int, Message], object] = lambda _topic, _number, _message: None,
) -> Path:
    """Copy a recording, with its metadata and messages changed in passing.

    Args:
        source: A recording.
        target: The file to write.
        metadata: Changes the records, by name, values parsed.
        message: Changes a message, told its topic and number.
    """
    content = source.read_bytes()
    with target.open("wb") as out:
        writer = Writer(out)
        writer.start(profile="", library="tampered")
        for attachment in make_reader(io.BytesIO(content)).iter_attachments():
            writer.add_attachment(0, 0, attachment.name, attachment.media_type, attachment.data)
        for name, record in _changed(content, metadata).items():
            writer.add_metadata(name, {key: json.dumps(value) for key, value in record.items()})
        channels: dict[int, int] = {}
        numbers: dict[str, int] = {}
        for schema, channel, each in make_reader(io.BytesIO(content)).iter_messages():
            if channel.id not in channels:
                assert schema is not None
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, schema_id)
            numbers[channel.topic] = numbers.get(channel.topic, -1) + 1
            message(channel.topic, numbers[channel.topic], each)
            writer.add_message(channels[channel.id], each.log_time, each.data, each.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped
    return target


def _changed(content: bytes, change: Callable[[Metadata], object]) -> Metadata:
    records = {
        record.name: {key: json.loads(value) for key, value in record.metadata.items()}
        for record in make_reader(io.BytesIO(content)).iter_metadata()
    }
    change(records)
    return records


def odometry(target: Path) -> Path:
    """An MCAP file as a robot writes it, with nothing of taskgist in it."""
    with target.open("wb") as out:
        writer = Writer(out)
        writer.start()
        schema = writer.register_schema("nav_msgs/msg/Odometry", "ros2msg", b"")
        channel = writer.register_channel("/odometry", "cdr", schema)
        writer.add_message(channel, 0, b"", 0)
        writer.finish()  # type: ignore[no-untyped-call]  # as above
    return target
