"""How many of our files a command walks through is held: a house that grows back is noticed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from taskgist.store import load
from tools.walk import LEARN, QUERY, RECORDINGS, ROOT, measured

FILES = {LEARN: 97, QUERY: 77}
"""At most so many files: capability maps, grasps, postures and what is seen are each ideas of their own. A recording is
asked with what was decided over time: who holds what, and where eyes look; sliding is shared with planners. Models are
as people bring them: what a file is, what MuJoCo refuses, rooms of several models, sliding bases, cameras, fingers."""


@pytest.mark.parametrize("command", FILES)
def test_a_command_walks_through_few_files(command: str, tmp_path: Path) -> None:
    option = ("-k", str(tmp_path / "knowledge.db")) if command == LEARN else ()
    found = measured([*command.replace("FOLDER", str(RECORDINGS)).split(), *option])
    assert found["exit_code"] == 0
    assert "main" in found["functions"]["taskgist/cli/__init__.py"]
    assert len(found["functions"]) <= FILES[command], sorted(found["functions"])
    if command == LEARN:
        assert load(tmp_path / "knowledge.db").tasks == ("show",), "what is measured is the real work"


def test_what_runs_while_modules_are_imported_does_not_count() -> None:
    found = measured(["--help"])
    assert set(found["functions"]) == {"taskgist/cli/__init__.py", "taskgist/cli/app.py"}
    assert found["modules"] <= 60
    assert found["large"] == []


def test_the_figures_are_printed() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tools.walk", "--", "--version"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert "functions ran, in 2 files" in done.stdout
    assert "modules of ours are loaded, and no large library" in done.stdout
