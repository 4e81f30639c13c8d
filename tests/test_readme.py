"""The README is true: what it says that the demo prints is what the demo prints."""

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app

README = Path(__file__).parent.parent / "README.md"
BLOCK = re.compile(r"<!-- demo -->\n```text\n(.*?)```", re.DOTALL)


def test_the_demo_prints_what_the_readme_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["demo"])
    assert result.exit_code == 0, result.output
    blocks = BLOCK.findall(README.read_text(encoding="utf-8"))
    assert len(blocks) == 3
    for block in blocks:
        assert block.strip() in result.output
    pictures = sorted(path.name for path in (tmp_path / "taskgist-demo").glob("*.png"))
    assert pictures == ["give.png", "hide.png", "show.png"]
