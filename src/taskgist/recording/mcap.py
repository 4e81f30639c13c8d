"""Recordings on disk: MCAP files that hold everything, and that Foxglove opens.

=====================  ===================================================================================
attachments            the scene: ``scene/scene.toml`` and every file that it needs
metadata               ``taskgist.recording`` (format, name, joints), ``taskgist.label``, ``taskgist.provenance``
``/taskgist/state``    the data: one ``taskgist.State`` per frame
``/taskgist/signals``  one ``taskgist.Signals`` per frame, where there are signals
``/tf``, ``/scene``    ``foxglove.FrameTransforms`` and ``foxglove.SceneUpdate``, for viewers
=====================  ===================================================================================

Other programs may add channels, attachments and metadata of their own: they are left alone. A recording is read and
written frame by frame; what stays in memory is its columns of numbers.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import IO, Any, cast

from mcap.writer import Writer

from taskgist.common.arrays import Array
from taskgist.common.documents import DocumentError, parse_json
from taskgist.common.files import changing, reading, writing
from taskgist.common.text import clean_name
from taskgist.errors import InputError, RecordingError, allowed_names
from taskgist.recording.container import OURS, SCENE_FOLDER, Survey, messages, survey
from taskgist.recording.foxglove import BLOCK, FRAME_TRANSFORMS, SCENE_UPDATE, Viewer
from taskgist.recording.messages import (
    SIGNALS_SCHEMA,
    SIGNALS_TOPIC,
    STATE_SCHEMA,
    STATE_TOPIC,
    FrameColumns,
    StateMessages,
    encode_signals,
)
from taskgist.recording.recording import Label, Provenance, Recording, label_of_fields, nanoseconds, rounded
from taskgist.recording.splicing import with_metadata
from taskgist.settings import DEFAULT, Limits
from taskgist.world.scene import Scene

FORMAT = 1
"""Version of the format; files of a newer one are refused."""
TF_TOPIC, SCENE_TOPIC = "/tf", "/scene"

_ENCODER = json.JSONEncoder(separators=(",", ":"))
_CHUNK_BYTES = 16 * 2**20  # one chunk for most recordings: the larger, the better it compresses


# --- Reading.


def read(path: str | Path, *, limits: Limits = DEFAULT.limits) -> Recording:
    """Read a recording.

    Args:
        path: The file.
        limits: What is refused before memory is taken for it.

    Raises:
        RecordingError: The file is missing, no regular file, empty, cut off, damaged, no MCAP, not one of taskgist, of
            a newer format, larger than the limits, or its content contradicts itself.
    """
    source = Path(path)
    with reading(source, error=RecordingError) as stream:
        return _read(stream, survey(stream, source, limits), source, limits)


def _read(stream: IO[bytes], found: Survey, source: Path, limits: Limits) -> Recording:
    _check_ours(found, source)
    try:
        head = _values(found, "recording", RECORDING, ("name", "signals"))
        label = _values(found, "label", LABEL, LABELLED) if "label" in found.metadata else None
        provenance = _values(found, "provenance", PROVENANCE)
        scene = Scene.from_bundle(found.files, limits=limits)
        frames = FrameColumns(scene, head["signals"], source, limits)
        topics = frozenset([STATE_TOPIC, *([SIGNALS_TOPIC] if head["signals"] else [])])
        for message in messages(stream, source, limits, topics):
            frames.add(message)
        times_s, qpos, tracked, signals = frames.finished()
        return Recording(
            scene=scene,
            times_s=times_s,
            qpos=cast(Array, qpos),  # packed, and read as one
            tracked=tracked,
            label=None if label is None else _label(label),
            provenance=Provenance(**provenance),
            name=head["name"],
            signals=signals,
        )
    except InputError as problem:
        if str(source) not in (problem.where or ""):
            problem.where = f"{source}: {problem.where}" if problem.where else str(source)
        raise


def _check_ours(found: Survey, path: Path) -> None:
    if "recording" not in found.metadata:
        topics = ", ".join(sorted(found.topics)) or "none"
        hint = "taskgist reads recordings that it has written; import other motion as tables (docs/howto/import.md)"
        problem = "an MCAP file, but not a recording of taskgist"
        raise RecordingError(problem, where=path, value=f"topics: {topics}", hint=hint)
    version = _value(found, "recording", "format")
    if type(version) is not int or version > FORMAT:
        hint = f"this taskgist reads formats up to {FORMAT}: install a newer one"
        raise RecordingError("the recording is of a newer format", where=path, field="format", value=version, hint=hint)


# --- What the metadata records hold: fields, and of which kind each is.


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_texts(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _is_texts_by_name(value: Any) -> bool:
    return isinstance(value, dict) and all(isinstance(item, str) for item in value.values())


def _is_by_name(value: Any) -> bool:
    return isinstance(value, dict)


Kinds = Mapping[str, tuple[Callable[[Any], bool], str]]
TEXT, NUMBER = (_is_text, "a text"), (_is_number, "a number")
RECORDING: Kinds = {
    "format": NUMBER,
    "name": TEXT,
    "joints": (_is_by_name, "names of joints by agent"),
    "signals": (_is_texts_by_name, "units by name"),
}
NAMES = ("task", "performing_agent", "target_agent", "target_object")
CHECKED_BY_LABEL = (lambda _: True, "anything")
LABELLED = (*NAMES, "start_s", "end_s")
LABEL: Kinds = {**dict.fromkeys(LABELLED, CHECKED_BY_LABEL), "how": TEXT}
PROVENANCE: Kinds = {
    "source": TEXT,
    "licence": TEXT,
    "citation": TEXT,
    "simulated": (lambda value: isinstance(value, bool), "true or false"),
    "notes": (_is_texts, "a list of texts"),
    "mapping": TEXT,
    "fit": (_is_by_name, "reports by agent"),
}
HINT = "the file was changed, or not written by taskgist"


def _values(found: Survey, record: str, kinds: Kinds, required: Iterable[str] = ()) -> dict[str, Any]:
    """The values of a metadata record of taskgist; empty if there is no such record and nothing in it is required."""
    values: dict[str, Any] = {}
    for name in dict.fromkeys((*required, *found.metadata.get(record, ()))):
        place = f"{OURS}{record}: {name}"
        if name not in kinds:
            raise RecordingError("no such field", field=place, hint=allowed_names(name, kinds))
        values[name] = _value(found, record, name)
        is_right, kind = kinds[name]
        if not is_right(values[name]):
            raise RecordingError(f"must be {kind}", field=place, value=values[name], hint=HINT)
    return values


def _value(found: Survey, record: str, name: str) -> Any:
    place = f"{OURS}{record}: {name}"
    text = found.metadata.get(record, {}).get(name)
    if text is None:
        raise RecordingError("is missing", field=place, hint=HINT)
    try:
        return parse_json(text)
    except DocumentError as problem:
        raise RecordingError(str(problem), field=place, hint=HINT) from None


def _label(values: dict[str, Any]) -> Label:
    """The label of somebody, its names cleaned of what is not seen."""
    return label_of_fields({**values, **{name: _cleaned(values[name]) for name in NAMES}})


def _cleaned(value: Any) -> Any:
    if isinstance(value, list):
        return [_cleaned(each) for each in value]
    return clean_name(value) if isinstance(value, str) else value


# --- Writing.


def write(recording: Recording, path: str | Path, *, replace: bool = True) -> None:
    """Write a recording at its precision (``rounded``); the file appears whole or not at all.

    Args:
        recording: The recording.
        path: The file.
        replace: Whether a file that is there already is replaced.

    Raises:
        RecordingError: The file cannot be written, or is there already and not to be replaced.
    """
    with writing(Path(path), replace=replace, error=RecordingError) as stream:
        _write(recording, stream)


def _write(recording: Recording, stream: IO[bytes]) -> None:
    writer = Writer(stream, chunk_size=_CHUNK_BYTES, enable_data_crcs=True)
    writer.start(profile="", library="taskgist")
    for name, data in recording.scene.bundle.items():
        writer.add_attachment(0, 0, SCENE_FOLDER + name, _media_type(name), data)
    for name, record in _metadata(recording).items():
        writer.add_metadata(name, record)
    viewer, codec = Viewer(recording), StateMessages(recording.scene)
    times_ns = nanoseconds(recording.times_s).tolist()
    state, tf, scene = (
        writer.register_channel(topic=topic, message_encoding="json", schema_id=_schema(writer, schema))
        for topic, schema in ((STATE_TOPIC, STATE_SCHEMA), (TF_TOPIC, FRAME_TRANSFORMS), (SCENE_TOPIC, SCENE_UPDATE))
    )
    _add(writer, scene, times_ns[0], viewer.shapes())
    for first in range(0, len(recording), BLOCK):
        frames = range(first, min(first + BLOCK, len(recording)))
        rows = rounded(recording.qpos[frames.start : frames.stop], recording.scene)
        for frame, row, transforms in zip(frames, rows, viewer.transforms(frames.start, frames.stop), strict=True):
            _add(writer, state, times_ns[frame], codec.encode(row, recording.untracked(frame)))
            _add(writer, tf, times_ns[frame], transforms)
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
    writer.add_message(channel, log_time=time_ns, publish_time=time_ns, data=_ENCODER.encode(message).encode())


def _media_type(name: str) -> str:
    known = {".toml": "application/toml", ".xml": "application/xml"}
    return known.get(Path(name).suffix, "application/octet-stream")


def _metadata(recording: Recording) -> dict[str, dict[str, str]]:
    records: dict[str, dict[str, Any]] = {
        "recording": {
            "format": FORMAT,
            "name": recording.name,
            "joints": {agent: list(recording.scene.joints(agent)) for agent in recording.scene.agents},
            "signals": {name: signal.unit for name, signal in recording.signals.items()},
        },
        "provenance": recording.provenance.as_dict(),
    }
    if recording.label is not None:
        records["label"] = recording.label.as_dict()
    return {OURS + name: _texts(record) for name, record in records.items()}


def _texts(record: Mapping[str, Any]) -> dict[str, str]:
    return {key: json.dumps(value, ensure_ascii=False) for key, value in record.items()}


# --- Labelling.


def relabel(path: str | Path, change: Callable[[Recording], Label], *, limits: Limits = DEFAULT.limits) -> Label:
    """Give a recording another label; all else in the file stays, byte for byte, whoever wrote it.

    Whoever else is about to label the same file waits, from before its present label is read until the new one is in
    place. If the label stays the same, the file is not touched.

    Args:
        path: The file.
        change: Gives the label of the recording as it is.
        limits: As in ``read``.

    Returns:
        The label that the recording has now.

    Raises:
        RecordingError: The file cannot be read or written.
        UnknownNameError: The label names what the recording does not have.
        LabelError: It reaches outside of it.
    """
    source = Path(path)
    with changing(source, error=RecordingError) as stream:
        found = survey(stream, source, limits)
        recording = _read(stream, found, source, limits)
        label = recording.with_label(change(recording)).label
        assert label
        if label != recording.label:
            record = _texts(label.as_dict())
            with writing(source, replace=True, error=RecordingError) as target:
                with_metadata(stream, target, OURS + "label", record, found, source)
    return label
