"""The five usual ways in, run as docs/howto/files.md says: its commands, on small files of our own."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from taskgist.recording import Recording, read
from tests.cli.running import Result
from tests.importing import takes
from tests.importing.test_bags import ros1
from tests.importing.test_camera_files import smplx, zed
from tests.importing.test_files_page import PAGE, snippet
from tests.importing.test_readers import PREFIXED, motive

SHAPE = next(line for line in snippet("objects.cup") if line.startswith("shape"))


def commands(title: str) -> list[str]:
    """The imports that a section of the page has, in their order."""
    section = PAGE[PAGE.index(f"\n## {title}\n") + 1 :].partition("\n## ")[0]
    return re.findall(r"^    taskgist (import .+)$", section, flags=re.MULTILINE)


def come_in(title: str, made: Callable[[Path], object]) -> Recording:
    """The recording that a section's commands make of a file; what is open gets the page's cup."""
    lines = commands(title)
    _, name = lines[0].split()
    made(Path(name))
    for line in lines:
        said = Result(line)
        if said.exit_code:
            assert "not imported yet: objects.cup.shape: what does it look like?" in said.stderr
            mapping = Path(name).with_suffix(".toml")
            text = mapping.read_text(encoding="utf-8")
            mapping.write_text(re.sub(r"^# shape.*$", SHAPE, text, flags=re.MULTILINE), encoding="utf-8")
            if line == lines[-1]:  # the others say themselves how to go on
                assert Result(f"import {mapping}").exit_code == 0
    return read(Path(name).with_suffix(".mcap"))


def bag(path: Path) -> None:
    pytest.importorskip("rosbags")
    shutil.move(ros1(Path()), path)


WAYS: dict[str, tuple[Callable[[Path], object], set[str], set[str]]] = {
    "OptiTrack Motive": (motive, {"Anna"}, {"cup"}),
    "Vicon": (lambda path: takes.write_c3d(path, PREFIXED), {"Anna"}, set()),
    "A bag of ROS": (bag, {"P17"}, {"cup"}),
    "A depth camera's skeleton": (zed, {"P7", "P9"}, set()),
    "SMPL-X and AMASS": (smplx, {"P1"}, set()),
}


@pytest.mark.parametrize("title", WAYS)
def test_the_page_brings_it_in(title: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made, people, things = WAYS[title]
    recording = come_in(title, made)
    assert (set(recording.scene.agents), set(recording.scene.objects)) == (people, things)
    for name in people:
        fit = recording.provenance.fit[name]["points_cm"]
        assert {
            point: error["median"] for point, error in fit.items() if "wrist" in point and error["median"] > 3.0
        } == {}


def test_smplx_needs_what_the_page_says(tmp_path: Path) -> None:
    """The code that adds joints is for another package's model, which nobody may ship: it is at least code."""
    section = PAGE[PAGE.index("\n## SMPL-X and AMASS\n") :]
    code = section.partition("```\n")[2].partition("```")[0]
    assert 'np.savez("walk.npz", joints=' in code
    compile(code, str(tmp_path), "exec")
