"""Small files of motion capture from which the fuzzer starts: one of each format, written out here, and right."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from scipy.io import savemat

from taskgist.importing.skeletons import MEDIAPIPE_POSE, SMPL_X, ZED_BODY_34

FRAMES = 4
POINTS: Mapping[str, tuple[float, float, float]] = {
    "Nose": (0.12, 0.0, 1.60),
    "Head": (0.02, 0.0, 1.62),
    "Neck": (0.0, 0.0, 1.45),
    **{
        f"{side}{name}": (x, sign * y, z)
        for side, sign in (("L", 1.0), ("R", -1.0))
        for name, (x, y, z) in {
            "Shoulder": (0.0, 0.18, 1.42),
            "Elbow": (0.02, 0.22, 1.13),
            "Wrist": (0.15, 0.21, 0.93),
            "Hip": (0.0, 0.09, 0.93),
            "Knee": (0.02, 0.10, 0.5),
            "Ankle": (0.0, 0.10, 0.08),
            "Foot": (0.13, 0.10, 0.03),
            "Ear": (0.0, 0.07, 1.62),
            "Eye": (0.1, 0.03, 1.64),
        }.items()
    },
}
"""Somebody who stands, in metres, z up, by the names of OpenPose."""
PLACES = np.array(list(POINTS.values())) + 0.01 * np.arange(FRAMES)[:, None, None] * (1.0, 0.0, 0.0)
"""Those points over time, (frames, points, 3)."""
BVH_JOINTS = """HIERARCHY
ROOT Hips
{
 OFFSET 0 0 0
 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
"""


def takes() -> dict[str, bytes]:
    """Files by their names."""
    return {
        "take.c3d": _c3d(),
        "take.trc": _trc(),
        "take.bvh": _bvh(),
        "motive.csv": _motive(),
        "nexus.csv": _nexus(),
        "qualisys.tsv": _qualisys(),
        "zed.json": _zed(),
        "pose.json": _mediapipe(),
        "smplx.npz": _smplx(),
        **_bags(),
    }


def _rows(lead: str, delimiter: str) -> list[str]:
    """A row for each frame, in millimetres, after its number, counted from 1, and what else leads."""
    cells = [delimiter.join(f"{1000 * value:.1f}" for value in frame.ravel()) for frame in PLACES]
    return [lead.format(number=k + 1, time=k / 30) + row for k, row in enumerate(cells)]


def _trc() -> bytes:
    names, count = "\t\t\t".join(POINTS), len(POINTS)
    head = [
        "PathFileType\t4\t(X/Y/Z)\ttake.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"30\t30\t{FRAMES}\t{count}\tmm\t30\t1\t{FRAMES}",
        f"Frame#\tTime\t{names}\t\t",
        "\t\t" + "\t".join(f"{axis}{k + 1}" for k in range(count) for axis in "XYZ"),
        "",
    ]
    return "\n".join([*head, *_rows("{number}\t{time:.4f}\t", "\t")]).encode()


def _nexus() -> bytes:
    names = ",".join(f"Anna:{name},," for name in POINTS)
    head = ["Trajectories", "30", f",,{names}", "Frame,Sub Frame," + ",".join(["X,Y,Z"] * len(POINTS))]
    units = ",," + ",".join(["mm,mm,mm"] * len(POINTS))
    return "\n".join([*head, units, *_rows("{number},0,", ","), "", "Devices", "30"]).encode()


def _qualisys() -> bytes:
    names = "\t".join(POINTS)
    head = [f"NO_OF_FRAMES\t{FRAMES}", "FREQUENCY\t30", "DATA_INCLUDED\t3D", f"MARKER_NAMES\t{names}"]
    return "\n".join([*head, *_rows("", "\t")]).encode()


def _motive() -> bytes:
    """The markers, and a bone that nothing turns."""
    names = [name for name in POINTS for _ in range(3)]
    head = [
        "Format Version,1.23,Take Name,take,Rotation Type,Quaternion,Length Units,Millimeters",
        "",
        ",Type," + ",".join([*["Marker"] * len(names), *["Bone"] * 7]),
        ",Name," + ",".join([*names, *["Anna:Chest"] * 7]),
        ",ID," + ",".join(["1"] * (len(names) + 7)),
        ",," + ",".join([*["Position"] * len(names), *["Rotation"] * 4, *["Position"] * 3]),
        "Frame,Time (Seconds)," + ",".join([*["X,Y,Z"] * len(POINTS), "X,Y,Z,W,X,Y,Z"]),
    ]
    return "\n".join([*head, *(f"{row},0,0,0,1,100,200,800" for row in _rows("{number},{time:.4f},", ","))]).encode()


def _bvh() -> bytes:
    def joint(name: str, offset: str, inside: str = " End Site\n {\n  OFFSET 0 5 0\n }\n") -> str:
        return f"JOINT {name}\n{{\n OFFSET {offset}\n CHANNELS 3 Zrotation Xrotation Yrotation\n{inside}}}\n"

    arms = [
        joint(
            f"{side}Arm",
            f"{18 * sign} 45 0",
            joint(f"{side}ForeArm", f"{28 * sign} 0 0", joint(f"{side}Hand", f"{25 * sign} 0 0")),
        )
        for side, sign in (("Left", 1), ("Right", -1))
    ]
    legs = [
        joint(f"{side}UpLeg", f"{9 * sign} -8 0", joint(f"{side}Leg", "0 -42 0", joint(f"{side}Foot", "0 -41 0")))
        for side, sign in (("Left", 1), ("Right", -1))
    ]
    joints = 1 + len(arms) * 3 + len(legs) * 3 + 1
    row = " ".join(["0 95 0", *["0 5 0"] * joints])
    body = BVH_JOINTS + joint("Head", "0 60 0") + "".join(arms + legs) + "}\n"
    return f"{body}MOTION\nFrames: {FRAMES}\nFrame Time: 0.0333\n{(row + chr(10)) * FRAMES}".encode()


def _named(names: Sequence[str]) -> np.ndarray:
    """Those points by names such as LEFT_EYE and left_eye, (frames, names, 3); NaN for others."""
    ours = {name: index for index, name in enumerate(POINTS)}
    found = np.full((FRAMES, len(names), 3), np.nan)
    for k, name in enumerate(names):
        side, _, joint = name.lower().rpartition("_")
        at = ours.get(f"{side[:1].upper()}{joint.capitalize()}")
        if at is not None:
            found[:, k] = PLACES[:, at]
    return found


def _zed() -> bytes:
    frames = []
    for k, places in enumerate(_named(ZED_BODY_34.names).tolist()):
        points = [place if place[0] == place[0] else [None] * 3 for place in places]
        body = {"id": 1, "keypoint": points, "keypoint_confidence": [80.0] * len(points)}
        frames.append({"timestamp": 1_700_000_000_000_000_000 + k * 33_000_000, "body_list": [body]})
    return json.dumps(frames).encode()


def _mediapipe() -> bytes:
    """In a camera's axes: x right, y down, z away."""
    frames = []
    for places in _named(MEDIAPIPE_POSE.names):
        points = [
            {"x": -y, "y": -z, "z": x, "visibility": 0.9} if x == x else {"visibility": 0.0}
            for x, y, z in places.tolist()
        ]
        frames.append({"pose_world_landmarks": points})
    return json.dumps({"fps": 30, "frames": frames}).encode()


def _smplx() -> bytes:
    joints = np.nan_to_num(_named(SMPL_X.names), nan=0.9).astype(np.float32)
    packed = io.BytesIO()
    np.savez_compressed(packed, joints=joints, poses=np.zeros((FRAMES, 66), np.float32), fps=np.array(30.0))
    return packed.getvalue()


MAT_TOML = """
[sources.s]
file = "data.mat"
array = "take.Trajectories.Data"
rate_hz = 30
units = "m"
[objects.cup]
source = "s"
point = 1
shape = { type = "sphere", radius_m = 0.04 }
"""


def matlab() -> dict[str, bytes]:
    """Arrays of MATLAB, and their mapping."""
    packed = io.BytesIO()
    savemat(packed, {"take": {"Trajectories": {"Data": PLACES}}, "t": np.arange(FRAMES)}, do_compression=True)
    return {"mat.toml": MAT_TOML.encode(), "data.mat": packed.getvalue()}


def _bags() -> dict[str, bytes]:
    """A bag of ROS 1 and one of ROS 2 with a person of ROS4HRI and two joints; none without rosbags."""
    if find_spec("rosbags") is None:
        return {}
    from rosbags import rosbag1, rosbag2
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    one, two = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
    one.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", TREE))
    with TemporaryDirectory() as folder:
        with rosbag1.Writer(Path(folder) / "take.bag") as writer:
            _fill(writer, one, one.serialize_ros1)
        with rosbag2.Writer(Path(folder) / "two", version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3) as writer:
            _fill(writer, two, two.serialize_cdr)
        return {
            "take.bag": (Path(folder) / "take.bag").read_bytes(),
            "take.db3": (Path(folder) / "two/two.db3").read_bytes(),
        }


TREE, JOINTS = "tf2_msgs/msg/TFMessage", "sensor_msgs/msg/JointState"


def _fill(writer: Any, store: Any, packed: Callable[[Any, str], memoryview[int]]) -> None:
    types = store.types
    topics = {
        kind: writer.add_connection(name, kind, typestore=store) for name, kind in (("/tf", TREE), ("/joints", JOINTS))
    }
    unturned = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    seq = [0] if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else []
    for k, places in enumerate(_named(ROS4HRI)):
        at_ns = 10**9 + 33_000_000 * k
        header = types["std_msgs/msg/Header"](*seq, types["builtin_interfaces/msg/Time"](1, 33_000_000 * k), "world")
        links = [
            types["geometry_msgs/msg/TransformStamped"](
                header,
                f"{name}_7",
                types["geometry_msgs/msg/Transform"](types["geometry_msgs/msg/Vector3"](*map(float, place)), unturned),
            )
            for name, place in zip(("body", *ROS4HRI), (places[0], *places), strict=True)
        ]
        writer.write(topics[TREE], at_ns, packed(types[TREE](links), TREE))
        joints = types[JOINTS](header, ["a", "b"], np.array([0.1 * k, 1.0]), np.zeros(0), np.zeros(0))
        writer.write(topics[JOINTS], at_ns, packed(joints, JOINTS))


ROS4HRI = ("l_hip", "r_hip", "l_shoulder", "r_shoulder", "l_elbow", "l_wrist", "r_elbow", "r_wrist", "l_ear", "r_ear")


def _c3d() -> bytes:
    """Floats of an Intel processor."""

    def record(name: str, kind: int, shape: bytes, data: bytes) -> bytes:
        body = struct.pack("bB", kind, len(shape)) + shape + data + b"\0"
        return struct.pack("bb", len(name), 1) + name.encode() + struct.pack("<H", len(body) + 2) + body

    labels = "".join(name.ljust(12) for name in POINTS).encode()
    section = struct.pack("bb", -5, -1) + b"POINT" + struct.pack("<H", 3) + b"\0"
    section += record("LABELS", -1, bytes((12, len(POINTS))), labels) + record("UNITS", -1, bytes((2,)), b"mm")
    section += record("RATE", 4, b"", struct.pack("<f", 30.0)) + bytes(2)
    blocks = -(-(len(section) + 4) // 512)
    head = struct.pack("<BBHHHHHfHHf", 2, 80, len(POINTS), 0, 1, FRAMES, 0, -1.0, 2 + blocks, 0, 30.0)
    parameters = struct.pack("bbBB", 1, 80, blocks, 84) + section
    data = np.concatenate([1000.0 * PLACES, np.zeros((*PLACES.shape[:2], 1))], axis=2).astype("<f4").tobytes()
    return head.ljust(512, b"\0") + parameters.ljust(512 * blocks, b"\0") + data
