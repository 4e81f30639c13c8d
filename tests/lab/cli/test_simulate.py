"""``taskgist simulate``: recordings in a folder, and what it says about them."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskgist.recording import read
from taskgist_lab.generator import SEVERAL, WAYS, simulate
from tests.cli.running import Result, run, run_json

SHOW = "simulate show --means turn --seed 3 --processes 1"


def test_recordings_are_written_and_told_of(tmp_path: Path) -> None:
    said = run_json(f"{SHOW} --count 1 -o {tmp_path}/new/folder")
    recording = read(tmp_path / "new" / "folder" / "show-3-000000.mcap")
    assert recording.digest == simulate("show", seed=3, number=0, means="turn").digest
    assert recording.label is not None
    assert recording.label.task == "show"
    assert said["task"] == "show"
    assert said["means"] == {"turn": {"count": 1, "rooms_tried": said["recordings"][0]["rooms_tried"]}}
    assert said["recordings"][0]["file"].endswith("show-3-000000.mcap")
    assert said["recordings"][0]["duration_s"] == pytest.approx(recording.duration_s, abs=1e-3)


def test_what_is_there_is_not_replaced_unless_asked_for(tmp_path: Path) -> None:
    there = tmp_path / "show-3-000001.mcap"
    there.write_bytes(b"mine")
    refused = Result(f"{SHOW} --count 2 -o {tmp_path}")
    assert refused.exit_code == 2
    assert f"{there}: is there already; name another folder" in refused.stderr
    assert there.read_bytes() == b"mine"
    assert list(tmp_path.iterdir()) == [there]


def test_a_picture_and_a_summary(tmp_path: Path) -> None:
    text = run(f"{SHOW} --count 1 -o {tmp_path} --picture {tmp_path}/sheet.png")
    assert "rooms tried for each" in text
    assert f"1 demonstrations of show in {tmp_path}" in text
    assert (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")


def test_tasks_and_means_are_listed() -> None:
    text = run("simulate --list")
    assert "hold-up, on-top, turn, move-occluder" in text
    assert run_json("simulate --list") == {
        task: [way.name for way in (*ways, *SEVERAL.get(task, ()))] for task, ways in WAYS.items()
    }


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("simulate", "no task to simulate; name one; 'taskgist simulate --list' names them"),
        ("simulate shwo", "no task 'shwo'; did you mean 'show'?"),
        ("simulate show --means trun", "no means to show 'trun'; did you mean 'turn'?"),
        ("simulate show --count 0", "count: too small (got 0); give a whole number from 1 on"),
        ("simulate show --seed -1", "seed: too small (got -1)"),
        ("simulate show --processes 0", "processes: too small (got 0)"),
        ("simulate show --picture /nowhere/sheet.png", "--picture: cannot be written: there is no folder '/nowhere'"),
    ],
)
def test_bad_input(line: str, message: str) -> None:
    refused = Result(line)
    assert refused.exit_code == 2
    assert message in refused.stderr
    assert refused.stdout == ""


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    refused = Result(f"{SHOW} --count 1 -o {tmp_path}/file/folder")
    assert refused.exit_code == 2
    assert "file/folder: cannot be made" in refused.stderr
