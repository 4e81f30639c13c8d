"""Running commands in this process, and holding them to what they promise about streams, exit codes and files."""

from __future__ import annotations

import json
import shlex
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from taskgist.cli.app import app
from tests.schemas import hold_to_schema


class Result:
    """What a command did: exit code, both streams."""

    def __init__(self, line: str) -> None:
        outcome = CliRunner().invoke(app, shlex.split(line))
        assert outcome.exception is None or isinstance(outcome.exception, SystemExit), repr(outcome.exception)
        self.exit_code, self.stdout, self.stderr = outcome.exit_code, outcome.stdout, outcome.stderr


def run(line: str, exit_code: int = 0) -> str:
    """Standard output of a command that ends with this exit code, and says nothing on standard error."""
    result = Result(line)
    assert (result.exit_code, result.stderr) == (exit_code, ""), result.stdout
    return result.stdout


def run_json(line: str, exit_code: int = 0) -> Any:
    """The one JSON document that a command prints, which is as its schema says."""
    document = json.loads(run(f"{line} --json", exit_code))
    group, second, *_ = [*line.split(), ""]
    hold_to_schema(f"{group} {second}" if group == "agent" else group, document)
    return document


def refusal(line: str, folder: Path) -> str:
    """The message of a command that refuses: exit code 2, one error, and every file in the folder as it was."""
    before = contents(folder)
    result = Result(line)
    assert (result.exit_code, result.stdout) == (2, ""), result.stderr
    assert result.stderr.count("error:") == 1, result.stderr
    assert contents(folder) == before
    return result.stderr


def contents(folder: Path) -> dict[str, bytes | None]:
    """Every file and folder below a folder, hidden ones too, with its bytes."""
    found = sorted(folder.rglob("*"))
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() else None for path in found}
