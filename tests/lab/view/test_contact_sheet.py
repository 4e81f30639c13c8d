"""Contact sheets: as many pictures as there are demonstrations, up to a dozen."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.image import imread

from taskgist.recording import Recording
from taskgist_lab.generator import simulate
from taskgist_lab.view import contact_sheet


@pytest.fixture(scope="module")
def recording() -> Recording:
    return simulate("show", seed=3, number=0, means="turn")


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (2, 2)])
def test_sheets_are_as_large_as_they_must_be(recording: Recording, tmp_path: Path, count: int, columns: int) -> None:
    path = contact_sheet([recording] * count, ["turned"] * count, tmp_path / "sheet.png", title="show")
    picture = imread(path)
    assert picture.shape[1] == 400 * columns
    assert picture[..., :3].std() > 0.05
