"""A fitted trunk leans as the tracked one does, and not to bring a face where the body's own is not."""

from pathlib import Path

import numpy as np
import pytest

from taskgist.importing import import_recording, load_mapping
from taskgist.recording import Recording
from taskgist.world import Stage
from tests.importing.poses import POSES, imported
from tests.importing.skeletons import Array

FEET = ("knee", "ankle", "heel", "toe")


def off_deg(recording: Recording, pose: str) -> Array:
    """Angle between the fitted and the true line from the hips to the shoulders, (frames,)."""
    true = (POSES[pose]["LEFT_SHOULDER"] + POSES[pose]["RIGHT_SHOULDER"]) / 2 - POSES[pose]["PELVIS"]
    stage = Stage(recording.scene)

    def place(name: str) -> Array:
        return stage.site(recording.scene.model.site(f"P1/{name}").id).position

    angles = []
    for frame in range(len(recording)):
        stage.show(recording.state(frame))
        line = (place("left_shoulder") + place("right_shoulder")) / 2 - place("pelvis")
        angles.append(np.degrees(np.arccos(line @ true / np.linalg.norm(line) / np.linalg.norm(true))))
    return np.array(angles)


def joint_deg(recording: Recording, name: str) -> Array:
    scene = recording.scene
    return np.degrees(recording.qpos[:, scene.joint_indices("P1")][:, scene.joints("P1").index(name)])


def pitch_deg(recording: Recording) -> Array:
    """How far the pelvis is pitched forward, (frames,)."""
    stage = Stage(recording.scene)
    root = recording.scene.agent("P1").root_body
    return np.degrees(
        [np.arcsin(-stage.show(recording.state(frame)).body_axis(root, 0)[2]) for frame in range(len(recording))]
    )


@pytest.mark.parametrize("noise_m", [0.0, 0.01, 0.02])
def test_somebody_upright_is_fitted_upright(tmp_path: Path, noise_m: float) -> None:
    recording = imported(tmp_path, POSES["upright"], noise_m=noise_m)
    assert np.median(np.abs(joint_deg(recording, "torso_lean"))) < 5.0
    assert np.median(np.abs(pitch_deg(recording))) < 3.0
    assert recording.provenance.fit["P1"]["points_cm"]["left_wrist"]["median"] < 2.0


@pytest.mark.parametrize("noise_m", [0.0, 0.02])
@pytest.mark.parametrize("pose", POSES)
def test_shoulders_are_over_the_hips_as_tracked(tmp_path: Path, pose: str, noise_m: float) -> None:
    off = off_deg(imported(tmp_path, POSES[pose], noise_m=noise_m), pose)
    assert np.median(off) < 3.0
    assert np.percentile(off, 95) < 6.0


def test_who_leans_leans_and_who_lies_lies(tmp_path: Path) -> None:
    """A little with the back, farther with the hips; a pelvis lies with the rest."""
    assert np.median(joint_deg(imported(tmp_path, POSES["leaning 20"]), "torso_lean")) == pytest.approx(20.0, abs=3.0)
    assert 10.0 < np.median(pitch_deg(imported(tmp_path, POSES["leaning 45"]))) < 35.0
    for pose, sign in (("lying on the back", -1.0), ("lying on the belly", 1.0)):
        assert np.median(sign * pitch_deg(imported(tmp_path, POSES[pose]))) > 80.0


@pytest.mark.parametrize("pose", ["upright", "leaning 45", "bending 75"])
def test_without_legs_the_same(tmp_path: Path, pose: str) -> None:
    recording = imported(tmp_path, POSES[pose], noise_m=0.01, without=FEET)
    assert np.median(off_deg(recording, pose)) < 3.0
    stage, agent = Stage(recording.scene), recording.scene.agent("P1")
    stage.show(recording.state(5))
    for thigh in agent.thigh_bodies:  # estimated legs do not tilt with the pelvis
        assert stage.body_axis(thigh, 2)[2] > np.cos(np.radians(30.0))


def test_a_lost_shoulder_does_not_free_the_pelvis(tmp_path: Path) -> None:
    recording = imported(tmp_path, POSES["upright"])
    points = np.load(tmp_path / "points.npz")["points"]
    points[8:14, 5] = np.nan  # LEFT_SHOULDER
    np.savez(tmp_path / "points.npz", points=points)

    lost = import_recording(load_mapping(tmp_path / "mapping.toml"))
    assert np.abs(pitch_deg(lost) - pitch_deg(recording)).max() < 2.0
