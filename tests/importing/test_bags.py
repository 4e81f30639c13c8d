"""Bags of ROS: frames of tf come into the root of their tree, people of REP-155 as people, stamped poses as things."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import load_mapping, look, mapping_text, read_take, read_tracks
from taskgist.importing.readers import kind_of
from taskgist.world.geometry.transforms import about_z, multiply, rotate
from tests.importing.skeletons import Array
from tests.importing.takes import TIMES_S, cup, points_of
from tests.importing.test_skeletons import FRAMES

pytest.importorskip("rosbags")

START_NS = 1_700_000_000_000_000_000
CAMERA_WXYZ, CAMERA_M = about_z(0.7), np.array((2.0, 1.0, 0.5))
"""Where a camera stands in the world."""


def transform(types: Any, parent: str, child: str, stamp_ns: int, place: Array, wxyz: Array) -> Any:
    t = types
    w, x, y, z = map(float, wxyz)
    return t["geometry_msgs/msg/TransformStamped"](
        header(t, parent, stamp_ns),
        child,
        t["geometry_msgs/msg/Transform"](
            t["geometry_msgs/msg/Vector3"](*map(float, place)), t["geometry_msgs/msg/Quaternion"](x, y, z, w)
        ),
    )


def header(types: Any, frame: str, stamp_ns: int) -> Any:
    stamp = types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
    made = types["std_msgs/msg/Header"]
    return made(0, stamp, frame) if "seq" in made.__dataclass_fields__ else made(stamp, frame)


def pose(types: Any, frame: str, stamp_ns: int, place: Array, wxyz: Array) -> Any:
    t = types
    w, x, y, z = map(float, wxyz)
    at = t["geometry_msgs/msg/Pose"](
        t["geometry_msgs/msg/Point"](*map(float, place)), t["geometry_msgs/msg/Quaternion"](x, y, z, w)
    )
    return t["geometry_msgs/msg/PoseStamped"](header(t, frame, stamp_ns), at)


def messages(types: Any) -> list[tuple[str, str, int, Any]]:
    """Topic, type, time and message: a person seen by a camera, a wrist fixed to a moving elbow, and a cup."""
    kind = "tf2_msgs/msg/TFMessage"
    tree, found = types[kind], []
    unturned, points = np.array((1.0, 0.0, 0.0, 0.0)), points_of("ros4hri")
    fixed = [transform(types, "world", "camera", START_NS, CAMERA_M, CAMERA_WXYZ)]
    fixed += [transform(types, "l_elbow_17", "l_wrist_17", START_NS, np.array((0.0, 0.0, -0.25)), unturned)]
    found.append(("/tf_static", kind, START_NS, tree(fixed)))
    for k in range(FRAMES):
        at = START_NS + int(1e9 * TIMES_S[k])
        moving = [transform(types, "camera", "body_17", at, in_camera(points["l_hip"][k]), unturned)]
        for name, place in points.items():
            if name != "l_wrist":
                moving.append(transform(types, "camera", f"{name}_17", at, in_camera(place[k]), unturned))
        found.append(("/tf", kind, at, tree(moving)))
        place, wxyz = cup()
        turned = multiply(CAMERA_WXYZ * (1, -1, -1, -1), wxyz[k])
        found.append(
            ("/cup/pose", "geometry_msgs/msg/PoseStamped", at, pose(types, "camera", at, in_camera(place[k]), turned))
        )
    return found


def in_camera(place: Array) -> Array:
    return rotate(CAMERA_WXYZ * (1, -1, -1, -1), place - CAMERA_M)


def ros2(
    folder: Path, made: Callable[[Any], Sequence[tuple[str, str, int, Any]]] = messages, *, mcap: bool = False
) -> Path:
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # the package leaves an MCAP that it wrote to the collector
        with Writer(folder / "bag", version=9, storage_plugin=plugin) as writer:
            connections: dict[str, Any] = {}
            for topic, kind, at, message in made(store.types):
                if topic not in connections:
                    connections[topic] = writer.add_connection(topic, kind, typestore=store)
                writer.write(connections[topic], at, store.serialize_cdr(message, kind))
        del writer
        gc.collect()
    return folder / "bag"


def ros1(folder: Path) -> Path:
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    with Writer(folder / "take.bag") as writer:
        connections: dict[str, Any] = {}
        for topic, kind, at, message in messages(store.types):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], at, store.serialize_ros1(message, kind))
    return folder / "take.bag"


BAGS: dict[str, Callable[[Path], Path]] = {
    "bag of ROS 1": ros1,
    "folder of ROS 2": ros2,
    "db3": lambda folder: ros2(folder) / "bag.db3",
    "mcap": lambda folder: ros2(folder, mcap=True) / "bag.mcap",
}


@pytest.mark.parametrize("name", BAGS)
def test_people_and_things_of_a_bag(tmp_path: Path, name: str) -> None:
    path = BAGS[name](tmp_path)
    assert kind_of(path) == "ros"
    proposal = look(path)
    assert [(s.name, s.skeleton) for s in proposal.people] == [("P17", "ros4hri")]
    assert proposal.things == ("cup",)
    assert (proposal.unit.value, proposal.up.value) == ("m", "z")
    assert "all places are in the frame world" in proposal.take.notes
    mapping = tmp_path / "m.toml"
    text = mapping_text(proposal, str(path.relative_to(tmp_path))).replace("# shape", "shape")
    mapping.write_text(text, encoding="utf-8")
    tracks = read_tracks(load_mapping(mapping))
    person, truth = tracks.people["P17"], points_of("ros4hri")
    for landmark, point in (("right_wrist", "r_wrist"), ("left_knee", "l_knee"), ("head", "head")):
        np.testing.assert_allclose(person.points[landmark][1:-1], truth[point][1:-1], atol=2e-3)
    below = person.points["left_wrist"] - person.points["left_elbow"]
    np.testing.assert_allclose(below[1:-1], np.tile((0.0, 0.0, -0.25), (len(below) - 2, 1)), atol=1e-6)
    np.testing.assert_allclose(person.directions["face"][1], rotate(CAMERA_WXYZ, (1.0, 0.0, 0.0)), atol=1e-6)
    np.testing.assert_allclose(tracks.objects["cup"].position_m[1:-1], cup()[0][1:-1], atol=1e-3)
    np.testing.assert_allclose(tracks.objects["cup"].wxyz[1], cup()[1][1], atol=1e-3)


def test_what_leads_nowhere_is_told(tmp_path: Path) -> None:
    def made(types: Any) -> list[tuple[str, str, int, Any]]:
        place, wxyz = cup()
        lost = pose(types, "elsewhere", START_NS, place[0], wxyz[0])
        return [*messages(types), ("/lost/pose", "geometry_msgs/msg/PoseStamped", START_NS, lost)]

    take = read_take(ros2(tmp_path, made), "ros")
    assert "lost" not in take.things
    assert "left out, for nothing leads to that frame: /lost/pose (in elsewhere)" in take.notes


def test_frames_in_a_circle_and_bags_without_frames_are_refused(tmp_path: Path) -> None:
    def circle(types: Any) -> list[tuple[str, str, int, Any]]:
        place, wxyz = cup()
        links = [transform(types, a, b, START_NS, place[0], wxyz[0]) for a, b in (("a", "b"), ("b", "a"))]
        return [("/tf", "tf2_msgs/msg/TFMessage", START_NS, types["tf2_msgs/msg/TFMessage"](links))]

    def talk(types: Any) -> list[tuple[str, str, int, Any]]:
        return [("/chatter", "std_msgs/msg/String", START_NS, types["std_msgs/msg/String"]("hello"))]

    for made, message in (
        (circle, "frames go round in a circle"),
        (talk, "holds no frames of tf and no stamped poses"),
    ):
        (tmp_path / message[:6]).mkdir()
        with pytest.raises(MappingError, match=message):
            read_take(ros2(tmp_path / message[:6], made), "ros")


def test_a_damaged_bag_is_named(tmp_path: Path) -> None:
    path = ros1(tmp_path)
    path.write_bytes(path.read_bytes()[:3000])
    with pytest.raises(MappingError, match=r"take.bag: cannot be read as a bag: .*reindex"):
        look(path)


def test_a_person_is_called_as_who_was_recognised(tmp_path: Path) -> None:
    def made(types: Any) -> list[tuple[str, str, int, Any]]:
        text = types["std_msgs/msg/String"]
        said = [("anna", ""), ("anna", "17"), ("nobody", "99")]  # at first nobody knew
        words = [("/humans/persons/" + who + "/body_id", "std_msgs/msg/String", START_NS, text(b)) for who, b in said]
        return [*messages(types), *words]

    proposal = look(ros2(tmp_path, made))
    assert [(s.name, s.skeleton) for s in proposal.people] == [("anna", "ros4hri")]


def test_skeletons_in_images_are_named(tmp_path: Path) -> None:
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    kind = "hri_msgs/msg/Skeleton2D"
    store = get_typestore(Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("std_msgs/Header header\nfloat32[] skeleton", kind))
    with Writer(tmp_path / "bag", version=9) as writer:
        flat = writer.add_connection("/humans/bodies/17/skeleton2d", kind, typestore=store)
        points = store.types[kind](header(store.types, "camera", START_NS), np.zeros(4, np.float32))
        writer.write(flat, START_NS, store.serialize_cdr(points, kind))
        connections: dict[str, Any] = {}
        for topic, name, at, message in messages(store.types):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=store)
            writer.write(connections[topic], at, store.serialize_cdr(message, name))
    notes = read_take(tmp_path / "bag", "ros").notes
    assert "places in an image are not read: /humans/bodies/17/skeleton2d; people come from /tf" in notes
