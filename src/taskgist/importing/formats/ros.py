"""Bags of ROS 1 (.bag) and ROS 2 (a folder, .db3 or .mcap): frames of tf, and topics with stamped poses and points.

A frame of tf is given by its parent; here every frame is brought into the one at the root of its tree, each link read
at the times of the frame (along straight lines and great circles). Stamped poses are taken into that root where their
frame is in the tree. Frames of people in the sense of REP-155 (``body_ID``, ``head_ID``, ``l_wrist_ID``, ...) become
the points of person ID, or of the person whose body that is. Joints of robots (``JointState``) are series of numbers.
Lengths are metres and z is up [REP-103]. Images and all other topics are not looked at.

The extra ``recordings`` brings rosbags, which reads bags without ROS.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.extras import door
from taskgist.errors import InputError, MappingError
from taskgist.importing.takes import OWNER, Series, Take, TakeTrack
from taskgist.world.geometry.transforms import multiply, rotate, slerp

BEGINNINGS = (b"#ROSBAG V", b"SQLite format 3\0", b"\x89MCAP0\r\n")
METADATA = "metadata.yaml"
"""In the folder that is a bag of ROS 2."""
TREES = frozenset({"tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"})
PLACES = {
    "geometry_msgs/msg/PoseStamped": ("pose.position", "pose.orientation"),
    "geometry_msgs/msg/PoseWithCovarianceStamped": ("pose.pose.position", "pose.pose.orientation"),
    "geometry_msgs/msg/TransformStamped": ("transform.translation", "transform.rotation"),
    "geometry_msgs/msg/PointStamped": ("point", ""),
    "nav_msgs/msg/Odometry": ("pose.pose.position", "pose.pose.orientation"),
}
"""Types of topics with a place, and the fields of place and orientation."""
JOINTS = "sensor_msgs/msg/JointState"
SAMPLE_BYTES = 400
"""What a sample takes while it is read, in lists."""
LONGEST_GAP_S = 1.0
"""Between two samples of a link that are interpolated over (ours)."""
FLAT = frozenset({"hri_msgs/msg/Skeleton2D", "hri_msgs/msg/FacialLandmarks"})
"""Types of topics of people whose places are in images [REP-155]."""
BODY_OF = re.compile(r"^/humans/persons/[^/]+/body_id$")
"""Topics that say which body a person has."""
PERSON = "body_"
"""How the frame of a person begins [REP-155]; the person's number follows."""


@dataclass
class _Samples:
    """Samples of a frame or topic, as they come.

    Attributes:
        parent: The frame that they are given in.
        rows: Time in seconds, place, and x, y, z, w of the orientation.
        fixed: Whether one sample holds for all times.
    """

    parent: str
    rows: list[tuple[float, ...]] = field(default_factory=list)
    fixed: bool = False

    def sorted(self) -> Array:
        """The samples by time, those of the same time once, (n, 8)."""
        rows = np.array(self.rows).reshape(-1, 8)
        return np.asarray(rows[np.unique(rows[:, 0], return_index=True)[1]])


def is_ros(head: bytes) -> bool:
    """Whether a file that begins so may be a bag."""
    return head.startswith(BEGINNINGS)


def read_ros(path: Path, where: str, most_bytes: int) -> Take:
    """The frames and stamped poses of a bag.

    Raises:
        MappingError: It cannot be read, or holds neither; its frames go round in a circle, or it has too many samples.
        InputError: rosbags is not installed.
    """
    highlevel = door("rosbags.highlevel", "recordings", field="format", value="ros")
    held = _Held()
    try:
        with highlevel.AnyReader([path]) as bag:
            _collect(bag, held, where, most_bytes)
    except InputError:
        raise
    except Exception as problem:  # whatever rosbags and the packages below it make of a damaged file
        hint = "repair it (rosbag reindex, ros2 bag reindex); recordings of taskgist are not imported again"
        raise MappingError(f"cannot be read as a bag: {problem}", where=where, hint=hint) from problem
    if not held.frames and not held.topics:
        hint = f"record /tf and /tf_static, or topics of these types: {', '.join(PLACES)}"
        raise MappingError("holds no frames of tf and no stamped poses", where=where, hint=hint)
    return _take(held, where)


@dataclass
class _Held:
    """What a bag holds.

    Attributes:
        frames: Of tf, by name.
        topics: Stamped places, by topic.
        joints: Times and values of joints, by name.
        persons: Of REP-155: the number of the body that a person has, by the person.
        flat: Topics of places in images.
    """

    frames: dict[str, _Samples] = field(default_factory=dict)
    topics: dict[str, _Samples] = field(default_factory=dict)
    joints: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    persons: dict[str, str] = field(default_factory=dict)
    flat: list[str] = field(default_factory=list)


def _collect(bag: Any, held: _Held, where: str, most_bytes: int) -> None:
    held.flat = sorted({c.topic for c in bag.connections if c.msgtype in FLAT})
    wanted = [c for c in bag.connections if c.msgtype in TREES | {JOINTS} or c.msgtype in PLACES or _is_body(c)]
    count = 0
    for connection, stamp_ns, raw in bag.messages(connections=wanted) if wanted else ():
        message = bag.deserialize(raw, connection.msgtype)
        if connection.msgtype in TREES:
            count += _add_tree(held, connection.topic, message, stamp_ns)
        elif connection.msgtype == JOINTS:
            count += _add_joints(held, message, stamp_ns)
        elif connection.msgtype in PLACES:
            samples = held.topics.setdefault(connection.topic, _Samples(_plain(message.header.frame_id)))
            samples.rows.append(_row(message, PLACES[connection.msgtype], stamp_ns))
            count += 1
        elif message.data:
            held.persons[connection.topic.split("/")[-2]] = message.data
        if SAMPLE_BYTES * count > most_bytes:
            hint = "record fewer topics, or cut the bag"
            raise MappingError("holds too many samples", where=where, value=f"{count:,}", hint=hint)


def _is_body(connection: Any) -> bool:
    """Whether a topic says which body a person has."""
    return bool(connection.msgtype == "std_msgs/msg/String" and BODY_OF.search(connection.topic))


def _add_tree(held: _Held, topic: str, message: Any, stamp_ns: int) -> int:
    for transform in message.transforms:
        name, parent = _plain(transform.child_frame_id), _plain(transform.header.frame_id)
        samples = held.frames.setdefault(name, _Samples(parent, fixed=topic.endswith("tf_static")))
        samples.rows.append(_row(transform, PLACES["geometry_msgs/msg/TransformStamped"], stamp_ns))
    return len(message.transforms)


def _add_joints(held: _Held, message: Any, stamp_ns: int) -> int:
    time_s = _time_s(message, stamp_ns)
    for name, value in zip(message.name, message.position, strict=False):  # some publish speeds alone
        held.joints.setdefault(str(name), []).append((time_s, float(value)))
    return len(message.position)


def _plain(frame: str) -> str:
    return frame.strip("/")


def _row(message: Any, fields: tuple[str, str], stamp_ns: int) -> tuple[float, ...]:
    """A sample of a place."""
    place = _inside(message, fields[0])
    turn = _inside(message, fields[1]) if fields[1] else None
    xyzw = (np.nan,) * 4 if turn is None else (turn.x, turn.y, turn.z, turn.w)
    return (_time_s(message, stamp_ns), place.x, place.y, place.z, *xyzw)


def _time_s(message: Any, stamp_ns: int) -> float:
    """Of a message's header, or of the bag where the header has none."""
    stamp = message.header.stamp
    return float((stamp.sec * 1_000_000_000 + stamp.nanosec or stamp_ns) / 1e9)


def _inside(message: Any, names: str) -> Any:
    for name in names.split("."):
        message = getattr(message, name)
    return message


# --- From links to places in one frame.


def _take(held: _Held, where: str) -> Take:
    frames, topics = held.frames, held.topics
    links = {name: samples.sorted() for name, samples in frames.items()}
    moving = [rows[:, 0] for name, rows in links.items() if not frames[name].fixed]
    moving += [samples.sorted()[:, 0] for samples in topics.values()]
    if not moving:
        raise MappingError("nothing moves in it", where=where, hint="record /tf, not only /tf_static")
    first_s = min(float(times[0]) for times in moving)
    roots = Counter(_root(name, frames, where) for name in frames)
    root = roots.most_common(1)[0][0] if roots else ""
    tracks: dict[str, TakeTrack] = {}
    for name, samples in frames.items():
        rows = _sampled(name, frames, links)
        if rows is not None and _root(name, frames, where) == root:
            tracks[_of_person(name, frames, held.persons)] = _track(
                _in_root(rows, samples.parent, frames, links), first_s
            )
    things: list[str] = []
    astray: list[str] = []
    for topic, samples in topics.items():
        rows, frame = samples.sorted(), samples.parent
        if frame in frames and _root(frame, frames, where) == root:
            rows = _in_root(rows, frame, frames, links)
        elif root and frame != root:
            astray.append(f"{topic} (in {frame})")
            continue
        things.append(_topic_name(topic))
        tracks[things[-1]] = _track(rows, first_s)
    notes = [f"all places are in the frame {root}"] if root else []
    others = sorted(other for other in roots if other != root)
    notes += [f"left out, for nothing leads to that frame: {', '.join([*others, *astray])}"] if others or astray else []
    flat = ", ".join(held.flat)
    notes += [f"places in an image are not read: {flat}; people come from /tf"] if held.flat else []
    series = {name: _series(rows, first_s) for name, rows in held.joints.items()}
    return Take("ros", tracks, frozenset(things), "m", "z", tuple(notes), series)


def _series(rows: Sequence[tuple[float, float]], first_s: float) -> Series:
    """Samples of a joint by time, those of the same time once."""
    samples = np.array(rows)
    samples = samples[np.unique(samples[:, 0], return_index=True)[1]]
    return Series(samples[:, 0] - first_s, samples[:, 1])


def _root(name: str, frames: Mapping[str, _Samples], where: str) -> str:
    """The frame at the root of a frame's tree."""
    seen = {name}
    while name in frames:
        name = frames[name].parent
        if name in seen:
            raise MappingError("frames go round in a circle", where=where, field="tf", value=name, hint="mend tf")
        seen.add(name)
    return name


def _in_root(rows: Array, parent: str, frames: Mapping[str, _Samples], links: Mapping[str, Array]) -> Array:
    """Samples that are given in a frame, in the root of its tree, (n, 8); NaN where a link is not known at the time."""
    while parent in frames:
        link = _at(links[parent], rows[:, 0], fixed=frames[parent].fixed)
        wxyz = link[:, [7, 4, 5, 6]]
        place = link[:, 1:4] + rotate(wxyz, rows[:, 1:4])
        turned = multiply(wxyz, rows[:, [7, 4, 5, 6]])
        rows = np.hstack([rows[:, :1], place, turned[:, [1, 2, 3, 0]]])
        parent = frames[parent].parent
    return rows


def _sampled(name: str, frames: Mapping[str, _Samples], links: Mapping[str, Array]) -> Array | None:
    """A frame's samples in its parent, (n, 8); a fixed one's at the times of what carries it. None if nothing moves."""
    mover = name
    while mover in frames and frames[mover].fixed:
        mover = frames[mover].parent
    if mover not in frames:
        return None
    times_s = links[mover][:, :1]
    return links[name] if mover == name else np.hstack([times_s, np.repeat(links[name][-1:, 1:], len(times_s), axis=0)])


def _at(rows: Array, times_s: Array, *, fixed: bool) -> Array:
    """A link's samples at some times, (n, 8); NaN beyond its first and last ones and in long gaps, unless fixed."""
    if fixed or len(rows) == 1:
        return np.repeat(rows[-1:], len(times_s), axis=0)
    after = np.searchsorted(rows[:, 0], times_s).clip(1, len(rows) - 1)
    start, end = rows[after - 1], rows[after]
    share = (times_s - start[:, 0]) / (end[:, 0] - start[:, 0])
    place = start[:, 1:4] + share[:, None] * (end[:, 1:4] - start[:, 1:4])
    wxyz = slerp(start[:, [7, 4, 5, 6]], end[:, [7, 4, 5, 6]], share)
    found = np.hstack([times_s[:, None], place, wxyz[:, [1, 2, 3, 0]]])
    outside = (times_s < rows[0, 0]) | (times_s > rows[-1, 0])
    found[outside | (end[:, 0] - start[:, 0] > LONGEST_GAP_S), 1:] = np.nan
    return found


def _track(rows: Array, first_s: float) -> TakeTrack:
    wxyz = rows[:, [7, 4, 5, 6]]
    length = np.linalg.norm(wxyz, axis=1, keepdims=True)
    known = np.abs(length - 1.0) < 0.05
    turned = bool(np.isfinite(length).any())
    unit = np.where(known, wxyz / np.where(known, length, 1.0), np.nan)
    return TakeTrack(rows[:, 0] - first_s, rows[:, 1:4], unit if turned else None)


def _of_person(name: str, frames: Iterable[str], persons: Mapping[str, str]) -> str:
    """A frame's name; that of a person's frame as the person's point: ``l_wrist_17`` is ``17:l_wrist``.

    A body that was found to be some person's is called by the person.
    """
    for frame in frames:
        number = frame.removeprefix(PERSON)
        if frame.startswith(PERSON) and number and name.endswith(f"_{number}"):
            who = [person for person, body in persons.items() if body == number]
            return f"{who[0] if len(who) == 1 else number}{OWNER}{name[: -len(number) - 1]}"
    return name


def _topic_name(topic: str) -> str:
    """``/vrpn_client_node/cup/pose`` is ``vrpn_client_node/cup``."""
    return topic.strip("/").removesuffix("/pose") or topic
