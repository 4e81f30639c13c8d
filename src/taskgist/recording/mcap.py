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
import struct
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, McapRecord, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.files import writing
from taskgist.errors import InputError, RecordingError
from taskgist.recording.foxglove import FRAME_TRANSFORMS, SCENE_UPDATE, Viewer
from taskgist.recording.recording import (
    SIGNALS_SCHEMA,
    Label,
    Provenance,
    Recording,
    decode_signals,
    encode_signals,
    free_slices,
    nanoseconds,
    rounded,
)
from taskgist.world.scene import Scene

# --- Reads an MCAP file of taskgist into plain values, and says in one clear error why another file is not one.

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
        hint = "taskgist reads recordings that it has written; import other motion as tables (docs/howto/import.md)"
        problem = "an MCAP file, but not a recording of taskgist"
        raise RecordingError(problem, where=path, value=f"topics: {topics}", hint=hint)
    version = found.metadata["recording"].get("format")
    if not isinstance(version, int) or version > FORMAT:
        hint = f"this taskgist reads formats up to {FORMAT}: install a newer one"
        raise RecordingError("the recording is of a newer format", where=path, field="format", value=version, hint=hint)


# --- ``/taskgist/state``: one JSON message per frame, by names, so that any program can read a recording.

Document = dict[str, Any]

_NUMBERS: Document = {"type": "array", "items": {"type": "number"}}
_POSE = _NUMBERS | {
    "minItems": 7,
    "maxItems": 7,
    "description": "x, y, z in metres and the quaternion w, x, y, z, in the world (z up)",
}
STATE_SCHEMA: Document = {
    "title": "taskgist.State",
    "description": "Where everything in the scene is. The scene itself is attached to the file.",
    "type": "object",
    "properties": {
        "objects": {"type": "object", "description": "Pose of each object", "additionalProperties": _POSE},
        "agents": {
            "type": "object",
            "description": "Each agent's root, and its joints in the order of the metadata record taskgist.recording",
            "additionalProperties": {
                "type": "object",
                "properties": {
                    "base": _POSE,
                    "joints": _NUMBERS | {"description": "Angles in radians (metres for sliding joints)"},
                },
                "required": ["base", "joints"],
            },
        },
        "others": _NUMBERS | {"description": "What else moves in the scene, in the order of its model"},
        "untracked": {
            "type": "array",
            "items": {"type": "string"},
            "description": 'Objects ("box"), agents ("P1") and parts ("P1/left_arm") whose numbers are fillers',
        },
    },
    "required": ["objects", "agents", "untracked"],
}


def encode(recording: Recording) -> list[Document]:
    """The messages of all frames."""
    others = _other_columns(recording.scene)
    states = (recording.state(frame) for frame in range(len(recording)))
    return [_message(recording.scene, state.qpos, others, state.untracked) for state in states]


def decode(scene: Scene, messages: Sequence[Document]) -> tuple[Array, dict[str, Mask]]:
    """Positions (N, nq), and by name the frames in which something was tracked, (N,).

    Raises:
        RecordingError: A message lacks something that the scene has, or holds another number of values.
    """
    qpos = np.empty((len(messages), scene.nq))
    others = _other_columns(scene)
    untracked: dict[str, list[int]] = {}
    for frame, message in enumerate(messages):
        try:
            _read(scene, message, qpos[frame], others)
            names = [str(name) for name in message["untracked"]]
        except (KeyError, TypeError, ValueError, AttributeError) as problem:
            hint = "the file was changed, or not written by taskgist"
            raise RecordingError(
                f"state {frame} does not fit the scene", field="/taskgist/state", value=repr(problem), hint=hint
            ) from None
        for name in names:
            untracked.setdefault(name, []).append(frame)
    tracked = {name: ~np.isin(np.arange(len(messages)), frames) for name, frames in untracked.items()}
    return qpos, tracked


def _message(scene: Scene, row: Array, others: Indices, untracked: frozenset[str]) -> Document:
    message: Document = {
        "objects": {name: row[scene.object_slice(name)].tolist() for name in scene.objects},
        "agents": {
            name: {"base": row[scene.base_slice(name)].tolist(), "joints": row[scene.joint_indices(name)].tolist()}
            for name in scene.agents
        },
        "untracked": sorted(untracked),
    }
    return message | ({"others": row[others].tolist()} if len(others) else {})


def _read(scene: Scene, message: Mapping[str, Any], row: Array, others: Indices) -> None:
    for name in scene.objects:
        row[scene.object_slice(name)] = _numbers(message["objects"][name], 7)
    for name in scene.agents:
        agent, joints = message["agents"][name], scene.joint_indices(name)
        row[scene.base_slice(name)] = _numbers(agent["base"], 7)
        row[joints] = _numbers(agent["joints"], len(joints))
    row[others] = _numbers(message.get("others", []), len(others))


def _numbers(values: Any, count: int) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != (count,):
        raise ValueError(f"{count} numbers expected, {array.shape} found")
    return array


def _other_columns(scene: Scene) -> Indices:
    """Columns of qpos that belong to no object and no agent, such as the hinge of a door."""
    named = np.zeros(scene.nq, dtype=np.bool_)
    for free in free_slices(scene):
        named[free] = True
    for agent in scene.agents:
        named[scene.joint_indices(agent)] = True
    return np.flatnonzero(~named)


STATE_TOPIC, SIGNALS_TOPIC, TF_TOPIC, SCENE_TOPIC = "/taskgist/state", "/taskgist/signals", "/tf", "/scene"

_CHUNK_BYTES = 16 * 2**20  # one chunk for most recordings: the larger, the better it compresses
_SCENE_FOLDER = "scene/"


def write(recording: Recording, path: str | Path, *, replace: bool = True) -> None:
    """Write a recording at its precision (``rounding``); the file appears whole or not at all.

    Args:
        recording: The recording.
        path: The file.
        replace: Whether a file that is there already is replaced.

    Raises:
        RecordingError: The file cannot be written, or is there already and not to be replaced.
    """
    with writing(Path(path), replace=replace, error=RecordingError) as stream:
        _write(_as_kept(recording), stream)


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
