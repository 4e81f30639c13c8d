"""Which cells an agent reaches from many stances: the sector of each arm, cell by cell (5.1.2)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.maps.footing import (
    FIRST,
    INNER,
    LEAF,
    PAST,
    WON,
    Ball,
    Footing,
    Sweep,
    Tree,
    Trials,
    ball_around_cells,
    best_of,
    footing_of,
    judge_all,
    squared_gap,
    tree_of,
)
from taskgist.maps.grid import LANES, Cells
from taskgist.perspective.effort import stretch
from taskgist.perspective.reach import ROUNDING
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.bodies.profile import Arm

# --- Sectors of arms: does any arm reach the centre of a cell? Compiled loops over cells (5.1.2).

SHOULDER, CARRIER, LENGTH, AZIMUTH, ELEVATION, AT_EASE, ARM_COLUMNS = 0, 3, 12, 13, 16, 19, 22
"""Columns of a table of arms: where the shoulder is, metres; the frame of what carries it, row by row; its length;
cosine and sine of the middle of its azimuth, and cosine of half its width; the same of its elevation; and a point in
the middle of what it reaches."""
X, Y, Z, REACHED = (LANES * row for row in range(4))
"""Rows of the workspace: points in the world, metres; and 1 for those that are reached."""
ROWS = 4


class Reaches(NamedTuple):
    """How trials reach.

    Attributes:
        arms: By way, (ways, arms, columns).
        way: Which way each trial is, (trials,).
        places: Where the base stands, metres, (trials, 2).
        turns: Whether the chest turns to each cell: then arms are told in the frame under the base.
        tree: The trials, by where their shoulders may be.
    """

    arms: Array
    way: Indices
    places: Array
    turns: bool
    tree: Tree


@compiled
def reached_cells(reaches: Reaches, sweep: Sweep, starts: Indices) -> None:
    """Note what trials find out about some cells.

    Args:
        reaches: How they reach.
        sweep: The cells, block by block; filled.
        starts: Where blocks begin among them, and where the last one ends, (blocks + 1,).
    """
    arms, way, places, turns, (nodes, boxes) = reaches
    points, rows, found, asks, free, asked, facing = sweep
    scores, near, best = np.empty(len(way)), np.empty(len(way), dtype=np.intp), np.empty(FIRST, dtype=np.intp)
    work, lanes = np.empty(ROWS * LANES), np.empty((1, LANES), dtype=np.intp)
    for block in range(len(starts) - 1):
        ball = ball_around_cells(points, rows, starts[block], starts[block + 1])
        near_count = _rate(arms, way, places, turns, nodes, boxes, ball, scores, near)
        count = starts[block + 1] - starts[block]
        for lane in range(count):
            lanes[0, lane] = starts[block] + lane
            for axis in range(3):
                work[LANES * axis + lane] = points[rows[starts[block] + lane], axis]
        hopeful = best_of(scores, near[:near_count], best)
        for place in range(hopeful + near_count):
            trial = best[place] if place < hopeful else near[place - hopeful]
            if count == 0 or scores[trial] == -np.inf:
                continue
            scores[trial] = -np.inf
            x, y = places[trial, 0], places[trial, 1]
            _reach_all(arms, way[trial], x, y, turns, work, count)
            judge_all(points, rows, found, asks, free, asked, facing, lanes, 0, work, REACHED, count, trial, x, y)
            count = _still_left(found, asks, lanes, work, count)


@compiled
def _still_left(found: NDArray[np.uint8], asks: NDArray[np.int8], lanes: Indices, work: Array, count: int) -> int:
    """Keeps the cells of a block that are not won, and may still ask; how many there are."""
    kept = 0
    for lane in range(count):
        place = lanes[0, lane]
        if found[place] != WON and asks[place] >= 0:
            lanes[0, kept] = place
            for row in (X, Y, Z):
                work[row + kept] = work[row + lane]
            kept += 1
    return kept


@compiled
def _rate(
    arms: Array,
    way: Indices,
    places: Array,
    turns: bool,
    nodes: Indices,
    boxes: Array,
    ball: Ball,
    scores: Array,
    near: Indices,
) -> int:
    """Lists the trials that may reach a block of cells, and rates them: how near it is to what they reach best."""
    x, y, z, radius = ball
    limit, count, node = radius + ROUNDING, 0, 0
    for arm in range(arms.shape[1]):
        limit = max(limit, arms[0, arm, LENGTH] + radius + ROUNDING)
    while node < len(nodes):
        if squared_gap(boxes, node, x, y, z) > limit * limit:
            node = nodes[node, PAST]
            continue
        trial = nodes[node, LEAF]
        node += 1
        if trial == INNER:
            continue
        ahead, aside = (math.hypot(x - places[trial, 0], y - places[trial, 1]), 0.0) if turns else (x, y)
        best = -np.inf
        for arm in range(arms.shape[1]):
            if _squared_m(arms, way[trial], arm, SHOULDER, ahead, aside, z) <= limit * limit:
                best = max(best, -_squared_m(arms, way[trial], arm, AT_EASE, ahead, aside, z))
        if best > -np.inf:
            near[count], scores[trial] = trial, best
            count += 1
    return count


@compiled
def _squared_m(arms: Array, way: int, arm: int, column: int, x: float, y: float, z: float) -> float:
    """Squared distance between a point and one of an arm."""
    dx, dy, dz = x - arms[way, arm, column], y - arms[way, arm, column + 1], z - arms[way, arm, column + 2]
    return float(dx * dx + dy * dy + dz * dz)


@compiled
def _reach_all(arms: Array, way: int, px: float, py: float, turns: bool, work: Array, count: int) -> None:
    """Whether any arm reaches each of some points."""
    for lane in range(count):
        work[REACHED + lane] = 0.0
    for arm in range(arms.shape[1]):
        sx, sy, sz = arms[way, arm, 0], arms[way, arm, 1], arms[way, arm, 2]
        a, b, c = arms[way, arm, 3], arms[way, arm, 4], arms[way, arm, 5]
        d, e, f = arms[way, arm, 6], arms[way, arm, 7], arms[way, arm, 8]
        g, h, i = arms[way, arm, 9], arms[way, arm, 10], arms[way, arm, 11]
        reach = arms[way, arm, LENGTH] + ROUNDING
        az_cos, az_sin, az_half = arms[way, arm, AZIMUTH], arms[way, arm, AZIMUTH + 1], arms[way, arm, AZIMUTH + 2]
        el_cos, el_sin, el_half = (
            arms[way, arm, ELEVATION],
            arms[way, arm, ELEVATION + 1],
            arms[way, arm, ELEVATION + 2],
        )
        for lane in range(count):
            x, y = work[X + lane] - px, work[Y + lane] - py
            away = math.sqrt(x * x + y * y)
            dx = (away if turns else x) - sx
            dy = (0.0 if turns else y) - sy
            dz = work[Z + lane] - sz
            squared = dx * dx + dy * dy + dz * dz
            ahead, left, up = dx * a + dy * d + dz * g, dx * b + dy * e + dz * h, dx * c + dy * f + dz * i
            flat = math.sqrt(ahead * ahead + left * left)
            inside = (squared <= reach * reach) & (ahead * az_cos + left * az_sin >= flat * az_half)
            inside = inside & (flat * el_cos + up * el_sin >= math.sqrt(squared) * el_half)
            work[REACHED + lane] = 1.0 if inside else work[REACHED + lane]


EVERYWHERE = -2.0
"""In place of the cosine of half a circle: there is no angle beyond, whatever the rounding."""
EASE = 0.6
"""Share of an arm's length at which it reaches most directions, whatever way the agent leans."""


class CellsToReach:
    """What reaching asks for, whatever the effort level.

    Args:
        here: Whose ability, and from where.
        cells: What is to be reached.
    """

    def __init__(self, here: Viewpoint, cells: Cells) -> None:
        self.here, self.cells = here, cells
        self.arms = [arm for arm in here.agent.arms if stretch(arm.profile.side) in here.actions]

    def trials(self, level: int) -> Trials | None:
        """The trials of a level, 0 to 4; nothing is held that is not there, so level 0 has none."""
        if level == 0 or not self.arms:
            return None
        footing = footing_of(self.here, level)
        return ReachTrials(self, footing) if len(footing.way) else None


class ReachTrials:
    """The trials of one effort level for reaching cells."""

    def __init__(self, asking: CellsToReach, footing: Footing) -> None:
        self.footing, self.cells, self._asking = footing, asking.cells, asking
        self._table = np.array([self._arms_of(way) for way in range(len(footing.states))])
        tree = tree_of(*self._boxes())
        self._reaches = Reaches(self._table, footing.way, footing.places_m, footing.turns, tree)

    def run(self, sweep: Sweep) -> None:
        """See ``Trials``."""
        reached_cells(self._reaches, sweep, self.cells.starts(sweep.rows))

    def look_closely(self, rows: Indices) -> Mask:
        """Nothing is doubtful."""
        return np.zeros(len(rows), dtype=bool)

    def _arms_of(self, way: int) -> Array:
        """Arms in the frame of a way, (arms, columns)."""
        here, frame = self._asking.here, self.footing.frame(way)
        stage = here.stage.show(self.footing.states[way])
        table = np.empty((len(self._asking.arms), ARM_COLUMNS))
        for row, arm in zip(table, self._asking.arms, strict=True):
            shoulder = stage.shoulder(arm)
            row[SHOULDER:CARRIER] = frame.to_local(shoulder.position)
            row[CARRIER:LENGTH] = (frame.matrix.T @ shoulder.matrix).ravel()
            row[LENGTH:AT_EASE] = _sector(arm.profile)
            row[AT_EASE:] = frame.to_local(shoulder.to_world(_at_ease(arm.profile)))
        return table

    def _boxes(self) -> tuple[Array, Array]:
        """The boxes in which the shoulders stay, least and greatest coordinates, (trials, 3) each."""
        shoulders = self._table[self.footing.way][:, :, SHOULDER:CARRIER]
        low, high = shoulders.min(axis=1), shoulders.max(axis=1)
        if self.footing.turns:
            around = np.hypot(shoulders[..., 0], shoulders[..., 1]).max(axis=1)[:, None]
            low[:, :2], high[:, :2] = self.footing.places_m - around, self.footing.places_m + around
        return low, high


def _sector(arm: Arm) -> tuple[float, ...]:
    """Numbers of a sector; see ``sectors``."""
    mirror = -1.0 if arm.side == "right" else 1.0
    return (arm.length_m, *_between(*arm.azimuth_rad, mirror), *_between(*arm.elevation_rad, 1.0))


def _between(low: float, high: float, mirror: float) -> tuple[float, float, float]:
    """Cosine and sine of the middle of a range of angles, and cosine of half its width."""
    middle, half = (low + high) / 2, (high - low) / 2 + ROUNDING
    return math.cos(middle), mirror * math.sin(middle), math.cos(half) if half < math.pi else EVERYWHERE


def _at_ease(arm: Arm) -> Array:
    """A point in the middle of an arm's sector, in the frame of what carries it, metres, (3,)."""
    azimuth, elevation = sum(arm.azimuth_rad) / 2, sum(arm.elevation_rad) / 2
    flat, mirror = math.cos(elevation), -1.0 if arm.side == "right" else 1.0
    direction = np.array((flat * math.cos(azimuth), mirror * flat * math.sin(azimuth), math.sin(elevation)))
    return EASE * arm.length_m * direction
