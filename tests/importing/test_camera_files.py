"""JSON of trackers on cameras, and NPZ of a body model: ZED, MediaPipe, SMPL-X."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import load_mapping, look, mapping_text, read_take, read_tracks
from taskgist.importing.formats.smplx import PARENTS
from taskgist.importing.readers import kind_of
from taskgist.importing.skeletons import SKELETONS
from taskgist.importing.tracks import Tracks
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, wxyz_from_rotation_vector
from tests.importing.skeletons import Array
from tests.importing.takes import points_of
from tests.importing.test_skeletons import FRAMES

CAMERA = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])
"""Axes of a camera's image in those of the room: x right, y down, z away."""


def in_camera(skeleton: str, shift_m: tuple[float, float, float] = (0.0, 0.0, -1.2)) -> Array:
    """Points in the skeleton's order, (frames, points, 3), metres; NaN for those that it does not map."""
    points, lost = points_of(skeleton), np.full((FRAMES, 3), np.nan)
    room = np.stack([points.get(name, lost) for name in SKELETONS[skeleton].names], axis=1)
    return np.asarray((room + np.array(shift_m)) @ CAMERA.T)


def tracks_of(path: Path) -> Tracks:
    proposal = look(path)
    assert not proposal.open
    mapping = path.with_suffix(".toml")
    mapping.write_text(mapping_text(proposal, path.name), encoding="utf-8")
    return read_tracks(load_mapping(mapping))


def zed(path: Path, *, skeleton: str = "zed_body_34", scale: float = 1000.0, **changed: Any) -> Path:
    """Two people, the second of whom comes late; times in nanoseconds."""
    one, two = in_camera(skeleton), in_camera(skeleton, (0.0, 1.0, -1.2))
    frames = {}
    for k in range(FRAMES):
        bodies = [(7, one[k])] + ([(9, two[k])] if k >= 3 else [])
        stamp = 1_700_000_000_000_000_000 + k * 33_333_333
        frames[str(stamp)] = {
            "timestamp": stamp,
            "is_new": True,
            "body_list": [
                {
                    "id": number,
                    "tracking_state": "OK",
                    "keypoint": [[None if math.isnan(v) else scale * v for v in point] for point in places.tolist()],
                    "keypoint_confidence": [80.0] * len(places),
                }
                for number, places in bodies
            ],
            **changed,
        }
    path.write_text(json.dumps(frames), encoding="utf-8")
    return path


@pytest.mark.parametrize("skeleton", ["zed_body_34", "zed_body_38"])
@pytest.mark.parametrize("scale", [1000.0, 1.0])
def test_bodies_of_zed(tmp_path: Path, skeleton: str, scale: float) -> None:
    path = zed(tmp_path / "bodies.json", skeleton=skeleton, scale=scale)
    assert kind_of(path) == "zed"
    proposal = look(path)
    assert [(s.name, s.skeleton) for s in proposal.people] == [("P7", skeleton), ("P9", skeleton)]
    assert (proposal.unit.value, proposal.up.value) == ("mm" if scale == 1000.0 else "m", "-y")
    tracks = tracks_of(path)
    truth = points_of(skeleton)["LEFT_WRIST"]
    assert proposal.raised_m == pytest.approx(1.2, abs=0.05)  # the camera's height
    np.testing.assert_allclose(tracks.people["P7"].points["left_wrist"][-1], truth[-1], atol=0.05)
    assert np.isnan(tracks.people["P9"].points["left_wrist"][:2]).all()
    assert "# confidence = { least = 40 }" in mapping_text(proposal, "bodies.json")


def test_confidence_of_zed_can_be_asked(tmp_path: Path) -> None:
    path = zed(tmp_path / "bodies.json")
    text = mapping_text(look(path), path.name).replace("# confidence", "confidence")
    mapping = tmp_path / "m.toml"
    mapping.write_text(text.replace("least = 40", "least = 90"), encoding="utf-8")
    with pytest.raises(MappingError, match="the person is never seen"):
        read_tracks(load_mapping(mapping))


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"timestamp": "noon"}, r"frame 0: timestamp: is no time \(got 'noon'\)"),
        ({"body_list": [{"id": 1}]}, r"frame 0: body_list: is no body with keypoints"),
        ({"body_list": [{"id": 1, "keypoint": [[1, 2]]}]}, r"frame 0: keypoint: is no place \(got \[1, 2\]\)"),
        ({"body_list": []}, "nobody is in it"),
    ],
)
def test_broken_bodies_are_told_by_frame(tmp_path: Path, changed: dict[str, Any], message: str) -> None:
    path = zed(tmp_path / "bodies.json", **changed)
    with pytest.raises(MappingError, match=message):
        read_take(path, "zed")


def mediapipe(path: Path, *, many: bool = False, key: str = "pose_world_landmarks", time: str = "timestamp_ms") -> Path:
    places = in_camera("mediapipe_pose")
    frames = []
    for k in range(FRAMES):
        points = [{"x": x, "y": y, "z": z, "visibility": 0.9} for x, y, z in np.nan_to_num(places[k], nan=0.1).tolist()]
        frames.append({time: 33 * k, key: [points] if many else points})
    path.write_text(json.dumps(frames if many else {"fps": 30, "frames": frames}), encoding="utf-8")
    return path


@pytest.mark.parametrize("many", [False, True])
@pytest.mark.parametrize("time", ["timestamp_ms", "t"])
def test_world_landmarks_of_mediapipe(tmp_path: Path, many: bool, time: str) -> None:
    path = mediapipe(tmp_path / "pose.json", many=many, time=time)
    assert kind_of(path) == "mediapipe"
    tracks = tracks_of(path)
    (person,) = tracks.people.values()
    np.testing.assert_allclose(person.points["left_wrist"][0], points_of("mediapipe_pose")["left_wrist"][0], atol=0.05)
    assert tracks.times_s[-1] == pytest.approx(0.033 * (FRAMES - 1), abs=0.034)


def test_places_in_an_image_are_refused(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match="holds places in the image only; save the world landmarks"):
        look(mediapipe(tmp_path / "pose.json", key="pose_landmarks"))
    with pytest.raises(MappingError, match="frames have no time; save the time of each frame as one of"):
        look(mediapipe(tmp_path / "pose.json", many=True, time="no"))
    openpose = {"version": 1.3, "people": [{"person_id": [-1], "pose_keypoints_2d": [1.0, 2.0, 0.9]}]}
    (tmp_path / "a_keypoints.json").write_text(json.dumps(openpose), encoding="utf-8")
    with pytest.raises(MappingError, match="of OpenPose, whose points are places in the image, triangulate"):
        look(tmp_path / "a_keypoints.json")
    (tmp_path / "cut.json").write_text('{"1": {"body_list": [', encoding="utf-8")
    with pytest.raises(MappingError, match=r"cut.json: is no JSON: .*cut off"):
        look(tmp_path / "cut.json")


# --- SMPL-X.


def smplx(path: Path, *, with_poses: bool = True, **more: Any) -> Path:
    """Joints in the room's axes, and poses of a body that stands and has turned its head by 0.5 rad to the left."""
    points = points_of("smplx")
    joints = np.stack([points.get(name, np.zeros((FRAMES, 3))) for name in SKELETONS["smplx"].names], axis=1)
    joints = np.concatenate([joints, np.zeros((FRAMES, 33, 3))], axis=1).astype(np.float32)
    vectors = np.zeros((FRAMES, 52, 3), np.float32)
    vectors[:, 0] = rotation_vector(STANDING)
    vectors[:, SKELETONS["smplx"].names.index("head")] = (0.0, 0.5, 0.0)
    given = {"joints": joints, "mocap_framerate": np.array(30.0), "gender": np.array("neutral")}
    given |= {"poses": vectors.reshape(FRAMES, -1), "trans": np.zeros((FRAMES, 3))} if with_poses else {}
    np.savez(path, **{name: value for name, value in {**given, **more}.items() if value is not None})
    return path


STANDING = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""The model's x, y and z (left, up, forward) in the room: y, z and x."""


def rotation_vector(matrix: Array) -> Array:
    angle = math.acos((np.trace(matrix) - 1.0) / 2.0)
    skew = np.array([matrix[2, 1] - matrix[1, 2], matrix[0, 2] - matrix[2, 0], matrix[1, 0] - matrix[0, 1]])
    return np.asarray(angle * skew / (2.0 * math.sin(angle)))


def test_joints_and_directions_of_smplx(tmp_path: Path) -> None:
    assert np.allclose(matrix_from_wxyz(wxyz_from_rotation_vector(rotation_vector(STANDING))), STANDING)
    path = smplx(tmp_path / "walk.npz")
    assert kind_of(path) == "smplx"
    proposal = look(path)
    assert (proposal.unit.value, proposal.up.value, proposal.open) == ("m", "z", ())
    mapping = tmp_path / "walk.toml"
    mapping.write_text(mapping_text(proposal, path.name), encoding="utf-8")
    (person,) = read_tracks(load_mapping(mapping)).people.values()
    np.testing.assert_allclose(person.points["left_wrist"][0], points_of("smplx")["left_wrist"][0], atol=1e-5)
    looking = matrix_from_wxyz(about_z(0.5)) @ (1.0, 0.0, 0.0)
    np.testing.assert_allclose(person.directions["face"][0], looking, atol=1e-5)
    np.testing.assert_allclose(person.directions["left_hand"][0], (0.0, 1.0, 0.0), atol=1e-5)  # of a T pose


def test_joints_without_poses_have_places_only(tmp_path: Path) -> None:
    take = read_take(smplx(tmp_path / "walk.npz", with_poses=False), "smplx")
    assert all(track.wxyz is None for track in take.tracks.values())


def test_parameters_alone_are_named_with_the_way_to_joints(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match=r"walk.npz: holds parameters of SMPL, and no joints; .* package smplx"):
        look(smplx(tmp_path / "walk.npz", joints=None))
    with pytest.raises(MappingError, match="says no frame rate; save it as one of mocap_framerate"):
        look(smplx(tmp_path / "walk.npz", mocap_framerate=None))
    with pytest.raises(MappingError, match=r"poses: do not fit the joints \(got \(3, 156\)\)"):
        look(smplx(tmp_path / "walk.npz", poses=np.zeros((3, 156))))
    with pytest.raises(MappingError, match=r"joints: are no joints of SMPL \(got \(5, 3\)\)"):
        look(smplx(tmp_path / "walk.npz", joints=np.zeros((5, 3))))


def test_the_tree_of_joints_is_a_tree() -> None:
    names = SKELETONS["smplx"].names
    assert all(parent < joint for joint, parent in enumerate(PARENTS))
    assert names[PARENTS[names.index("left_wrist")]] == "left_elbow"
    assert names[PARENTS[names.index("head")]] == "neck"
