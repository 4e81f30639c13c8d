"""Recordings on disk: everything comes back, viewers understand it, and other files are refused with a reason."""

from __future__ import annotations

import dataclasses
import importlib
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from taskgist.errors import InputError, RecordingError
from taskgist.recording import mcap as mcap_file
from taskgist.recording import read, write
from taskgist.recording.foxglove import FRAME_TRANSFORMS, SCENE_UPDATE
from taskgist.recording.messages import StateMessages
from taskgist.recording.recording import rounded
from taskgist.world import Stage
from taskgist.world.geometry.transforms import matrix_from_wxyz
from tests.importing.recordings import FRAMES, LABEL, recording, room


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "handover.mcap"
    write(recording(label=LABEL), path)
    return path


def messages(file: Path, topic: str) -> list[Any]:
    with file.open("rb") as stream:
        return [json.loads(message.data) for _, _, message in make_reader(stream).iter_messages(topics=[topic])]


def test_everything_comes_back(file: Path) -> None:
    before, after = recording(label=LABEL), read(file)
    assert after.label == before.label
    assert after.provenance == before.provenance
    assert after.name == before.name
    assert after.scene.bundle == before.scene.bundle
    assert after.digest == before.digest
    np.testing.assert_allclose(after.times_s, before.times_s, atol=1e-9)
    np.testing.assert_array_equal(after.qpos, rounded(before.qpos, before.scene))
    for frame in range(FRAMES):
        assert after.state(frame).untracked == before.state(frame).untracked


def test_writing_again_gives_the_same_file(file: Path, tmp_path: Path) -> None:
    write(read(file), tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == file.read_bytes()


def test_one_target_stands_as_it_is_and_several_as_a_list(file: Path, tmp_path: Path) -> None:
    """A file of a release that knew one of each is read, and one of each is written as it was written then."""
    records = {each.name: each.metadata for each in make_reader(io.BytesIO(file.read_bytes())).iter_metadata()}
    assert records["taskgist.label"] == {
        "task": '"give"',
        "performing_agent": '"P1"',
        "target_agent": '"P2"',
        "target_object": '"cup"',
        "start_s": "0.05",
        "end_s": "0.1",
        "how": '"by hand"',
    }
    label = dataclasses.replace(LABEL, target_objects=("cup", "box"))
    write(recording(label=label), tmp_path / "several.mcap")
    assert read(tmp_path / "several.mcap").label == label
    several = make_reader(io.BytesIO((tmp_path / "several.mcap").read_bytes()))
    (record,) = (each.metadata for each in several.iter_metadata() if each.name == "taskgist.label")
    assert record == records["taskgist.label"] | {"target_object": '["cup", "box"]'}


def test_a_label_may_reach_to_the_last_frame(tmp_path: Path) -> None:
    """Times are rounded on disk, labels are not."""
    label = dataclasses.replace(LABEL, end_s=float(recording().times_s[-1]))
    write(recording(label=label), tmp_path / "whole.mcap")
    assert read(tmp_path / "whole.mcap").label == label


def test_states_are_named(file: Path) -> None:
    first = messages(file, "/taskgist/state")[0]
    world = room()
    cup = rounded(recording().qpos, world)[0, world.object_slice("cup")]
    assert first["objects"]["cup"] == cup.tolist()
    assert len(first["agents"]["P1"]["joints"]) == len(world.joints("P1"))
    assert first["untracked"] == ["P1/left_arm"]
    assert len(first["others"]) == 1, "the hinge of the door"


def test_transforms_chain_up_to_the_bodies(file: Path) -> None:
    """What a viewer makes of /tf is where the bodies are."""
    stage = Stage(room())
    stage.show(read(file).state(3))
    frames = {t["child_frame_id"]: t for t in messages(file, "/tf")[3]["transforms"]}
    for body in ("P1/right_hand", "P2/head", "cup", "door"):
        position, matrix = _in_world(frames, body)
        pose = stage.body(room().model.body(body).id)
        np.testing.assert_allclose(position, pose.position, atol=0.01)
        np.testing.assert_allclose(matrix, pose.matrix, atol=0.02)
    assert "table" not in frames


def _in_world(frames: dict[str, Any], body: str) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    position, matrix = np.zeros(3), np.eye(3)
    while body != "world":
        frame = frames[body]
        turn = matrix_from_wxyz([frame["rotation"][axis] for axis in "wxyz"])
        position = turn @ position + [frame["translation"][axis] for axis in "xyz"]
        matrix = turn @ matrix
        body = frame["parent_frame_id"]
    return position, matrix


def test_shapes_are_drawn_once(file: Path) -> None:
    (update,) = messages(file, "/scene")
    entities = {entity["id"]: entity for entity in update["entities"]}
    assert entities["cup"]["frame_id"] == "cup"
    assert entities["cup"]["cylinders"][0]["size"] == {"x": 0.08, "y": 0.08, "z": 0.1}
    table = entities["table"]
    assert (table["frame_id"], table["cubes"][0]["pose"]["position"]["z"]) == ("world", 0.7)
    assert table["cubes"][0]["size"] == {"x": 0.8, "y": 1.2, "z": 0.04}
    assert len(entities["door"]["spheres"]) == 3, "the ends of a capsule, and an ellipsoid"
    assert "P1/head" in entities
    assert "world" in entities, "the floor"


@pytest.mark.parametrize(("topic", "name"), [("/tf", "FrameTransforms"), ("/scene", "SceneUpdate")])
def test_foxglove_accepts_the_messages(file: Path, topic: str, name: str) -> None:
    pytest.importorskip("foxglove_schemas_protobuf", reason="pip install foxglove-schemas-protobuf protobuf")
    json_format = importlib.import_module("google.protobuf.json_format")
    official = getattr(importlib.import_module(f"foxglove_schemas_protobuf.{name}_pb2"), name)
    for message in messages(file, topic):
        json_format.ParseDict(_with_protobuf_times(message), official())


def _with_protobuf_times(value: Any) -> Any:
    """Foxglove writes times and durations as seconds and nanoseconds, Protobuf's JSON as text."""
    if isinstance(value, list):
        return [_with_protobuf_times(item) for item in value]
    if not isinstance(value, dict):
        return value
    if value.keys() == {"sec", "nsec"}:
        return f"{value['sec']}.{value['nsec']:09d}s"
    return {
        key: f"1970-01-01T00:00:0{item['sec']}.{item['nsec']:09d}Z"
        if key == "timestamp"
        else _with_protobuf_times(item)
        for key, item in value.items()
    }


@pytest.mark.parametrize(
    ("topic", "schema"),
    [("/tf", FRAME_TRANSFORMS), ("/scene", SCENE_UPDATE), ("/taskgist/state", None)],
)
def test_messages_obey_the_schemas_in_the_file(file: Path, topic: str, schema: dict[str, Any] | None) -> None:
    with file.open("rb") as stream:
        found = [(s, c, m) for s, c, m in make_reader(stream).iter_messages(topics=[topic])]
    for record, channel, message in found:
        assert record is not None
        assert (record.encoding, channel.message_encoding) == ("jsonschema", "json")
        written = json.loads(record.data)
        assert record.name == written["title"]
        assert schema is None or written == schema
        _check(json.loads(message.data), written)


KINDS: dict[str, tuple[type, ...]] = {
    "object": (dict,),
    "array": (list,),
    "string": (str,),
    "boolean": (bool,),
    "integer": (int,),
    "number": (int, float),
}


def _check(value: Any, schema: dict[str, Any]) -> None:
    """Validate by the few words of JSON Schema that the schemas use; fields without a schema are mistakes."""
    assert any(isinstance(value, kind) for kind in KINDS[schema["type"]])
    if schema["type"] == "array":
        assert schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
        for item in value:
            _check(item, schema["items"])
    elif schema["type"] == "object":
        assert set(schema.get("required", [])) <= set(value)
        for key, item in value.items():
            _check(item, schema.get("properties", {}).get(key) or schema["additionalProperties"])


def refusal(path: Path) -> str:
    before = sorted(path.parent.iterdir())
    with pytest.raises(InputError) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert sorted(path.parent.iterdir()) == before
    return str(caught.value)


def test_files_that_are_no_recording(tmp_path: Path) -> None:
    path = tmp_path / "other.mcap"
    assert "cannot be read: No such file or directory" in refusal(path)
    path.write_bytes(b"")
    assert "the file is empty" in refusal(path)
    path.write_text("t,x,y,z\n1,2,3,4\n")
    assert "not an MCAP file" in refusal(path)
    path.write_bytes(foreign())
    assert "an MCAP file, but not a recording of taskgist (got 'topics: /odometry')" in refusal(path)


def foreign(**metadata: str) -> bytes:
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    schema = writer.register_schema("nav_msgs/Odometry", "ros1msg", b"")
    channel = writer.register_channel("/odometry", "ros1", schema)
    writer.add_message(channel, 0, b"", 0)
    if metadata:
        writer.add_metadata("taskgist.recording", metadata)
    writer.finish()  # type: ignore[no-untyped-call]  # the one function that mcap leaves untyped
    return stream.getvalue()


@pytest.mark.parametrize("share", [0.001, 0.01, 0.3, 0.6, 0.9, 0.999])
def test_truncated_files(share: float, file: Path) -> None:
    content = file.read_bytes()
    file.write_bytes(content[: max(9, int(share * len(content)))])
    assert "the file is cut off or damaged" in refusal(file)


def test_damaged_files(file: Path) -> None:
    """Wherever bytes are overwritten, the recording is read unharmed or refused: never with a traceback."""
    content = file.read_bytes()
    original = read(file)
    refused = 0
    for start in range(8, len(content) - 64, len(content) // 25):
        file.write_bytes(content[:start] + b"\xa5" * 32 + content[start + 32 :])
        try:
            again = read(file)
        except RecordingError:
            refused += 1
        else:
            assert again.digest == original.digest
            assert (again.label, again.provenance) == (original.label, original.provenance)
    assert refused > 15


def test_newer_formats(tmp_path: Path) -> None:
    path = tmp_path / "newer.mcap"
    path.write_bytes(foreign(format=str(mcap_file.FORMAT + 1), name='"x"'))
    assert f"format: the recording is of a newer format (got {mcap_file.FORMAT + 1}); " in refusal(path)


def test_incomplete_records(tmp_path: Path) -> None:
    path = tmp_path / "incomplete.mcap"
    path.write_bytes(foreign(format=str(mcap_file.FORMAT), name='"x"'))
    assert "taskgist.recording: signals: is missing" in refusal(path)


def test_states_of_another_scene(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    encode = StateMessages.encode
    monkeypatch.setattr(StateMessages, "encode", lambda *given: encode(*given) | {"objects": {}})
    write(recording(), file)
    assert "/taskgist/state, frame 0: objects.cup: is missing" in refusal(file)


def test_nothing_is_written_when_writing_fails(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = file.read_bytes()

    def fail(*_: Any) -> Any:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(StateMessages, "encode", fail)
    with pytest.raises(RecordingError, match="cannot be written: No space left on device; free some space"):
        write(recording(), file)
    assert file.read_bytes() == before
    assert sorted(tmp_path.iterdir()) == [file]
    with pytest.raises(RecordingError, match="there is no folder"):
        write(recording(), tmp_path / "nowhere" / "x.mcap")
