"""People who were tracked in a frame whose floor is elsewhere: an import says so, and what it says mends it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.importing import noisy_handover as truth
from tests.importing.test_other_trackers import imported, wide_table


def notes(folder: Path, height_m: float) -> list[str]:
    """What an import of two people that far over the floor notes of it."""
    seen = truth.handover()
    shift = f'axes = {{ x = "-z", y = "-x", z = "y" }}\ntransform = {{ position_m = [0, 0, {height_m}] }}'
    text = wide_table(folder, seen.keypoints, seen.mug).replace('axes = { x = "-z", y = "-x", z = "y" }', shift)
    return [note for note in imported(folder, text).provenance.notes if "floor" in note]


@pytest.mark.parametrize(("height_m", "where"), [(0.6, "over"), (-0.7, "under")])
def test_people_off_the_floor(tmp_path: Path, height_m: float, where: str) -> None:
    found = notes(tmp_path, height_m)
    assert [note[:2] for note in found] == ["P1", "P2"]
    told = [re.search(r"([\d.]+) m (\w+) the floor.*position_m = \[0, 0, ([-\d.]+)\]", note) for note in found]
    for match in told:
        assert match
        assert match[2] == where
        assert float(match[1]) == pytest.approx(abs(height_m), abs=0.06)
        assert float(match[3]) == pytest.approx(-height_m, abs=0.06)
        assert notes(tmp_path, height_m + float(match[3])) == []


def test_people_on_the_floor(tmp_path: Path) -> None:
    assert notes(tmp_path, 0.0) == []
