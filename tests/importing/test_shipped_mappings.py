"""The shipped mappings of the KTH handovers, on made-up files of the same layout."""

from __future__ import annotations

from importlib.resources import as_file, files
from pathlib import Path

import numpy as np
import pytest

from taskgist.errors import MappingError
from taskgist.importing import ImportMapping, load_mapping, read_tracks
from taskgist.world.geometry.transforms import about_z
from tests.importing.skeletons import NAMES, Array, standing, write_csv

BONES = {
    "head": "HEAD",
    "neck": "NECK",
    "chest": "CHEST_SPINE",
    "ab": "NAVAL_SPINE",
    "hip": "PELVIS",
    **{
        f"{side[0]}{bone}": f"{side}_{point}"
        for side in ("LEFT", "RIGHT")
        for bone, point in (("UArm", "SHOULDER"), ("FArm", "ELBOW"), ("Hand", "WRIST"))
    },
}
ROWS = 81


def make_folder(folder: Path, *, copied_hands: bool) -> None:
    folder.mkdir()
    for person, x_m, yaw_rad in (("giver", -0.6, 0.0), ("taker", 0.6, np.pi)):
        # bones look along their own -y: a person who looks along x has turned by +90 degrees
        for bone, point in BONES.items():
            name = "LEFT_WRIST" if copied_hands and bone == "RHand" else point
            position = standing()[NAMES.index(name)] * (np.cos(yaw_rad), np.cos(yaw_rad), 1.0) + (x_m, 0.0, 0.0)
            _write_pose(folder / f"{person}_{bone}_pose_saved.csv", position, yaw_rad + np.pi / 2)
        force = np.linspace(0.0, -20.0, ROWS)[:, None]
        write_csv(folder / f"Wrench_{person}_saved.csv", ["Fx", "Fy", "Fz"], np.hstack([0 * force, 0 * force, force]))
    _write_pose(folder / "baton_pose_saved.csv", np.array([-0.2, -0.4, 0.813]), 0.0)


def _write_pose(file: Path, position: Array, yaw_rad: float) -> None:
    sway = 0.01 * np.sin(np.arange(ROWS) / 20)[:, None] * (1.0, 0.0, 0.0)
    w, x, y, z = about_z(yaw_rad)
    write_csv(
        file, ["x", "y", "z", "q0", "q1", "q2", "q3"], np.hstack([position + sway, np.tile((x, y, z, w), (ROWS, 1))])
    )


def shipped(name: str, data: Path, **parameters: str) -> ImportMapping:
    with as_file(files("taskgist") / "data" / "mappings") as folder:
        return load_mapping(folder / f"{name}.toml", data_dir=data, parameters=parameters)


def test_kth_handovers(tmp_path: Path) -> None:
    make_folder(tmp_path / "take", copied_hands=False)
    mapping = shipped("kth_handovers", tmp_path, folder="take")
    tracks = read_tracks(mapping)
    assert mapping.name == "handover take"
    assert len(tracks.times_s) == 1 + (ROWS - 1) // 4, "120 Hz come out at 30 Hz"
    assert "MIT" in mapping.about.licence
    assert any(note.startswith("table is estimated") for note in tracks.notes)
    for name, towards in (("P1", 1.0), ("P2", -1.0)):
        person = tracks.people[name]
        for direction in ("face", "chest", "pelvis"):
            np.testing.assert_allclose(person.directions[direction][0], (towards, 0, 0), atol=1e-9)
        # arms hang in T: left fingers along x of a bone that looks along -y, so to the person's left
        np.testing.assert_allclose(person.directions["left_hand"][0], (0, towards, 0), atol=1e-9)
        np.testing.assert_allclose(person.directions["right_hand"][0], (0, -towards, 0), atol=1e-9)
        np.testing.assert_allclose(person.directions["right_palm"][0], (0, 0, -1), atol=1e-9)
    grip = tracks.signals["P2_grip"]
    assert (grip.unit, grip.values[0], grip.values[-1]) == ("N", 0.0, 20.0), "a grip presses: -Fz"
    table, baton = tracks.supports[0], tracks.objects["baton"]
    top_m = table.position_m[2] + table.size_m[2] / 2
    assert baton.position_m[0, 2] - baton.shapes[0].size_m[2] / 2 == pytest.approx(top_m, abs=0.002)


def test_copied_hands(tmp_path: Path) -> None:
    make_folder(tmp_path / "sample_old", copied_hands=True)
    with pytest.raises(MappingError, match=r"P1.left_wrist and P1.right_wrist"):
        read_tracks(shipped("kth_handovers", tmp_path, folder="sample_old"))
    tracks = read_tracks(shipped("kth_sample_old", tmp_path))
    for person in tracks.people.values():
        assert "right_hand" in person.unknown
        assert "right_wrist" not in person.points
        assert "right_elbow" in person.points
