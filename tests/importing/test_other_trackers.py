"""Noisy bare keypoints of somebody else's tracker: who held what when comes out, and what cannot be right is said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import import_recording, load_mapping, read_tracks
from taskgist.observe import Observer
from taskgist.recognition import grips_of, propose_label
from taskgist.recording import Recording
from taskgist.world import Stage
from tests.importing import noisy_handover as truth
from tests.importing.skeletons import NAMES, POINTS, Array, mapping_file

Layout = Callable[[Path, Array, Array], str]
TO_RIGHT_HANDED_Y_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]])
TO_LEFT_HANDED_Y_UP = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
HANDS = "".join(
    f'{side}_{ours} = "{side.upper()}_{theirs}"\n'
    for side in ("left", "right")
    for ours, theirs in (("hand", "HAND"), ("thumb", "THUMB"), ("hip", "HIP"))
)
FEET = "".join(
    f'{side}_{ours} = "{side.upper()}_{theirs}"\n'
    for side in ("left", "right")
    for ours, theirs in (("heel", "HEEL"), ("toe", "FOOT"))
)
REST = f"""
[people.P1]
source = "body"
person = "7"
[people.P1.points]
{POINTS}{HANDS}{FEET}
[people.P2]
like = "P1"
person = "3"
[objects.mug]
source = "mug"
shape = {{ type = "cylinder", radius_m = {truth.MUG_RADIUS_M}, length_m = {truth.MUG_LENGTH_M} }}
[supports.table]
size_m = [0.4, 0.8, 0.04]
position_m = [-0.2, 0.0, {truth.TABLE_TOP_M - 0.02}]
"""


def long_table(folder: Path, points: Array, mug: Array, *, smooth_s: float = 0.2, missing: str = "missing = 0") -> str:
    """Left-handed, y up, nanoseconds, a row per body and keypoint in any order, 0, 0, 0 for what is lost."""
    rng = np.random.default_rng(1)
    rows = ["ts;body;joint;x;y;z"]
    for frame, time_s in enumerate(truth.TIMES_S):
        for person in rng.permutation(2):
            for name, point in zip(NAMES, points[frame, person] @ TO_LEFT_HANDED_Y_UP.T, strict=True):
                x, y, z = np.nan_to_num(point)
                rows.append(f"{int(1.7e18 + 1e9 * time_s)};{(7, 3)[person]};{name};{x:.4f};{y:.4f};{z:.4f}")
    (folder / "body.csv").write_text("\n".join(rows), encoding="utf-8")
    return f"""
[time]
max_gap_s = 0.5
[sources.body]
file = "body.csv"
time = {{ column = "ts", unit = "ns" }}
offset_s = -1.7e9
units = "m"
axes = {{ x = "z", y = "-x", z = "y" }}
where = {{ body = "{{person}}", joint = "{{point}}" }}
smooth_s = {smooth_s}
{missing}
{mug_source(folder, mug)}{REST}"""


def wide_table(folder: Path, points: Array, mug: Array, *, smooth_s: float = 0.2) -> str:
    """Right-handed, y up, millimetres, milliseconds, NaN for what is lost."""
    names = [f"{body}_{name}_{axis}" for body in (7, 3) for name in NAMES for axis in "xyz"]
    values = (points @ TO_RIGHT_HANDED_Y_UP.T * 1000).reshape(len(points), -1)
    rows = [",".join(["ms", *names])]
    rows += [
        ",".join([f"{1000 * t:.1f}", *(f"{x:.2f}" for x in row)]) for t, row in zip(truth.TIMES_S, values, strict=True)
    ]
    (folder / "body.csv").write_text("\n".join(rows), encoding="utf-8")
    return f"""
[time]
max_gap_s = 0.5
[sources.body]
file = "body.csv"
time = {{ column = "ms", unit = "ms" }}
units = "mm"
axes = {{ x = "-z", y = "-x", z = "y" }}
position = "{{person}}_{{point}}_{{axis}}"
smooth_s = {smooth_s}
{mug_source(folder, mug)}{REST}"""


def mug_source(folder: Path, mug: Array) -> str:
    """Poses as 4 × 4 matrices with a clock of their own."""
    poses = np.tile(np.eye(4), (len(mug), 1, 1))
    poses[:, :3, 3] = mug
    np.savez(folder / "mug.npz", pose=poses, t=truth.TIMES_S + 3.25)
    return """
[sources.mug]
file = "mug.npz"
array = "pose"
layout = ["time", "value", "value"]
time = { column = "t", unit = "s" }
offset_s = -3.25
units = "m"
position = [3, 7, 11]
rotation = { kind = "matrix", columns = [0, 1, 2, 4, 5, 6, 8, 9, 10] }
smooth_s = 0.2
"""


def imported(folder: Path, text: str) -> Recording:
    return import_recording(load_mapping(mapping_file(folder, text)))


@pytest.fixture(scope="module")
def hidden(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, Observer]:
    """15 mm of noise; wrists hidden for 0.3 s while the mug changes hands; gaps so long are not bridged."""
    folder = tmp_path_factory.mktemp("hidden")
    seen = truth.handover(noise_m=0.015, hidden_s=(1.6, 1.93))
    text = long_table(folder, seen.keypoints, seen.mug).replace("max_gap_s = 0.5", "max_gap_s = 0.2")
    recording = imported(folder, text)
    return recording, Observer(recording.scene, recording)


@pytest.mark.parametrize("layout", [long_table, wide_table])
def test_who_held_the_mug_when(tmp_path: Path, layout: Layout) -> None:
    seen = truth.handover(noise_m=0.01, hidden_s=(1.6, 1.9), seed=3)
    recording = imported(tmp_path, layout(tmp_path, seen.keypoints, seen.mug))
    observer = Observer(recording.scene, recording)
    first, second = grips_of(observer, "mug")
    assert (first.agent, first.side, second.agent, second.side) == ("P1", "right", "P2", "right")
    assert truth.LIFTED_S <= first.start_s < truth.LIFTED_S + 0.25
    # Both hands are around it for 0.4 s: it changes hands in between.
    assert first.end_s == pytest.approx((truth.TAKEN_S + truth.LET_GO_S) / 2, abs=0.1)
    assert second.start_s == pytest.approx((truth.TAKEN_S + truth.LET_GO_S) / 2, abs=0.1)
    label = propose_label(recording, observer)
    assert (label.task, label.performing_agent, label.target_agent) == ("give", "P1", "P2")


def test_a_label_ends_where_the_object_is_known_again(hidden: tuple[Recording, Observer]) -> None:
    recording, observer = hidden
    label = propose_label(recording, observer, task="give")
    while_hidden, at_end = (observer.placement("mug").at(time_s) for time_s in (1.75, label.end_s))
    assert while_hidden is not None
    assert while_hidden.symbol is None
    assert at_end is not None
    assert at_end.symbol == "In_Hand"
    assert label.end_s < truth.LET_GO_S + 0.3


def test_a_hidden_arm_stays_as_it_was_seen_last(hidden: tuple[Recording, Observer]) -> None:
    recording, _ = hidden
    lost = np.flatnonzero(~recording.tracked["P1/right_arm"])
    scene = recording.scene
    arm = [k for k, joint in enumerate(scene.joints("P1")) if joint.startswith("right_shoulder")]
    angles = recording.qpos[:, scene.joint_indices("P1")][:, arm]
    assert len(lost) >= 5
    assert np.abs(angles[lost[-1]] - angles[lost[0] - 1]).max() < np.radians(10.0)


def test_a_head_is_known_while_three_of_its_points_are(hidden: tuple[Recording, Observer]) -> None:
    recording, _ = hidden
    assert not {"P1/head", "P2/head"} & recording.tracked.keys()


def test_bent_fingers_do_not_turn_the_hand(tmp_path: Path) -> None:
    """While they close around the mug, the hand still points ahead, and the palm faces the mug."""
    seen = truth.handover()
    recording = imported(tmp_path, wide_table(tmp_path, seen.keypoints, seen.mug))
    stage = Stage(recording.scene).show(recording.at(1.2))
    hand = stage.body(recording.scene.agent("P1").arm("right").hand_body)
    assert -hand.matrix[0, 2] > np.cos(np.radians(15.0))
    assert hand.matrix[1, 1] > np.cos(np.radians(15.0))


def test_forgotten_zeros_are_noticed(tmp_path: Path) -> None:
    seen = truth.handover(noise_m=0.01)
    text = long_table(tmp_path, seen.keypoints, seen.mug, missing="")
    with pytest.raises(
        MappingError, match=r"body.csv, line \d+: position: is 0, 0, 0 in 18 of 100.*add missing = 0 to .sources.body"
    ):
        read_tracks(load_mapping(mapping_file(tmp_path, text)))
    meant = long_table(tmp_path, seen.keypoints, seen.mug, missing="missing = []", smooth_s=0.0)
    nose = read_tracks(load_mapping(mapping_file(tmp_path, meant))).people["P1"].points["nose"]
    assert (np.abs(nose) < 1e-9).all(axis=1).sum() >= 16


def test_a_point_may_pass_through_the_origin(tmp_path: Path) -> None:
    seen = truth.handover()
    mug = seen.mug - seen.mug[50]
    text = wide_table(tmp_path, seen.keypoints, mug)
    read_tracks(load_mapping(mapping_file(tmp_path, text)))


@pytest.mark.parametrize("layout", [long_table, wide_table])
def test_axes_that_mirror_are_noticed(tmp_path: Path, layout: Layout) -> None:
    """The same numbers, called right-handed where they are left-handed, or the other way round."""
    seen = truth.handover(noise_m=0.01)
    text = layout(tmp_path, seen.keypoints, seen.mug)
    wrong = (
        text.replace('x = "-z", y = "-x"', 'x = "z", y = "-x"')
        if layout is wide_table
        else text.replace('x = "z"', 'x = "-z"')
    )
    with pytest.raises(MappingError, match=r"people.P1: the person faces backwards.*left-handed"):
        read_tracks(load_mapping(mapping_file(tmp_path, wrong)))


def test_somebody_who_looks_back_for_a_while_is_not_mirrored(tmp_path: Path) -> None:
    keypoints = truth.handover().keypoints.copy()
    head = [NAMES.index(name) for name in ("NOSE", "LEFT_EYE", "RIGHT_EYE", "LEFT_EAR", "RIGHT_EAR")]
    middle = keypoints[:, 0, [NAMES.index("HEAD")]] * (1.0, 1.0, 0.0)
    keypoints[:, 0, head] = (keypoints[:, 0, head] - middle) * (-1.0, -1.0, 1.0) + middle
    read_tracks(load_mapping(mapping_file(tmp_path, wide_table(tmp_path, keypoints, truth.handover().mug))))


def test_clocks_that_differ_are_named(tmp_path: Path) -> None:
    seen = truth.handover()
    text = long_table(tmp_path, seen.keypoints, seen.mug).replace("offset_s = -1.7e9", "")
    with pytest.raises(MappingError, match=r"time: .*clocks differ.*mug.npz.*3.300 s.*body.csv.*1700000000.*offset_s"):
        read_tracks(load_mapping(mapping_file(tmp_path, text)))
