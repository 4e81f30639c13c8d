"""The files of ``taskgist perform``: all that is asked for, whole, and refused before any long work."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import matplotlib.image
import numpy as np
import pytest
from PIL import Image

from taskgist.pipeline import shipped_room
from taskgist.recording import read
from taskgist.store import save
from taskgist.view import performance
from tests.cli.running import Result, refusal, run_json
from tests.schemas import hold_to_schema
from tests.shipped import knowledge

FILES = {
    "recording": "--out done.mcap",
    "trajectory": "--trajectory arm.json",
    "plan": "--plan plan.json",
    "positions": "--positions all.npz",
    "picture": "--picture moments.png",
    "film": "--film film.webp",
}
ASKED = f"perform hide {shipped_room()} -k k.db --robot Jido --for P2 --object cup"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("performed")
    save(knowledge("hide"), path / "k.db")
    return path


@pytest.fixture(scope="module")
def document(folder: Path) -> Any:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for name in ("PICTURE_WIDTH_PX", "FILM_WIDTH_PX", "CHOOSING_WIDTH_PX"):
            patch.setattr(performance, name, 120)
        patch.setattr(performance, "MOST_FRAMES", 4)
        return run_json(f"{ASKED} {' '.join(FILES.values())}")


def test_every_file_is_written_and_named(folder: Path, document: Any) -> None:
    (way,) = document["ways"]
    assert way["files"] == {name: option.split()[1] for name, option in FILES.items()}
    assert {path.name for path in folder.iterdir()} == {*way["files"].values(), "k.db"}


def test_all_files_tell_of_one_performance(folder: Path, document: Any) -> None:
    recording = read(folder / "done.mcap")
    trajectory, plan = (json.loads((folder / name).read_text(encoding="utf-8")) for name in ("arm.json", "plan.json"))
    hold_to_schema("perform_trajectory", trajectory)
    hold_to_schema("perform_plan", plan)
    (way,) = document["ways"]
    (action,), (told,) = plan["actions"], way["actions"]
    assert [each["name"] for each in action["phases"]] == [each["name"] for each in told["phases"]]
    assert trajectory["duration_s"] == pytest.approx(recording.times_s[-1], abs=1e-5)
    with np.load(folder / "all.npz", allow_pickle=False) as file:
        assert np.abs(file["qpos"] - np.array(recording.qpos)).max() < 1e-3, "recordings are rounded"
    arm = trajectory["joint_trajectories"]["right_arm"]
    columns = [recording.scene.agent("Jido").joints[name] for name in arm["joint_names"]]
    assert arm["points"][-1]["positions"] == pytest.approx(np.array(recording.qpos)[-1, columns], abs=1e-3)
    assert plan["attained"]["position_m"] == pytest.approx(
        np.array(recording.qpos)[-1, recording.scene.object_slice("cup")][:3], abs=1e-3
    )


@pytest.mark.usefixtures("document")
def test_picture_and_film_can_be_opened(folder: Path) -> None:
    assert matplotlib.image.imread(folder / "moments.png").shape[1] == 1300
    with Image.open(folder / "film.webp") as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ("--trajectory arm.txt", "trajectories are JSON; name it .json"),
        ("--positions all.mat", "positions are NPZ"),
        ("--film film.mp4", "films are WEBP or GIF; name it .webp or .gif"),
        ("--picture nowhere/hide.png", "there is no folder 'nowhere'"),
        ("--plan same.json --trajectory same.json", "--plan: is named by --trajectory, too"),
        ("--plan there.json", "is there already"),
        ("--plan k.json --positions k.db --replace", "is read by the same command"),
    ],
)
def test_files_that_could_not_be_written_are_refused_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: str, told: str
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.json").write_text("{}", encoding="utf-8")
    (tmp_path / "k.db").write_bytes(b"no knowledge: it is not read before")
    assert told in refusal(f"{ASKED} {options}", tmp_path)


def test_each_way_has_its_own_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a second way would be written to must be free, too."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plan_2.json").write_text("{}", encoding="utf-8")
    result = Result(f"{ASKED} --plan plan.json --ways 2")
    assert result.exit_code == 2
    assert "plan_2.json" in result.stderr
