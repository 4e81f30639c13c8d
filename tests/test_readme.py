"""The README is true and short, and what it and docs/start/demo.md say that the demo prints is what the demo prints."""

import re
import textwrap
from pathlib import Path

import pytest
from typer.testing import CliRunner

from taskgist.cli.app import app

ROOT = Path(__file__).parent.parent
README, PAGE = ROOT / "README.md", ROOT / "docs" / "start" / "demo.md"
LINES = 100
BLOCK = re.compile(r"<!-- demo -->\n```text\n(.*?)```", re.DOTALL)


def test_the_readme_is_short() -> None:
    assert len(README.read_text(encoding="utf-8").splitlines()) <= LINES


def test_its_five_lines_of_python_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.xml").write_text(ROOM, encoding="utf-8")
    (tmp_path / "room.toml").write_text('[scene]\nmodel = "room.xml"\n[agents.P1]\n', encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```", README.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    assert len([line for line in code.splitlines() if line]) <= 5
    exec(code, {})
    assert capsys.readouterr().out.startswith("Head_Effort ('Pan_Head',")


ROOM = textwrap.dedent("""
    <mujoco><worldbody><body name="cup" pos="0.3 0.6 1.2"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>
""")


@pytest.mark.usefixtures("coarse_pictures")
def test_the_demo_prints_what_the_readme_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["demo"])
    assert result.exit_code == 0, result.output
    blocks = [block for page in (README, PAGE) for block in BLOCK.findall(page.read_text(encoding="utf-8"))]
    assert len(blocks) == 4
    for block in blocks:
        assert block.strip() in result.output
    pictures = sorted(path.name for path in (tmp_path / "taskgist-demo").glob("*.png"))
    assert pictures == ["give.png", "hide.png", "hide_performed.png", "show.png"]
