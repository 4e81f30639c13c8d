"""Names on a map: beside their places, none on top of another."""

from __future__ import annotations

import itertools

import numpy as np
from matplotlib.figure import Figure

from taskgist.view.maps import HEIGHT_PT, LETTER_PT, draw_things
from taskgist.world import Stage
from tests.scenes import TABLE, cylinder, scene

CROWD = [cylinder(f"thing_{n}", 0.02 * n, 0.01 * (n % 2), 0.771, radius=0.008) for n in range(5)]


def test_names_of_near_things_do_not_overlap() -> None:
    axes = Figure().subplots()
    stage = Stage(scene(TABLE, *CROWD, agents=""))
    draw_things(axes, stage, np.array((-1.5, -1.5)), np.array((1.5, 1.5)))
    boxes = []
    for text in axes.texts:
        x, y = np.array(text.xy) * 360 / 3 + np.array(text.get_position())  # type: ignore[attr-defined]
        boxes.append((x, y, x + LETTER_PT * len(text.get_text()), y + HEIGHT_PT))
    assert len(boxes) == len(CROWD)
    for one, other in itertools.combinations(boxes, 2):
        assert one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


def test_things_outside_of_the_map_are_left_out() -> None:
    axes = Figure().subplots()
    stage = Stage(scene(TABLE, cylinder("near", 0.0, 0.0, 0.771), cylinder("far", 3.0, 0.0, 0.05), agents=""))
    draw_things(axes, stage, np.array((-1.5, -1.5)), np.array((1.5, 1.5)))
    assert [text.get_text() for text in axes.texts] == ["near"]
