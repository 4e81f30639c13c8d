"""People off the floor, lying, turning round: told where something is odd, refused where it is wrong."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import import_recording, load_mapping, read_tracks
from taskgist.pipeline import check
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz
from tests.importing.poses import POSES, imported
from tests.importing.skeletons import NAMES, Array

SIDES = [(NAMES.index(name), NAMES.index(name.replace("LEFT", "RIGHT"))) for name in NAMES if name.startswith("LEFT")]


def changed(folder: Path, points: Array) -> Path:
    """The mapping of somebody upright, for other points, (frames, 34, 3)."""
    imported(folder, POSES["upright"])
    np.savez(folder / "points.npz", points=points)
    return folder / "mapping.toml"


def upright(frames: int = 20) -> Array:
    return np.tile([POSES["upright"][name] for name in NAMES], (frames, 1, 1))


@pytest.mark.parametrize(
    ("up_m", "said", "severity"),
    [
        (-0.92, r"P1: the soles are 0.[89]\d m under the floor .*position_m = \[0, 0, 0.[89]\d\]", "unfit"),
        (0.70, r"P1: the soles are 0.7\d m over the floor .*position_m = \[0, 0, -0.7\d\]", "unfit"),
        (0.20, r"P1: the soles are 0.2\d m over the floor .*position_m = \[0, 0, -0.2\d\]", "warning"),
        (0.12, r"P1: the soles are 0.1\d m over the floor .*position_m = \[0, 0, -0.1\d\]", "warning"),
    ],
)
def test_people_off_the_floor(tmp_path: Path, up_m: float, said: str, severity: str) -> None:
    recording = import_recording(load_mapping(changed(tmp_path, upright() + (0.0, 0.0, up_m))))
    (note,) = (note for note in recording.provenance.notes if "floor" in note)
    assert re.search(said, note), note
    (finding,) = (finding for finding in check(recording).findings if "soles" in finding.problem)
    assert (finding.severity, finding.about) == (severity, "P1")
    there = import_recording(load_mapping(changed(tmp_path, upright())))
    assert recording.scene.agent("P1").stature_m == pytest.approx(there.scene.agent("P1").stature_m, abs=0.02)


@pytest.mark.parametrize("pose", POSES)
def test_nobody_else_is_told_so(tmp_path: Path, pose: str) -> None:
    recording = imported(tmp_path, POSES[pose])
    assert not any("floor" in note for note in recording.provenance.notes)
    assert any("lies" in note for note in recording.provenance.notes) == pose.startswith("lying")


@pytest.mark.parametrize("axis", [0, 1])
def test_axes_exchanged_are_no_lying_person(tmp_path: Path, axis: int) -> None:
    """Somebody upright 2.5 m before a camera, whose other axis is called up."""
    points = upright() + (2.5, 0.0, 0.0)
    turned = points[..., [1, 2, 0]] if axis == 0 else points[..., [2, 0, 1]] - (0.0, 0.0, 0.3)
    with pytest.raises(MappingError, match="the head is not"):
        read_tracks(load_mapping(changed(tmp_path, turned)))


def test_upside_down_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MappingError, match="the head is not above the trunk"):
        read_tracks(load_mapping(changed(tmp_path, upright() * (1.0, 1.0, -1.0) + (0.0, 0.0, 1.7))))


def test_somebody_who_turns_round_is_not_mirrored(tmp_path: Path) -> None:
    """Rightly tracked all the time; or with the sides exchanged while the back is seen, for most of the time."""
    frames = 40
    yaws = np.interp(np.arange(frames), [0, 8, 14, frames], [0.0, 0.0, np.pi, np.pi])
    turns = [matrix_from_wxyz(about_z(yaw)) for yaw in yaws]
    turning = np.stack([body @ turn.T for body, turn in zip(upright(frames), turns, strict=True)])
    read_tracks(load_mapping(changed(tmp_path, turning)))
    exchanged = turning.copy()
    for left, right in SIDES:
        exchanged[12:, [left, right]] = turning[12:, [right, left]]
    read_tracks(load_mapping(changed(tmp_path, exchanged)))


def test_sides_that_are_always_exchanged_are_refused(tmp_path: Path) -> None:
    points = upright()
    for left, right in SIDES:
        points[:, [left, right]] = points[:, [right, left]]
    with pytest.raises(MappingError, match="faces backwards"):
        read_tracks(load_mapping(changed(tmp_path, points)))
