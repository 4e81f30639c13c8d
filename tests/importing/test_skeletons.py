"""Skeletons by name: their points, where these lie on a body, and what a mapping may still say itself."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing import ImportMapping, import_recording, load_mapping, read_tracks
from taskgist.importing.mapping import LocalAxis
from taskgist.importing.mapping_people import LANDMARKS
from taskgist.importing.skeletons import SKELETONS, Skeleton
from taskgist.world import Scene, Stage
from tests.importing.skeletons import NAMES, Array, mapping_file
from tests.importing.test_body_fit import STATURE_M, person

FRAMES = 12
INDICES = {
    "zed_body_34": {"PELVIS": 0, "LEFT_CLAVICLE": 4, "RIGHT_THUMB": 17, "LEFT_HIP": 18, "HEAD": 26, "RIGHT_HEEL": 33},
    "zed_body_38": {"NOSE": 5, "RIGHT_EAR": 9, "LEFT_HIP": 18, "LEFT_BIG_TOE": 24, "RIGHT_HAND_PINKY_1": 37},
    "kinect_azure": {"SPINE_CHEST": 2, "HANDTIP_LEFT": 9, "CLAVICLE_RIGHT": 11, "FOOT_RIGHT": 25, "EAR_RIGHT": 31},
    "kinect_v2": {"Head": 3, "HandLeft": 7, "HipRight": 16, "SpineShoulder": 20, "ThumbRight": 24},
    "mediapipe_pose": {"left_eye": 2, "right_ear": 8, "mouth_left": 9, "left_hip": 23, "right_foot_index": 32},
    "openpose_body_25": {"Neck": 1, "LWrist": 7, "MidHip": 8, "LAnkle": 14, "LBigToe": 19, "RHeel": 24},
    "smplx": {"pelvis": 0, "spine1": 3, "left_foot": 10, "head": 15, "right_wrist": 21},
}
"""As their makers number them."""


def body() -> tuple[Scene, Array]:
    """Somebody who stands, reaches out and looks at the hand, (frames, nq)."""
    room, states = person("standing")
    return room, states[:FRAMES]


def seen_as(skeleton: Skeleton, room: Scene, states: Array) -> dict[str, Array]:
    """A skeleton's points on that body: each where the skeleton says that it lies, (frames, 3) by name."""
    data, markers, found = mujoco.MjData(room.model), skeleton.markers(), {}
    for landmark, at in skeleton.points().items():
        marker = markers.get(landmark)
        places = []
        for qpos in states:
            data.qpos[:] = qpos
            mujoco.mj_kinematics(room.model, data)
            site = data.site(f"P1/{marker.landmark if marker else landmark}")
            turn = data.site(f"P1/{(marker.axes or marker.landmark) if marker else landmark}").xmat.reshape(3, 3)
            shift = STATURE_M * np.array(marker.offset_m) if marker else np.zeros(3)
            places.append(site.xpos + turn @ shift)
        across = np.linspace(-1.0, 1.0, len(at.points)) if len(at.points) > 1 else [0.0]
        for share, point in zip(across, at.points, strict=True):
            found[point] = np.array(places) + (0.0, 0.01 * share, 0.0)
    return found


def mapping_of(folder: Path, name: str, points: dict[str, Array], *, extra: str = "") -> ImportMapping:
    """A mapping that names the skeleton and nothing else; in an NPZ, or where points have no order, in a wide table."""
    skeleton = SKELETONS[name]
    if skeleton.names:
        lost = np.full((FRAMES, 3), np.nan)
        np.savez(folder / "p.npz", p=np.stack([points.get(point, lost) for point in skeleton.names], axis=1))
        source = 'file = "p.npz"'
    else:
        header = ",".join(f"{point}_{axis}" for point in points for axis in "xyz")
        np.savetxt(folder / "p.csv", np.hstack(list(points.values())), delimiter=",", header=header, comments="")
        source = 'file = "p.csv"\nposition = "{point}_{axis}"'
    who = f'[people.P1]\nsource = "s"\nskeleton = "{name}"\n{extra}'
    return load_mapping(mapping_file(folder, f'[sources.s]\n{source}\nrate_hz = 30\nunits = "m"\n{who}'))


@pytest.mark.parametrize("name", SKELETONS)
def test_a_body_comes_back_from_each_skeleton(tmp_path: Path, name: str) -> None:
    room, states = body()
    recording = import_recording(mapping_of(tmp_path, name, seen_as(SKELETONS[name], room, states)))
    errors = recording.provenance.fit["P1"]
    assert all(error["median"] < 3.0 for error in errors["points_cm"].values()), errors["points_cm"]
    assert all(error["median"] < 3.0 for error in errors["directions_deg"].values()), errors["directions_deg"]
    assert recording.scene.agent("P1").stature_m == pytest.approx(STATURE_M, abs=0.06)
    truth, fitted = Stage(room), Stage(recording.scene)
    for frame in range(FRAMES):
        truth.show(room.initial.replace(at=slice(None), to=states[frame]))
        fitted.show(recording.state(frame))
        for site in ("left_wrist", "right_wrist", "head_base"):
            places = [s.site(s.scene.model.site(f"P1/{site}").id).position for s in (truth, fitted)]
            assert np.linalg.norm(places[0] - places[1]) < 0.03, site


@pytest.mark.parametrize("name", SKELETONS)
def test_points_are_those_of_the_skeleton_and_landmarks_ours(name: str) -> None:
    skeleton = SKELETONS[name]
    points = skeleton.points()
    assert points.keys() <= LANDMARKS
    assert skeleton.source
    if skeleton.names:
        assert len(set(skeleton.names)) == len(skeleton.names)
        assert {point for at in points.values() for point in at.points} <= {*skeleton.names}
    for point, index in INDICES.get(name, {}).items():
        assert skeleton.names.index(point) == index
    assert SKELETONS["zed_body_34"].names == tuple(NAMES)


def test_offsets_scale_with_stature_and_mirror() -> None:
    markers = SKELETONS["zed_body_34"].markers()
    assert markers["head"].landmark == "head_base"
    np.testing.assert_allclose(1.70 * np.array(markers["head"].offset_m), (0.107, 0.0, 0.032))
    left, right = markers["left_thumb"], markers["right_thumb"]
    assert (left.landmark, right.landmark) == ("left_wrist", "right_wrist")
    np.testing.assert_allclose(np.array(left.offset_m) * (1, -1, 1), right.offset_m)
    np.testing.assert_allclose(1.70 * np.array(right.offset_m), (0.057, 0.025, -0.104))


def test_an_unknown_skeleton_lists_those_that_are_near(tmp_path: Path) -> None:
    text = '[sources.s]\nfile = "p.npz"\nrate_hz = 30\nunits = "m"\n[people.P1]\nsource = "s"\nskeleton = "zed_34"\n'
    with pytest.raises(UnknownNameError, match=r"people.P1.skeleton: no skeleton 'zed_34'.*mean 'zed_body_34'"):
        load_mapping(mapping_file(tmp_path, text))


def test_names_are_alike_whatever_their_case(tmp_path: Path) -> None:
    text = (
        '[sources.s]\nfile = "p.npz"\nrate_hz = 30\nunits = "m"\nnames = ["Left wrist", "nose", "left-eye", "tail"]\n'
    )
    loaded = load_mapping(mapping_file(tmp_path, f'{text}[people.P1]\nsource = "s"\nskeleton = "mediapipe_pose"\n'))
    points = {point.landmark: point.refs[0].point for point in loaded.people[0].points}
    assert points == {"nose": "nose", "left_eye": "left-eye", "left_wrist": "Left wrist"}


def test_names_of_another_skeleton_are_refused(tmp_path: Path) -> None:
    text = '[sources.s]\nfile = "p.npz"\nrate_hz = 30\nunits = "m"\nnames = ["a", "b"]\n'
    with pytest.raises(MappingError, match=r"people.P1.skeleton: .*names are not those.*its points are called"):
        load_mapping(mapping_file(tmp_path, f'{text}[people.P1]\nsource = "s"\nskeleton = "smplx"\n'))


def test_points_of_the_mapping_win(tmp_path: Path) -> None:
    """An own point is a landmark of ours; false leaves one out; ``like`` copies the skeleton."""
    room, states = body()
    seen = seen_as(SKELETONS["zed_body_34"], room, states)
    extra = '[people.P1.points]\nhead = "NOSE"\nleft_thumb = false\n[people.P2]\nlike = "P1"\n'
    with pytest.raises(MappingError, match="same positions"):
        read_tracks(mapping_of(tmp_path, "zed_body_34", seen, extra=extra))
    loaded = mapping_of(tmp_path, "zed_body_34", seen, extra=extra)
    for one in loaded.people:
        points = {point.landmark: point.refs[0].point for point in one.points}
        assert points["head"] == "NOSE"
        assert "left_thumb" not in points
        assert "head" not in one.preset
        assert points["right_thumb"] == "RIGHT_THUMB"


@pytest.mark.parametrize(("axes", "forward"), [('{ x = "z", y = "x", z = "y" }', "z"), ("{}", "-y")])
def test_bones_of_motive_say_which_way_they_point(tmp_path: Path, axes: str, forward: str) -> None:
    text = f"""
[sources.s]
file = "{{point}}.csv"
rate_hz = 30
units = "m"
axes = {axes}
rotation = {{ kind = "xyzw", columns = "q{{axis}}" }}
[people.P1]
source = "s"
skeleton = "optitrack"
"""
    (one,) = load_mapping(mapping_file(tmp_path, text)).people
    directions = dict(one.directions)
    sign = -1.0 if forward.startswith("-") else 1.0
    assert directions["face"] == LocalAxis("head_base", tuple(sign * np.eye(3)["xyz".index(forward[-1])]))
    assert {"face", "head_up", "pelvis", "pelvis_up", "left_palm", "right_thumb"} <= directions.keys()
