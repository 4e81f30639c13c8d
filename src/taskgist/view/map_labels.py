"""People and things on a map from above, in the room's coordinates, with names that do not cover each other."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from taskgist.world import Stage
from taskgist.world.geometry.rotations import yaw_of

Array = NDArray[np.float64]
Box = tuple[float, float, float, float]
ARROW_M = 0.42
LABEL = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "black", "alpha": 0.9}
FONT_PT, LETTER_PT, HEIGHT_PT = 8.0, 4.6, 10.0
PERSON_PT = 20.0
"""Side of the square that a person's label takes up."""
SPAN_PT = 360.0
"""Length of the map's longer side in print."""
LEADER_PT = 14.0
"""A name farther from its place than this is tied to it by a line."""


def draw_people(axes: Axes, stage: Stage) -> None:
    """Each agent where it stands, with an arrow along its heading."""
    for name in stage.scene.agents:
        base = stage.state.qpos[stage.scene.base_slice(name)]
        x, y, heading = float(base[0]), float(base[1]), yaw_of(base[3:])
        tip = (x + ARROW_M * math.cos(heading), y + ARROW_M * math.sin(heading))
        arrow = {"arrowstyle": "-|>", "color": "black", "lw": 1.5}
        axes.annotate("", tip, (x, y), arrowprops=arrow, annotation_clip=True)
        axes.text(x, y, name, ha="center", va="center", fontsize=9, clip_on=True, bbox=LABEL)


def draw_things(axes: Axes, stage: Stage, low: Array, high: Array) -> None:
    """Each object where it is within the map's corners, its name beside it."""
    points_per_m = SPAN_PT / float((high - low).max())
    people = [stage.state.qpos[stage.scene.base_slice(name)][:2] for name in stage.scene.agents]
    things = {name: stage.state.qpos[stage.scene.object_slice(name)][:2] for name in stage.scene.objects}
    things = {name: place for name, place in things.items() if (low <= place).all() and (place <= high).all()}
    marks = [_around(place * points_per_m, 6.0) for place in things.values()]
    taken = [*(_around(place * points_per_m, PERSON_PT) for place in people), *marks]
    for name, place in things.items():
        x, y = (float(value) for value in place)
        axes.plot(x, y, "x", color="black", markersize=5, markeredgewidth=1.2)
        offset, box = _free(place * points_per_m, LETTER_PT * len(name), taken)
        taken.append(box)
        leader = {"arrowstyle": "-", "color": "0.25", "lw": 0.6, "shrinkA": 0, "shrinkB": 2}
        axes.annotate(
            name,
            (x, y),
            xytext=offset,
            textcoords="offset points",
            fontsize=FONT_PT,
            arrowprops=leader if math.hypot(offset[0], offset[1]) > LEADER_PT and abs(offset[1]) > HEIGHT_PT else None,
        )


def _free(place_pt: Array, width: float, taken: Iterable[Box]) -> tuple[tuple[float, float], Box]:
    """The offset at which a name covers least of what is there, the nearest first; and what it takes up, points."""
    best: tuple[float, tuple[float, float], Box] | None = None
    for away in range(6):
        for side in (4.0, -4.0 - width):
            for up in (3.0 + HEIGHT_PT * away, -HEIGHT_PT * (1 + away)):
                left, bottom = float(place_pt[0]) + side, float(place_pt[1]) + up
                box = (left, bottom, left + width, bottom + HEIGHT_PT)
                covered = sum(_overlap(box, other) for other in taken)
                if best is None or covered < best[0]:
                    best = (covered, (side, up), box)
    assert best is not None
    return best[1], best[2]


def _overlap(one: Box, other: Box) -> float:
    """Area that two boxes share."""
    across = min(one[2], other[2]) - max(one[0], other[0])
    along = min(one[3], other[3]) - max(one[1], other[1])
    return max(across, 0.0) * max(along, 0.0)


def _around(place: Array, side: float) -> Box:
    x, y = float(place[0]), float(place[1])
    return (x - side / 2, y - side / 2, x + side / 2, y + side / 2)
