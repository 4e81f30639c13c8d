"""Points of a head that are lost come back where the others say, and only if those can say."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from taskgist.importing.rigid import completed
from taskgist.world.geometry.transforms import matrix_from_wxyz, wxyz_from_rotation_vector

Array = NDArray[np.float64]

SKULL = {
    "nose": (0.115, 0.0, -0.02),
    "left_eye": (0.09, 0.032, 0.015),
    "right_eye": (0.09, -0.032, 0.015),
    "left_ear": (0.0, 0.075, 0.0),
    "right_ear": (0.0, -0.075, 0.0),
}
FRAMES = 20


def moving() -> dict[str, Array]:
    """A skull that turns and goes all over the place, and a wrist."""
    rng = np.random.default_rng(2)
    turns = matrix_from_wxyz(wxyz_from_rotation_vector(rng.normal(size=(FRAMES, 3))))
    places = rng.normal(size=(FRAMES, 3))
    points = {name: turns @ np.array(at) + places for name, at in SKULL.items()}
    return {**points, "left_wrist": rng.normal(size=(FRAMES, 3))}


@pytest.mark.parametrize("lost", [["nose"], ["left_ear", "right_eye"], ["left_ear", "right_ear"]])
def test_lost_points_come_back(lost: list[str]) -> None:
    true, seen = moving(), moving()
    for name in lost:
        seen[name][7:12] = np.nan
    seen["left_wrist"][3] = np.nan
    found = completed(seen, SKULL)
    for name in SKULL:
        np.testing.assert_allclose(found[name], true[name], atol=1e-9)
    assert np.isnan(found["left_wrist"][3]).all()


def test_too_few_points_or_points_along_a_line_tell_nothing() -> None:
    seen = moving()
    for name in ("nose", "left_eye", "right_eye"):
        seen[name][5] = np.nan
    assert np.isnan(completed(seen, SKULL)["nose"][5]).all()
    line = {f"p{k}": seen["left_ear"] + (0.01 * k, 0.0, 0.0) for k in range(4)}
    line["p3"] = line["p3"] + (0.0, 0.1, 0.0)
    line["p3"][5] = np.nan
    assert np.isnan(completed(line, line)["p3"][5]).all()


def test_points_that_were_never_seen_together_stay_as_they_are() -> None:
    seen = moving()
    seen["nose"][:10] = np.nan
    seen["left_ear"][10:] = np.nan
    np.testing.assert_array_equal(completed(seen, SKULL)["nose"], seen["nose"])
