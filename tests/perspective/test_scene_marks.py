"""The tool that takes marks off ordinary scenes changes the levels of the line that it is told, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.perspective import test_ordinary_rooms as table
from tools.scene_marks import rewritten

SOURCE = Path(table.__file__).read_text(encoding="utf-8")


def test_only_the_levels_of_one_line_change() -> None:
    line = table.LINES[3]
    changed = rewritten(SOURCE, line, ["0", "1", "2 !flat"])
    before, after = SOURCE.splitlines(), changed.splitlines()
    (number,) = [n for n, (old, new) in enumerate(zip(before, after, strict=True)) if old != new]
    assert f'"{line.what}"' in before[number]
    assert after[number].endswith('"0", "1", "2 !flat"),')


def test_the_same_levels_change_nothing() -> None:
    for line in table.LINES:
        assert rewritten(SOURCE, line, [line.see, line.reach, line.grasp]) == SOURCE


def test_a_line_that_is_not_there_is_an_error() -> None:
    with pytest.raises(ValueError, match="substring"):
        rewritten("", table.LINES[0], ["0", "0", "0"])
