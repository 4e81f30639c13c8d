"""The tutorial runs as it stands: its files are written, its commands run, and what it shows is what they print."""

from __future__ import annotations

import re
import runpy
import shlex
from collections.abc import Iterator
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest

from tests.cli.running import run

PAGE = Path(__file__).parent.parent / "docs" / "start" / "tutorial.md"
BLOCK = re.compile(r"^```(\w+)(?: title=\"(.*?)\")?\n(.*?)^```$", re.DOTALL | re.MULTILINE)
LEFT_OUT = "..."


@pytest.mark.usefixtures("coarse_maps", "coarse_pictures")
def test_the_tutorial(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = BLOCK.findall(PAGE.read_text(encoding="utf-8"))
    assert len(blocks) > 10
    for language, title, text in blocks:
        if title:
            Path(title).write_text(text, encoding="utf-8")
        else:
            assert language == "console", text
            for line, shown in steps(text):
                lines = printed(line)
                assert fits(lines, shown), "\n".join([line, *lines])
    assert {"p1.png", "hidden.png", "knowledge.db"} <= {path.name for path in tmp_path.iterdir()}


def steps(block: str) -> Iterator[tuple[str, list[str]]]:
    """Each command of a block, and the lines shown beneath it."""
    for step in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
        line, *shown = step.splitlines()
        yield line, shown


def printed(line: str) -> list[str]:
    """What a command prints on standard output."""
    program, *words = shlex.split(line)
    if program == "python":
        stream = StringIO()
        with redirect_stdout(stream):
            runpy.run_path(words[0], run_name="__main__")
        return stream.getvalue().splitlines()
    assert program == "taskgist"
    return run(line.removeprefix("taskgist ")).splitlines()


def fits(lines: list[str], shown: list[str]) -> bool:
    """Whether lines are those that are shown, where ``...`` stands for any, also at a line's end."""
    patterns = [
        r"(?:.*\n)*" if each == LEFT_OUT else re.escape(each.rstrip()).replace(re.escape(LEFT_OUT), ".*") + "\n"
        for each in shown
    ]
    return re.fullmatch("".join(patterns), "".join(f"{each.rstrip()}\n" for each in lines)) is not None


def test_what_is_shown_must_be_what_is_printed() -> None:
    assert fits(["a", "b 1.2 s", "c"], ["a", "b ..."] + ["c"])
    assert fits(["a", "b", "c"], [LEFT_OUT, "c"])
    assert fits([], [LEFT_OUT])
    assert not fits(["a", "b"], ["a"])
    assert not fits(["a"], ["a", "b"])
    assert not fits(["ab"], ["a"])
