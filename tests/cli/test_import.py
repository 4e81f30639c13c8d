"""``taskgist import`` of files as programs of motion capture write them."""

from __future__ import annotations

from pathlib import Path

import pytest

from taskgist.recording import read
from tests.cli.running import Result, refusal, run, run_json
from tests.importing import takes
from tests.importing.test_readers import PREFIXED, motive


def test_a_file_in_which_nothing_is_open_is_imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    takes.write_c3d(tmp_path / "take.c3d", PREFIXED)
    monkeypatch.chdir(tmp_path)
    said = run("import take.c3d")
    for part in ("take.c3d: C3D, 26 points, 30 Hz, 0.37 s, no gaps", "person Anna: 26 points, skeleton plug_in_gait"):
        assert part in said
    assert list(read(tmp_path / "take.mcap").scene.agents) == ["Anna"]
    message = refusal("import take.c3d", tmp_path)
    assert "take.toml: the mapping is there already: import that; taskgist import take.toml -o take.mcap" in message
    document = run_json("import take.toml -o again.mcap --set file=take.c3d")
    assert (document["agents"], document["mapping"]) == (["Anna"], "take.toml")
    assert run_json("import take.c3d --replace")["recording"] == "take.mcap"


def test_what_is_open_is_asked_and_filled_in(tmp_path: Path) -> None:
    motive(tmp_path / "take.csv")
    asked = Result(f"import {tmp_path}/take.csv -o {tmp_path}/done.mcap")
    assert asked.exit_code == 2
    assert "not imported yet: objects.cup.shape: what does it look like?" in asked.stderr
    assert "things: cup" in asked.stdout
    assert not (tmp_path / "done.mcap").exists()
    mapping = tmp_path / "done.toml"
    shape = 'shape = { type = "cylinder", radius_m = 0.04, length_m = 0.10, axis = "y", position_m = [0, 0.02, 0] }\n#'
    mapping.write_text(mapping.read_text(encoding="utf-8").replace("# shape", shape), encoding="utf-8")
    document = run_json(f"import {mapping} -o {tmp_path}/done.mcap")
    assert (document["agents"], document["objects"]) == (["Anna"], ["cup"])


def test_other_files_write_nothing(tmp_path: Path) -> None:
    (tmp_path / "take.fbx").write_bytes(b"Kaydara FBX Binary  \0")
    assert "convert it to BVH" in refusal(f"import {tmp_path}/take.fbx -o {tmp_path}/a.mcap", tmp_path)
    takes.write_c3d(tmp_path / "take.c3d", PREFIXED)
    assert "recordings are MCAP" in refusal(f"import {tmp_path}/take.c3d -o {tmp_path}/a.txt", tmp_path)
    assert "there is no folder" in refusal(f"import {tmp_path}/take.c3d -o {tmp_path}/no/a.mcap", tmp_path)
