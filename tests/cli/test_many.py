"""Many files in one command: names, folders and patterns; what one does wrong stops no other."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from taskgist.common import workers
from taskgist.recording import read
from tests.cli.running import Result, refusal, run, run_json
from tests.importing import takes
from tests.importing.test_readers import PREFIXED, motive
from tests.shipped import PATHS


@pytest.fixture(params=[1, 2], ids=["one core", "two cores"])
def cores(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(workers, "cores", lambda: request.param)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Three recordings, one of them cut off, two folders deep."""
    inside = tmp_path / "recordings" / "monday"
    inside.mkdir(parents=True)
    shutil.copy(PATHS["show_a"], inside / "a.mcap")
    shutil.copy(PATHS["hide_a"], inside / "b.mcap")
    (inside / "cut.mcap").write_bytes(PATHS["hide_a"].read_bytes()[:2000])
    monkeypatch.chdir(tmp_path)
    return inside


@pytest.mark.usefixtures("cores")
def test_labels_of_a_folder_are_shown_and_set(folder: Path) -> None:
    shown = run_json("label recordings", exit_code=2)
    assert [(item.get("label") or {}).get("task") for item in shown] == ["show", "hide", None]
    assert shown[2]["error"].startswith("recordings/monday/cut.mcap: the file is cut off")
    (folder / "cut.mcap").unlink()
    said = Result("label recordings --task carry")
    assert (said.exit_code, said.stdout.splitlines()[-1]) == (0, "2 labelled, 0 refused")
    assert {read(path).label.task for path in folder.glob("*.mcap")} == {"carry"}  # type: ignore[union-attr]


def test_a_table_names_each_file_once(folder: Path) -> None:
    said = Result("label 'recordings/*/*.mcap' recordings/monday/a.mcap")
    lines = said.stdout.splitlines()
    assert lines[0].split() == ["file", "task", "performer", "for", "with", "start", "end"]
    assert [line.split()[:3] for line in lines[1:3]] == [
        ["recordings/monday/a.mcap", "show", "P1"],
        ["recordings/monday/b.mcap", "hide", "P1"],
    ]
    assert lines[3].startswith("refused: recordings/monday/cut.mcap: the file is cut off or damaged")
    assert (lines[4], said.exit_code) == ("2 shown, 1 refused", 2)
    assert folder.name == "monday"


@pytest.mark.usefixtures("cores")
def test_recordings_are_checked_together(folder: Path) -> None:
    (folder / "b.mcap").unlink()
    found = run_json("check recordings", exit_code=2)
    assert [item.get("fit") for item in found] == [True, None]
    assert "cut off" in found[1]["error"]
    said = Result("check recordings")
    assert said.exit_code == 2
    assert "recordings/monday/a.mcap  fit to learn from" in said.stdout
    assert said.stdout.splitlines()[-1] == "1 checked, 1 refused"


def test_what_matches_nothing_is_told(tmp_path: Path) -> None:
    assert "none_*.mcap: no file matches" in refusal(f"check {tmp_path}/none_*.mcap", tmp_path)
    (tmp_path / "empty").mkdir()
    assert "no recordings (*.mcap) in this folder" in refusal(f"label {tmp_path}/empty", tmp_path)


@pytest.mark.usefixtures("cores")
def test_takes_are_imported_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("takes").mkdir()
    for name in ("one", "two"):
        takes.write_c3d(Path(f"takes/{name}.c3d"), PREFIXED)
    motive(Path("takes/open.csv"))
    done = run_json("import 'takes/*.c3d' takes/open.csv -o made", exit_code=2)
    assert [item.get("recording") for item in done] == ["made/one.mcap", "made/two.mcap", None]
    assert "not imported yet: objects.cup.shape" in done[2]["error"]
    assert list(read("made/two.mcap").scene.agents) == ["Anna"]
    assert sorted(path.name for path in Path("made").iterdir()) == [
        *("one.mcap", "one.toml", "open.toml", "two.mcap", "two.toml")
    ]


def test_one_mapping_imports_each_take(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        takes.write_c3d(Path(f"{name}.c3d"), PREFIXED)
    run("import one.c3d")
    said = run("import one.toml --each 'file=*.c3d' -o made --replace")
    assert said.splitlines()[0].split() == ["file", "recording", "frames", "seconds", "people", "things", "notes"]
    assert said.splitlines()[-1] == "2 imported, 0 refused"
    assert sorted(path.name for path in Path("made").iterdir()) == ["one.mcap", "two.mcap"]


MISTAKES = {
    "import a/take.c3d b/take.c3d": r"take.mcap: a/take.c3d and b/take.c3d would both become it",
    "import a/take.c3d b/other.c3d -o x.mcap": "--out: several recordings do not go into one",
    "import a/take.c3d --each file=*.c3d": "--each: is for one mapping",
    "import m.toml --each file=*.trc": "--each: nothing matches",
    "import m.toml --each *.trc": "--each: not a parameter",
    "import a/take.c3d b/other.c3d -o a/take.c3d": "--out: cannot be made",
}


@pytest.mark.parametrize("line", MISTAKES)
def test_mistakes(line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for path in (Path("a/take.c3d"), Path("b/take.c3d"), Path("b/other.c3d")):
        path.parent.mkdir(exist_ok=True)
        takes.write_c3d(path, PREFIXED)
    Path("m.toml").write_text('[parameters]\nfile = ""\n', encoding="utf-8")
    assert MISTAKES[line] in refusal(line, tmp_path)
