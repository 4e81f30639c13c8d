"""The command as it is installed: real processes, real exit codes, never a traceback."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest

from taskgist.recording import read, write
from tests.shipped import PATHS


def taskgist(*words: str, folder: Path) -> subprocess.CompletedProcess[str]:
    code = "from taskgist.cli import main; main()"
    return subprocess.run(
        [sys.executable, "-c", code, *words], cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )


def test_the_command_is_installed() -> None:
    (entry,) = metadata.entry_points(group="console_scripts", name="taskgist")
    assert entry.value == "taskgist.cli:main"
    assert callable(entry.load())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("process")
    write(read(PATHS["show_a"]).with_label(None), folder / "unlabelled.mcap")
    (folder / "cut.mcap").write_bytes(PATHS["show_a"].read_bytes()[:40_000])
    return folder


def test_exit_code_0(folder: Path) -> None:
    done = taskgist("label", str(PATHS["show_a"]), "--json", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout)["task"] == "show"


def test_exit_code_1(folder: Path) -> None:
    done = taskgist("label", "unlabelled.mcap", folder=folder)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("no label; set one")


def test_exit_code_2(folder: Path) -> None:
    done = taskgist("check", "cut.mcap", "--json", folder=folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: cut.mcap: the file is cut off or damaged")
    assert "Traceback" not in done.stderr
