"""Recordings on disk: MCAP files that hold everything, and that Foxglove opens.

=====================  ===================================================================================
attachments            the scene: ``scene/scene.toml`` and every file that it needs
metadata               ``taskgist.recording`` (format, name, joints), ``taskgist.label``, ``taskgist.provenance``
``/taskgist/state``    the data: one ``taskgist.State`` per frame
``/taskgist/signals``  one ``taskgist.Signals`` per frame, where there are signals
``/tf``, ``/scene``    ``foxglove.FrameTransforms`` and ``foxglove.SceneUpdate``, for viewers
=====================  ===================================================================================
"""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.writer import Writer

from taskgist.errors import InputError, RecordingError
from taskgist.files import replacing
from taskgist.recording.foxglove import Viewer
from taskgist.recording.foxglove_schemas import FRAME_TRANSFORMS, SCENE_UPDATE
from taskgist.recording.label import Label
from taskgist.recording.mcap_content import FORMAT, Content, read_content
from taskgist.recording.provenance import Provenance
from taskgist.recording.recording import Recording
from taskgist.recording.rounding import nanoseconds, rounded
from taskgist.recording.signals import SIGNALS_SCHEMA, decode_signals, encode_signals
from taskgist.recording.state_message import STATE_SCHEMA, decode, encode
from taskgist.world import Scene

STATE_TOPIC, SIGNALS_TOPIC, TF_TOPIC, SCENE_TOPIC = "/taskgist/state", "/taskgist/signals", "/tf", "/scene"

_CHUNK_BYTES = 16 * 2**20  # one chunk for most recordings: the larger, the better it compresses
_SCENE_FOLDER = "scene/"


def write(recording: Recording, path: str | Path) -> None:
    """Write a recording at its precision (``rounding``); the file appears whole or not at all.

    Raises:
        RecordingError: The file cannot be written.
    """
    target = Path(path)
    try:
        with replacing(target) as stream:
            _write(_as_kept(recording), stream)
    except OSError as problem:
        reason = problem.strerror or str(problem)
        hint = "check that the folder exists and may be written to"
        raise RecordingError("cannot write the recording", where=target, value=reason, hint=hint) from None


def read(path: str | Path) -> Recording:
    """Read a recording.

    Raises:
        RecordingError: The file is missing, empty, cut off, no MCAP, not one of taskgist, of a newer format, or its
            content contradicts itself.
    """
    source = Path(path)
    content = read_content(source, STATE_TOPIC, SIGNALS_TOPIC)
    try:
        return _recording(content)
    except InputError as problem:
        problem.where = f"{source}: {problem.where}" if problem.where else str(source)
        raise
    except (KeyError, TypeError) as problem:
        hint = "the file was changed, or not written by taskgist"
        raise RecordingError("its records are incomplete", where=source, value=repr(problem), hint=hint) from None


def _as_kept(recording: Recording) -> Recording:
    """The recording that reading the file will give."""
    times_s = nanoseconds(recording.times_s) / 1e9
    return dataclasses.replace(recording, times_s=times_s, qpos=rounded(recording.qpos, recording.scene))


def _write(recording: Recording, stream: IO[bytes]) -> None:
    writer = Writer(stream, chunk_size=_CHUNK_BYTES, enable_data_crcs=True)
    writer.start(profile="", library="taskgist")
    for name, data in recording.scene.bundle.items():
        writer.add_attachment(0, 0, _SCENE_FOLDER + name, _media_type(name), data)
    for name, record in _metadata(recording).items():
        writer.add_metadata(name, record)
    viewer = Viewer(recording)
    times_ns = nanoseconds(recording.times_s).tolist()
    state, tf, scene = (
        writer.register_channel(topic=topic, message_encoding="json", schema_id=_schema(writer, schema))
        for topic, schema in ((STATE_TOPIC, STATE_SCHEMA), (TF_TOPIC, FRAME_TRANSFORMS), (SCENE_TOPIC, SCENE_UPDATE))
    )
    _add(writer, scene, times_ns[0], viewer.shapes())
    for frame, message in enumerate(encode(recording)):
        _add(writer, state, times_ns[frame], message)
        _add(writer, tf, times_ns[frame], viewer.transforms(frame))
    if recording.signals:
        _write_signals(recording, writer, times_ns)
    writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped


def _write_signals(recording: Recording, writer: Writer, times_ns: list[int]) -> None:
    schema = _schema(writer, SIGNALS_SCHEMA)
    channel = writer.register_channel(topic=SIGNALS_TOPIC, message_encoding="json", schema_id=schema)
    for frame, time_ns in enumerate(times_ns):
        _add(writer, channel, time_ns, encode_signals(recording.signals, frame))


def _schema(writer: Writer, schema: dict[str, Any]) -> int:
    schema_id: int = writer.register_schema(schema["title"], "jsonschema", json.dumps(schema).encode())
    return schema_id


def _add(writer: Writer, channel: int, time_ns: int, message: dict[str, Any]) -> None:
    data = json.dumps(message, separators=(",", ":")).encode()
    writer.add_message(channel, log_time=time_ns, publish_time=time_ns, data=data)


def _media_type(name: str) -> str:
    known = {".toml": "application/toml", ".xml": "application/xml"}
    return known.get(Path(name).suffix, "application/octet-stream")


def _metadata(recording: Recording) -> dict[str, dict[str, str]]:
    joints = {agent: list(recording.scene.joints(agent)) for agent in recording.scene.agents}
    records: dict[str, dict[str, Any]] = {
        "taskgist.recording": {
            "format": FORMAT,
            "name": recording.name,
            "joints": joints,
            "signals": {name: signal.unit for name, signal in recording.signals.items()},
        },
        "taskgist.provenance": recording.provenance.as_dict(),
    }
    if recording.label is not None:
        records["taskgist.label"] = vars(recording.label)
    return {
        name: {key: json.dumps(value, ensure_ascii=False) for key, value in record.items()}
        for name, record in records.items()
    }


def _recording(content: Content) -> Recording:
    bundle = {
        name.removeprefix(_SCENE_FOLDER): data
        for name, data in content.attachments.items()
        if name.startswith(_SCENE_FOLDER)
    }
    scene = Scene.from_bundle(bundle)
    qpos, tracked = decode(scene, content.states)
    label = content.metadata.get("label")
    return Recording(
        scene=scene,
        times_s=np.array(content.times_ns) / 1e9,
        qpos=qpos,
        tracked=tracked,
        label=None if label is None else Label(**label),
        provenance=Provenance(**content.metadata["provenance"]),
        name=content.metadata["recording"]["name"],
        signals=decode_signals(content.metadata["recording"]["signals"], content.signals),
    )
