"""Robots in recordings: bases by frames of tf or tables, joints by what was published, and what cannot be is told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing import import_recording, load_mapping, look, mapping_text
from taskgist.observe import Observer
from taskgist.recording import Recording
from taskgist.world.geometry.transforms import about_z
from tests.importing.skeletons import Array
from tests.importing.takes import TIMES_S
from tests.importing.test_bags import START_NS, header, messages, ros2, transform

JOINTS = ("head_pan", "head_tilt", "arm_1", "arm_2", "arm_3", "arm_4", "arm_5", "arm_6", "arm_7")
YAW_RAD = 0.4
PLACES = np.column_stack([1.5 + 0.1 * TIMES_S, -0.5 + 0.0 * TIMES_S])


def angles() -> Array:
    """Of Jido's joints over time, radians, (frames, 9)."""
    return np.array([0.1 * np.arange(1, 10) * 0.5 * time_s for time_s in TIMES_S])


def with_jido(types: Any) -> list[tuple[str, str, int, Any]]:
    """A person and a cup, and a Jido that drives ahead and moves all its joints."""
    tree, kind = types["tf2_msgs/msg/TFMessage"], "sensor_msgs/msg/JointState"
    found = messages(types)
    for k, row in enumerate(angles()):
        at = START_NS + int(1e9 * TIMES_S[k])
        base = transform(types, "world", "base_footprint", at, np.array((*PLACES[k], 0.0)), about_z(YAW_RAD))
        found.append(("/tf", "tf2_msgs/msg/TFMessage", at, tree([base])))
        none = np.zeros(0)
        state = types[kind](header(types, "", at), [*JOINTS, "wheel"], np.array([*row, 9.0]), none, none)
        found.append(("/joint_states", kind, at, state))
    return sorted(found, key=lambda message: message[2])


def assert_moves_as_published(recording: Recording, name: str) -> None:
    scene = recording.scene
    base = recording.qpos[:, scene.base_slice(name)]
    np.testing.assert_allclose(base[:, :2], PLACES[: len(base)], atol=1e-3)
    np.testing.assert_allclose(base[:, 3:], np.tile(about_z(YAW_RAD), (len(base), 1)), atol=1e-6)
    np.testing.assert_allclose(recording.qpos[:, scene.joint_indices(name)], angles()[: len(base)], atol=1e-3)


def test_a_robot_of_a_bag_is_recognised_and_moves(tmp_path: Path) -> None:
    pytest.importorskip("rosbags")
    path = ros2(tmp_path, with_jido)
    proposal = look(path)
    assert proposal.robots == {"jido": "base_footprint"}
    assert proposal.loose == ()
    text = mapping_text(proposal, path.name)
    (tmp_path / "m.toml").write_text(text.replace("# shape", "shape"), encoding="utf-8")
    recording = import_recording(load_mapping(tmp_path / "m.toml"))
    assert set(recording.scene.agents) == {"P17", "jido"}
    assert_moves_as_published(recording, "jido")
    status = Observer(recording.scene, recording).hand("jido", "right").at(float(recording.times_s[-1]))
    assert status is not None
    assert status.symbol == "Free_of_Object"


def tables(folder: Path, *, joints: tuple[str, ...] = JOINTS, scale: float = 180.0 / np.pi) -> None:
    base = np.column_stack([TIMES_S, PLACES, 0 * TIMES_S, np.tile(about_z(YAW_RAD), (len(TIMES_S), 1))])
    np.savetxt(folder / "base.csv", base, delimiter=",", header="t,x,y,z,qw,qx,qy,qz", comments="")
    rows = np.column_stack([TIMES_S, scale * angles()[:, : len(joints)]])
    columns = ["t", *(f"position.{name}" for name in joints)]
    np.savetxt(folder / "joints.csv", rows, delimiter=",", header=",".join(columns), comments="")


MAPPING = """
[sources.base]
file = "base.csv"
time = { column = "t", unit = "s" }
units = "m"
rotation = { kind = "wxyz", columns = "q{axis}" }
[sources.joints]
file = "joints.csv"
time = { column = "t", unit = "s" }
units = "m"
[robots.R1]
profile = "jido"
source = "base"
point = "base"
joints = { source = "joints", column = "position.{joint}", unit = "deg" }
"""


def imported(folder: Path, text: str) -> Recording:
    (folder / "m.toml").write_text(text, encoding="utf-8")
    return import_recording(load_mapping(folder / "m.toml"))


def test_a_robot_of_tables_moves(tmp_path: Path) -> None:
    tables(tmp_path)
    recording = imported(tmp_path, MAPPING)
    assert_moves_as_published(recording, "R1")
    assert not recording.provenance.notes


def test_joints_that_nobody_published_stay_at_rest_and_are_told(tmp_path: Path) -> None:
    tables(tmp_path, joints=JOINTS[:4])
    text = MAPPING.replace('source = "base"\npoint = "base"\n', "fixed = { position_m = [1, 2, 0], yaw_deg = 90 }\n")
    recording = imported(tmp_path, text)
    (note,) = recording.provenance.notes
    assert note == "R1: nobody published 5 of its joints, which stay at rest: arm_3, arm_4, arm_5, arm_6, arm_7"
    scene = recording.scene
    columns = scene.joint_indices("R1")
    np.testing.assert_allclose(recording.qpos[:, columns[:4]], angles()[:, :4], atol=1e-6)
    np.testing.assert_allclose(recording.qpos[-1, columns[4:]], scene.initial.qpos[columns[4:]], atol=1e-9)
    np.testing.assert_allclose(recording.qpos[0, scene.base_slice("R1")][:2], (1.0, 2.0))


def test_a_robot_that_is_lost_is_unknown(tmp_path: Path) -> None:
    tables(tmp_path)
    lines = (tmp_path / "joints.csv").read_text(encoding="utf-8").splitlines()
    (tmp_path / "joints.csv").write_text("\n".join(lines[:7]) + "\n", encoding="utf-8")
    recording = imported(tmp_path, MAPPING.replace("[robots", "[time]\nmax_gap_s = 0.05\n[robots"))
    assert recording.tracked["R1"].sum() == 6
    assert any("R1 is unknown in" in note for note in recording.provenance.notes)


MISTAKES = {
    "unit": ('unit = "deg"', 'unit = "rad"', MappingError, r"R1.joints: head_pan: beyond its joint .*check unit"),
    "profile": ('"jido"', '"jiddo"', UnknownNameError, r"robots.R1.profile: no profile 'jiddo'; did you mean 'jido'"),
    "column": ("position.{joint}", "{joint}", MappingError, r"none of its joints is in the source.*position.arm_1"),
    "template": ("position.{joint}", "position", MappingError, r"joints.column: must hold {joint}"),
    "turn": ('rotation = { kind = "wxyz", columns = "q{axis}" }', "", MappingError, "which way it faces"),
    "source": ('source = "joints"', 'source = "joint"', UnknownNameError, "no source 'joint'; did you mean 'joints'"),
    "pose": ('source = "base"\npoint = "base"', "", MappingError, "the robot has no pose"),
    "file": ('"jido"', '"mine.toml"', MappingError, "the profile does not exist.*mine.toml"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes(mistake: str, tmp_path: Path) -> None:
    old, new, kind, message = MISTAKES[mistake]
    tables(tmp_path, scale=500.0 if mistake == "unit" else 180.0 / np.pi)
    assert old in MAPPING
    with pytest.raises(kind, match=message):
        imported(tmp_path, MAPPING.replace(old, new))
