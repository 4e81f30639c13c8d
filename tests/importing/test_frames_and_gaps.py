"""Axes, units, transforms, local axes; what is unknown; and the laws of resampling."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import MappingError
from taskgist.importing import Track
from taskgist.importing.resampling import resample
from taskgist.world.geometry.transforms import about_z, matrix_from_euler, matrix_from_wxyz, rotate, slerp
from tests.importing.skeletons import (
    TIMES_S,
    Array,
    cup_position,
    cup_wxyz,
    keypoints,
    npz_mapping,
    tracks_of,
)

SEEDED = settings(derandomize=True, deadline=None, max_examples=25)
ONES = np.ones(3)

AXES = [
    tuple(sign + axis for sign, axis in zip(signs, order, strict=True))
    for order in itertools.permutations("xyz")
    for signs in itertools.product(("", "-"), repeat=3)
]
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254}


def axes_matrix(axes: tuple[str, ...]) -> Array:
    """Rows: our axes in the source's, as the mapping gives them."""
    rows = [(-1.0 if axis[0] == "-" else 1.0) * np.eye(3)["xyz".index(axis[-1])] for axis in axes]
    return np.array(rows)


@SEEDED
@given(
    axes=st.sampled_from(AXES),
    unit=st.sampled_from(sorted(UNITS)),
    yaw_deg=st.floats(-180, 180),
    shift=st.tuples(*[st.floats(-5, 5)] * 3),
)
def test_any_frame_of_the_source_gives_the_same_tracks(
    axes: tuple[str, ...],
    unit: str,
    yaw_deg: float,
    shift: tuple[float, float, float],
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """room = turn · axes · scale · source + shift, inverted by hand; reflections included."""
    folder = tmp_path_factory.mktemp("frame")
    to_room = matrix_from_wxyz(about_z(np.radians(yaw_deg))) @ axes_matrix(axes)

    def in_source(points: Array) -> Array:
        return np.asarray((points - shift) @ to_room / UNITS[unit])

    # a rotation seen in the source's axes, with the cup's own axes as the source names them
    own = np.diag((1.0, 1.0, np.linalg.det(to_room)))
    cup = to_room.T @ matrix_from_wxyz(cup_wxyz()) @ own
    pose = np.hstack([in_source(cup_position()), cup.reshape(-1, 9)])
    np.savez(folder / "data.npz", t=TIMES_S, body=in_source(keypoints()), cup=pose)
    x, y, z = axes
    frame = f"""units = "{unit}"
axes = {{ x = "{x}", y = "{y}", z = "{z}" }}
transform = {{ position_m = {list(shift)}, yaw_deg = {yaw_deg} }}"""
    text = npz_mapping(folder).replace('units = "m"', frame)
    text = text.replace('kind = "wxyz", columns = [3, 4, 5, 6]', 'kind = "matrix", columns = { first = 3 }')
    tracks = tracks_of(folder, text)
    np.testing.assert_allclose(tracks.people["P1"].points["pelvis"], keypoints()[:, 0, 0], atol=1e-7)
    np.testing.assert_allclose(tracks.objects["cup"].position_m, cup_position(), atol=1e-7)
    np.testing.assert_allclose(matrix_from_wxyz(tracks.objects["cup"].wxyz), matrix_from_wxyz(cup_wxyz()), atol=1e-7)


def test_local_axes_and_offsets_follow_the_body(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path).replace('pelvis = "PELVIS"', 'pelvis = { source = "things", point = "cup" }')
    text = text.replace('chest = "CHEST_SPINE"', 'chest = { mean = ["CHEST_SPINE", "NECK"] }')
    text = text.replace('[people.P2]\nlike = "P1"\nperson = 1\n', "")
    text += """
[people.P1.directions]
pelvis = { forward = "-y", up = [0.0, 0.0, 2.0] }
[objects.mark]
source = "things"
point = "cup"
offset_m = [0.1, 0.0, -0.2]
shape = { type = "sphere", radius_m = 0.01 }
"""
    tracks = tracks_of(tmp_path, text)
    person = tracks.people["P1"]
    np.testing.assert_allclose(person.directions["pelvis"], rotate(cup_wxyz(), (0.0, -1.0, 0.0)), atol=1e-9)
    np.testing.assert_allclose(person.directions["pelvis_up"], rotate(cup_wxyz(), (0.0, 0.0, 1.0)), atol=1e-9)
    expected = cup_position() + rotate(cup_wxyz(), (0.1, 0.0, -0.2))
    np.testing.assert_allclose(tracks.objects["mark"].position_m, expected, atol=1e-9)
    np.testing.assert_allclose(person.points["chest"], keypoints()[:, 0, [2, 3]].mean(axis=1), atol=1e-9)


def test_left_handed_shapes_are_mirrored(tmp_path: Path) -> None:
    """A shape that sticks out along the body's own z sticks out the same way in the room."""
    mirror = np.diag((1.0, 1.0, -1.0))
    matrices = (mirror @ matrix_from_wxyz(cup_wxyz()) @ mirror).reshape(-1, 9)
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=keypoints(), cup=np.hstack([cup_position() @ mirror, matrices]))
    text = npz_mapping(tmp_path)
    body, things = text.split("[sources.things]")
    things = things.replace('units = "m"', 'units = "m"\naxes = { z = "-z" }')
    things = things.replace('kind = "wxyz", columns = [3, 4, 5, 6]', 'kind = "matrix", columns = { first = 3 }')
    things = things.replace("length_m = 0.1", "length_m = 0.1, position_m = [0.01, 0.02, 0.03]")
    cup = tracks_of(tmp_path, f"{body}[sources.things]{things}").objects["cup"]
    centre = cup.position_m + rotate(cup.wxyz, cup.shapes[0].position_m)
    in_source = cup_position() @ mirror + (matrices.reshape(-1, 3, 3) @ (0.01, 0.02, 0.03))
    np.testing.assert_allclose(centre, in_source @ mirror, atol=1e-9)


def test_face_is_raised_by_the_given_angle(tmp_path: Path) -> None:
    plain = tracks_of(tmp_path, npz_mapping(tmp_path)).people["P1"].directions["face"]
    rule = '[people.P1.directions]\nhead = { from = ["left_ear", "right_ear"], to = ["nose", "left_eye", "right_eye"]'
    raised = tracks_of(tmp_path, npz_mapping(tmp_path) + rule + ", raise_deg = 10 }").people["P1"].directions["face"]
    np.testing.assert_allclose(np.arcsin(raised[:, 2]) - np.arcsin(plain[:, 2]), np.radians(10.0), atol=1e-9)
    np.testing.assert_allclose(np.arctan2(*raised[:, 1::-1].T), np.arctan2(*plain[:, 1::-1].T), atol=1e-9)


def test_unknown_is_nan_in_every_way_of_saying_so(tmp_path: Path) -> None:
    """NaN, a sentinel, and low confidence: unknown where they last longer than the gap, bridged where they do not."""
    body = keypoints()
    body[10:20, 0, 0] = np.nan
    body[10:20, 0, 3] = -1.0
    confidence = np.ones(body.shape[:3])
    confidence[10:20, 0, 2] = 0.2
    confidence[4:6, 0, 2] = np.nan
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=body, sure=confidence, cup=np.hstack([cup_position(), cup_wxyz()]))
    source = 'missing = [0, -1]\nconfidence = { column = "sure", least = 0.5 }'
    points = tracks_of(tmp_path, npz_mapping(tmp_path, source=source)).people["P1"].points
    for landmark in ("pelvis", "chest", "neck"):
        lost = np.isnan(points[landmark]).all(axis=1)
        np.testing.assert_array_equal(np.flatnonzero(lost), np.arange(10, 20), err_msg=landmark)
    np.testing.assert_allclose(points["chest"][4], keypoints()[[3, 6], 0, 2].T @ (2 / 3, 1 / 3), atol=1e-9)


def test_unknown_parts_are_not_read(tmp_path: Path) -> None:
    text = npz_mapping(tmp_path, people='unknown = { right_hand = "glove without markers", legs = "hidden" }')
    text = text.replace('right_wrist = "RIGHT_WRIST"', 'right_wrist = "NO_SUCH_POINT"')
    text += "[people.P2.points]\nright_wrist = 'RIGHT_WRIST'\n"
    tracks = tracks_of(tmp_path, text)
    assert dict(tracks.people["P1"].unknown) == {"right_hand": "glove without markers", "legs": "hidden"}
    assert not {"right_wrist", "right_fingertip", "left_knee"} & tracks.people["P1"].points.keys()
    assert "right_hand" not in tracks.people["P1"].directions
    assert "right_wrist" in tracks.people["P2"].points
    assert "P1: right_hand is unknown: glove without markers" in tracks.notes


def test_recording_can_be_cut_and_slowed(tmp_path: Path) -> None:
    top = "[time]\nrate_hz = 10\nstart_s = 0.2\nend_s = 0.8"
    tracks = tracks_of(tmp_path, npz_mapping(tmp_path, top=top))
    np.testing.assert_allclose(tracks.times_s, np.arange(7) / 10)
    assert tracks.start_s == pytest.approx(0.2)
    np.testing.assert_allclose(tracks.objects["cup"].position_m, cup_position()[6:25:3], atol=1e-9)


@st.composite
def clocks(draw: st.DrawFn) -> Array:
    steps = draw(st.lists(st.floats(0.005, 0.5), min_size=1, max_size=20))
    return np.concatenate([[0.0], np.cumsum(steps)])


@SEEDED
@given(times_s=clocks(), seed=st.integers(0, 1000))
def test_samples_survive_resampling_at_their_own_times(times_s: Array, seed: int) -> None:
    rng = np.random.default_rng(seed)
    position = rng.normal(size=(len(times_s), 3))
    wxyz = rng.normal(size=(len(times_s), 4))
    wxyz /= np.linalg.norm(wxyz, axis=1, keepdims=True)
    frames = resample(Track(times_s, position, wxyz, ONES, ""), times_s, max_gap_s=0.1)
    np.testing.assert_allclose(frames.position_m, position, atol=1e-9)
    assert frames.wxyz is not None
    np.testing.assert_allclose(np.abs(np.sum(frames.wxyz * wxyz, axis=1)), 1.0, atol=1e-9)


@SEEDED
@given(times_s=clocks(), rate_hz=st.floats(5, 200), max_gap_s=st.floats(0.0, 0.6))
def test_resampling_reproduces_steady_motion_and_bridges_no_gap(
    times_s: Array, rate_hz: float, max_gap_s: float
) -> None:
    velocity, spin = np.array([0.3, -1.0, 0.2]), 0.7
    wanted_s = np.arange(0.0, times_s[-1], 1 / rate_hz)
    wxyz = np.array([about_z(spin * time) for time in times_s])
    track = Track(times_s, velocity * times_s[:, None], wxyz, ONES, "")
    frames = resample(track, wanted_s, max_gap_s=max_gap_s)
    assert frames.wxyz is not None
    for frame, time in enumerate(wanted_s):
        after = int(np.searchsorted(times_s, time, side="right"))
        gap_s = times_s[after] - times_s[after - 1]
        nearest_s = np.abs(times_s - time).min()
        if gap_s <= max_gap_s:
            np.testing.assert_allclose(frames.position_m[frame], velocity * time, atol=1e-9)
            assert abs(frames.wxyz[frame] @ about_z(spin * time)) == pytest.approx(1.0, abs=1e-9)
        elif nearest_s > np.median(np.diff(times_s)) / 2 + 1e-9:
            assert np.isnan(frames.position_m[frame]).all()


def test_nothing_is_known_outside_of_the_samples() -> None:
    track = Track(np.array([1.0, 1.1, 1.2]), np.ones((3, 3)), None, ONES, "")
    frames = resample(track, np.array([0.9, 0.96, 1.0, 1.24, 1.3]), max_gap_s=0.2)
    np.testing.assert_array_equal(np.isfinite(frames.position_m[:, 0]), [False, True, True, True, False])


def test_a_track_that_was_never_seen_is_unknown() -> None:
    track = Track(np.array([0.0, 0.1]), np.full((2, 3), np.nan), np.full((2, 4), np.nan), ONES, "")
    frames = resample(track, np.array([0.0, 0.05]), max_gap_s=0.2)
    assert np.isnan(frames.position_m).all()
    assert frames.wxyz is not None
    assert np.isnan(frames.wxyz).all()


@SEEDED
@given(angles=st.tuples(*[st.floats(-3, 3)] * 3), order=st.sampled_from(["xyz", "zyx", "yxz", "zxz"]))
def test_moving_axes_are_fixed_axes_in_reverse(angles: tuple[float, float, float], order: str) -> None:
    moving = matrix_from_euler(np.array(angles), order, intrinsic=True)
    fixed = matrix_from_euler(np.array(angles[::-1]), order[::-1], intrinsic=False)
    np.testing.assert_allclose(moving, fixed, atol=1e-12)
    np.testing.assert_allclose(moving @ moving.T, np.eye(3), atol=1e-12)


@SEEDED
@given(angle=st.floats(-3.1, 3.1), share=st.floats(0, 1), sign=st.sampled_from([-1.0, 1.0]))
def test_slerp_turns_by_the_share_of_the_angle(angle: float, share: float, sign: float) -> None:
    mixed = slerp(about_z(0.0)[None], sign * about_z(angle)[None], np.array([share]))[0]
    assert abs(mixed @ about_z(share * angle)) == pytest.approx(1.0, abs=1e-9)


def lost_for_a_while(folder: Path, rotation: str) -> str:
    """A cup whose tracker reports no turn at all in three samples, in axes that are not ours."""
    wxyz = cup_wxyz()
    wxyz[20:23] = (1.0, 0.0, 0.0, 0.0)
    np.savez(folder / "data.npz", t=TIMES_S, body=keypoints(), cup=np.hstack([cup_position(), wxyz]))
    kind = 'kind = "wxyz", columns = [3, 4, 5, 6]'
    return npz_mapping(folder, top="[time]\nmax_gap_s = 0.01").replace(kind, f"{kind}{rotation}")


def test_no_turn_at_all_is_asked_about(tmp_path: Path) -> None:
    with pytest.raises(
        MappingError,
        match=r"rotation: is no turn at all in 3 of \d+ samples, and turned by \d+° in the next; add identity_is_",
    ):
        tracks_of(tmp_path, lost_for_a_while(tmp_path, ""))


def test_no_turn_at_all_is_a_lost_tracker_or_meant(tmp_path: Path) -> None:
    lost = tracks_of(tmp_path, lost_for_a_while(tmp_path, ", identity_is_lost = true"))
    meant = tracks_of(tmp_path, lost_for_a_while(tmp_path, ", identity_is_lost = false"))
    assert meant.objects["cup"].known.all()
    unknown = lost.times_s[~lost.objects["cup"].known] + TIMES_S[0]
    assert len(unknown) >= 1
    assert TIMES_S[19] < unknown.min() <= unknown.max() < TIMES_S[23]


def test_who_never_turns_was_not_lost(tmp_path: Path) -> None:
    wxyz = cup_wxyz()
    wxyz[:] = (1.0, 0.0, 0.0, 0.0)
    np.savez(tmp_path / "data.npz", t=TIMES_S, body=keypoints(), cup=np.hstack([cup_position(), wxyz]))
    assert tracks_of(tmp_path, npz_mapping(tmp_path)).objects["cup"].known.all()
