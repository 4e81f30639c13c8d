"""Trials: which cells does any of many stances win?

Only that one of them does is asked, not which one needs least, so their order is free. What is in the way is tested as
late as possible: first all cells are won that some trial wins that is known to be free; then, for the others, a few
of the trials that would win each are tested, until every cell is won or lost.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.maps.cells import Cells
from taskgist.perspective.maps.footing import BLOCKED, FREE, Footing
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Status = NDArray[np.uint8]
LOST, WON, PENDING, DOUBTFUL = 0, 1, 2, 4
"""What is found of a cell: a free trial wins it; one does that has to be tested; one does unless a mesh is in between.
The latter two may hold at once."""
FIRST = 8
"""How many trials are tried before all others: those that fit best."""
MOST, USED_UP = 4, -1
"""How many trials are to be tested for one cell at a time."""


Ball = tuple[float, float, float, float]
"""Middle and radius, metres."""


class Sweep(NamedTuple):
    """Cells that trials are tried on, and what they find out.

    Attributes:
        points: Centres of all cells, metres in the world, (cells, 3).
        rows: Which are asked for, block by block, (n,).
        found: ``WON``, or what there is of ``PENDING`` and ``DOUBTFUL``, (n,); filled.
        asks: How many trials may be tested for each, less than 0 once these are used up, (n,); or 0 if none may.
        free: Whether trials are ``FREE`` in a step of the chest, (trials, steps).
        asked: Which trials and steps are to be tested, (trials, steps); filled.
        facing: Heading and step, radians.
    """

    points: Array
    rows: Indices
    found: Status
    asks: NDArray[np.int8]
    free: NDArray[np.int8]
    asked: Mask
    facing: Array


class Trials(Protocol):
    """The trials of one effort level and one ability."""

    footing: Footing
    cells: Cells

    def run(self, sweep: Sweep) -> None:
        """Try all trials on some cells."""

    def look_closely(self, rows: Indices) -> Mask:
        """Whether doubtful cells are won, (n,)."""


def winners(here: Standpoint, trials: Trials, rows: Indices) -> Mask:
    """Whether any of the trials wins each of some cells, (n,)."""
    won, doubtful = np.zeros((2, len(rows)), dtype=bool)
    left, most = np.arange(len(rows)), 0
    while len(left):
        sweep = sweep_of(trials, rows[left], trials.footing.free, most)
        trials.run(sweep)
        trials.footing.test(here, sweep.asked)
        won[left], doubtful[left] = sweep.found == WON, sweep.found & DOUBTFUL
        left, most = left[(sweep.found & PENDING) > 0], MOST
    doubtful &= ~won
    if doubtful.any():
        won[doubtful] = trials.look_closely(rows[doubtful])
    return won


def sweep_of(trials: Trials, rows: Indices, free: NDArray[np.int8], most: int = 0) -> Sweep:
    """A sweep over some cells, of which nothing is known so far."""
    found, asks = np.zeros(len(rows), dtype=np.uint8), np.full(len(rows), most, dtype=np.int8)
    return Sweep(trials.cells.points, rows, found, asks, free, np.zeros(free.shape, dtype=bool), trials.footing.facing)


@compiled
def judge_all(
    points: Array,
    rows: Indices,
    found: Status,
    asks: NDArray[np.int8],
    free: NDArray[np.int8],
    asked: Mask,
    facing: Array,
    lanes: Indices,
    which: int,
    work: Array,
    able: int,
    count: int,
    trial: int,
    base_x: float,
    base_y: float,
) -> None:
    """Note what a trial finds out about some cells, if nothing is in the way.

    The first seven are those of a ``Sweep``: compiled code passes arrays on for nothing, but not tuples of them.
    ``lanes[which]`` tells which cells; ``able`` is the row of the workspace that tells of each whether the trial is
    able: ``WON``, ``DOUBTFUL`` or ``LOST``; the base stands at ``base_x`` and ``base_y``, metres.
    """
    for lane in range(count):
        if work[able + lane] == LOST:
            continue
        place = lanes[which, lane]
        step = step_of(facing, free.shape[1], points[rows[place], 0] - base_x, points[rows[place], 1] - base_y)
        if free[trial, step] == BLOCKED:
            continue
        if work[able + lane] == DOUBTFUL:
            found[place] |= DOUBTFUL
        elif free[trial, step] == FREE:
            found[place] = WON
        else:
            found[place] |= PENDING
            if asks[place] > 0:
                asked[trial, step] = True
                asks[place] = asks[place] - 1 if asks[place] > 1 else USED_UP


@compiled
def step_of(facing: Array, steps: int, x: float, y: float) -> int:
    """The step of the chest nearest to a direction over the floor; 0 if there is only one."""
    if steps == 1:
        return 0
    away = (np.arctan2(y, x) - facing[0]) / facing[1]
    return int(np.rint(np.rint(away * 1e9) / 1e9)) % steps


@compiled
def best_of(scores: Array, among: Indices, best: Indices) -> int:
    """Lists those of some trials with the greatest scores, greatest first, at most ``FIRST``; how many these are."""
    count = 0
    for trial in among:
        score = scores[trial]
        if score == -np.inf or (count == FIRST and score <= scores[best[FIRST - 1]]):
            continue
        count = min(count + 1, FIRST)
        place = count - 1
        while place > 0 and scores[best[place - 1]] < score:
            best[place] = best[place - 1]
            place -= 1
        best[place] = trial
    return count


@compiled
def ball_around_cells(points: Array, rows: Indices, start: int, end: int) -> Ball:
    """A ball around the centres of some cells."""
    lx, ly, lz = points[rows[start], 0], points[rows[start], 1], points[rows[start], 2]
    hx, hy, hz = lx, ly, lz
    for place in range(start + 1, end):
        x, y, z = points[rows[place], 0], points[rows[place], 1], points[rows[place], 2]
        lx, ly, lz, hx, hy, hz = min(lx, x), min(ly, y), min(lz, z), max(hx, x), max(hy, y), max(hz, z)
    radius = np.sqrt((hx - lx) ** 2 + (hy - ly) ** 2 + (hz - lz) ** 2) / 2
    return (lx + hx) / 2, (ly + hy) / 2, (lz + hz) / 2, radius + 1e-9
