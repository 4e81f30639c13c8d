"""Footing: the stances of an effort level from which a map is made, and in which of them nothing is in the way.

They are the candidates of the search (``CandidateSource``), all of them. At level 4 the search turns the chest to its
target; so does a map, to every cell by itself. Only what blocks is tested in steps there: with the chest turned to the
next multiple of ``efforts.turn_step_rad`` from where the agent heads now, not exactly to the cell.

A *way* is how the agent stands: a state. A *trial* is a way somewhere on the floor. Maps of both abilities ask for the
same footing, so it is kept for as long as its viewpoint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.maps.grid import Cells, Grid, solid_cells
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.geometry.transforms import Pose, yaw_of
from taskgist.world.state import State

# --- Places of the floor where an agent may turn as it likes: nothing solid comes near it, whichever way it faces.

LEVEL = 0.999
"""Cosine of the slope of what counts as a level floor."""


def clear_places(here: Viewpoint, state: State, base_m: Array, places_m: Array) -> NDArray[np.bool_]:
    """Whether an agent, standing as in a state, plainly collides with nothing at each place, whatever its heading.

    Turning about the vertical through its base, each of its shapes stays in a cylinder. The boxes around solid shapes
    must keep away from these. The level floor is left out: it is met alike at all places.

    Args:
        here: The agent's viewpoint.
        state: How it stands.
        base_m: Where its base is in that state, metres, (2,).
        places_m: Where it would be instead, metres in the world, (n, 2).

    Returns:
        False where it has to be tested, (n,).
    """
    stage, model, core = here.stage.show(state), here.stage.scene.model, here.agent.core_geoms
    obstacles = here.collisions.obstacles
    endless = model.geom_rbound[obstacles] == 0.0
    matrices = stage.geoms(obstacles)[1].reshape(-1, 3, 3)
    if (matrices[endless, 2, 2] < LEVEL).any():
        return np.zeros(len(places_m), dtype=bool)
    centers, radii = stage.geom_centers(core), np.asarray(model.geom_rbound[core])
    wide = np.linalg.norm(centers[:, :2] - base_m, axis=1) + radii
    middle, half = _extents(here, obstacles[~endless])
    beside = np.abs(centers[:, 2, None] - middle[:, 2]) < radii[:, None] + half[:, 2]
    widest = np.where(beside, wide[:, None], 0.0).max(axis=0)
    away = np.maximum(np.abs(places_m[:, None] - middle[:, :2]) - half[:, :2], 0.0)
    return np.asarray((np.hypot(away[..., 0], away[..., 1]) >= widest).all(axis=1))


def _extents(here: Viewpoint, geoms: NDArray[np.intp]) -> tuple[Array, Array]:
    """How far shapes extend along the world's axes, as the stage shows them: middles and half sizes, metres, (n, 3)."""
    positions, matrices = here.stage.geoms(geoms)
    turns, bounds = matrices.reshape(-1, 3, 3), here.stage.scene.model.geom_aabb[geoms]
    middle = positions + np.einsum("nij,nj->ni", turns, bounds[:, :3])
    return middle, np.einsum("nij,nj->ni", np.abs(turns), bounds[:, 3:])


UNKNOWN, BLOCKED, FREE = -1, 0, 1
AHEAD_M = 1000.0
SAME_M = 1e-9


class Footing:
    """Trials that do not turn to what the agent sees or reaches.

    Attributes:
        states: The ways.
        way: Which of them each trial is, (n,).
        places_m: Where the base stands in each, metres in the world, (n, 2); nowhere unless ``turns``.
        turns: Whether the chest turns to each cell.
        facing: Where the agent heads now, and the step in which what blocks is tested, radians, (2,).
        free: Whether a trial is ``FREE`` or ``BLOCKED`` by the step of the chest, or ``UNKNOWN`` so far, (n, steps).
    """

    turns = False

    def __init__(self, states: Sequence[State], way: NDArray[np.intp], places_m: Array, facing: Array) -> None:
        self.states, self.way, self.places_m, self.facing = states, way, places_m, facing
        self.free: NDArray[np.int8] = np.full((len(way), 1), FREE, dtype=np.int8)

    def frame(self, way: int) -> Pose:  # noqa: ARG002 - as those that turn
        """The frame in which all of a way is told."""
        return Pose(np.zeros(3), np.eye(3))

    def test(self, here: Viewpoint, asked: Mask) -> None:  # noqa: ARG002 - as those that turn
        """Find out about some trials and steps, (n, steps)."""
        assert not asked.any(), "all is known"


class TurningFooting(Footing):
    """Trials that turn: leans of the torso, each at every place of the floor.

    Args:
        here: The agent's viewpoint.
        states: The ways, standing where the walk starts.
        target: What the chest points to in these, metres, at least (2,).
        offsets_m: Places of the floor, from where the walk starts, (places, 2).
    """

    turns = True

    def __init__(self, here: Viewpoint, states: Sequence[State], target: Array, offsets_m: Array) -> None:
        self._bases = [np.array(state.qpos[here.agent.base][:2]) for state in states]
        self._chests_rad = [math.atan2(*(target[:2] - base)[::-1]) for base in self._bases]
        places = [base + offsets_m for base in self._bases]
        facing = np.array((yaw_of(here.state.qpos[here.agent.base][3:]), here.settings.efforts.turn_step_rad))
        way = np.repeat(np.arange(len(states)), len(offsets_m))
        super().__init__(states, way, np.concatenate(places), facing)
        ways = zip(states, self._bases, places, strict=True)
        clear = np.concatenate([clear_places(here, *each) for each in ways])
        steps = round(2 * math.pi / self.facing[1])
        self.free = np.repeat(np.where(clear, FREE, UNKNOWN).astype(np.int8)[:, None], steps, axis=1)
        self._shapes: dict[int, tuple[Array, Array]] = {}

    def frame(self, way: int) -> Pose:
        """A frame that stands under the base and looks along the chest."""
        cos, sin = math.cos(self._chests_rad[way]), math.sin(self._chests_rad[way])
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return Pose(np.array((*self._bases[way], 0.0)), turn)

    def test(self, here: Viewpoint, asked: Mask) -> None:
        """Place the agent's shapes, and ask what they push into."""
        for trial, step in np.argwhere(asked & (self.free == UNKNOWN)).tolist():
            self.free[trial, step] = FREE if self._is_free(here, trial, step) else BLOCKED

    def _is_free(self, here: Viewpoint, trial: int, step: int) -> bool:
        way = int(self.way[trial])
        positions, matrices = self._shapes_of(here, way)
        angle = self.facing[0] + step * self.facing[1]
        cos, sin = math.cos(angle), math.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        place = (*self.places_m[trial], 0.0)
        turned = (turn @ matrices).reshape(-1, 9)
        here.stage.place(here.agent.core_geoms, positions @ turn.T + place, turned)
        return here.collisions.find() is None

    def _shapes_of(self, here: Viewpoint, way: int) -> tuple[Array, Array]:
        """The shapes of head, torso and base in the frame of a way: metres, (n, 3), and (n, 3, 3)."""
        if way not in self._shapes:
            stage, frame = here.stage.show(self.states[way]), self.frame(way)
            positions, matrices = stage.geoms(here.agent.core_geoms)
            self._shapes[way] = frame.to_local(positions), frame.matrix.T @ matrices.reshape(-1, 3, 3)
        return self._shapes[way]


_KEPT: WeakKeyDictionary[Viewpoint, dict[int, Footing]] = WeakKeyDictionary()


def footing_of(here: Viewpoint, level: int) -> Footing:
    """The footing of an effort level, 0 to 4."""
    kept = _KEPT.setdefault(here, {})
    if level not in kept:
        kept[level] = _turning(here) if level == 4 else _standing(here, level)
    return kept[level]


def _standing(here: Viewpoint, level: int) -> Footing:
    """What touches now is no obstacle to staying as one is."""
    batches = here.candidates.of_level(level, here.state.qpos[here.agent.base][:3])
    states = [batch[index].state for batch in batches for index in range(len(batch))]
    if level > 1:
        states = [state for state in states if here.collisions.blocking(state) is None]
    return Footing(states, np.arange(len(states)), np.zeros((len(states), 2)), np.zeros(2))


def _turning(here: Viewpoint) -> Footing:
    base = here.state.qpos[here.agent.base]
    heading = yaw_of(base[3:])
    target = base[:3] + AHEAD_M * np.array([math.cos(heading), math.sin(heading), 0.0])
    batches = list(here.candidates.of_level(4, target))
    if not batches:
        return Footing((), np.arange(0), np.zeros((0, 2)), np.zeros(2))
    offsets = np.unique(np.round(np.concatenate([batch.offsets_m for batch in batches]), 9), axis=0)
    first = batches[0]
    at_start = np.flatnonzero(np.abs(first.offsets_m).max(axis=1) < SAME_M)
    return TurningFooting(here, [first[int(index)].state for index in at_start], target, offsets)


# --- Boxes in a tree: what is in vain for a box around many trials is in vain for each of them.

INNER = -1
LEAF, PAST = 0, 1


class Tree(NamedTuple):
    """A binary tree in the order in which it is walked: each node before its parts.

    Attributes:
        nodes: The box that a leaf stands for, or −1, and the node to go on with if this one is in vain, (n, 2).
        boxes: The box around all boxes under each node: least and greatest coordinates, (n, 6).
    """

    nodes: Indices
    boxes: Array


def tree_of(low: Array, high: Array) -> Tree:
    """The tree of one or more boxes, of their least and greatest coordinates, (n, 3) each."""
    return Tree(*_halved(np.hstack((low, high))))


@compiled
def _halved(boxes: Array) -> tuple[Indices, Array]:
    """Halves boxes again and again by the middle of their longest side."""
    count = len(boxes)
    order, parts = np.arange(count), np.empty((count, 2), dtype=np.intp)
    nodes, around = np.empty((2 * count - 1, 2), dtype=np.intp), np.empty((2 * count - 1, 6))
    parts[0, 0], parts[0, 1] = 0, count
    waiting = 1
    for node in range(len(nodes)):
        waiting -= 1
        start, end = parts[waiting, 0], parts[waiting, 1]
        axis = _enclose(boxes, order, start, end, around, node)
        nodes[node, LEAF] = order[start] if end - start == 1 else INNER
        nodes[node, PAST] = node + 2 * (end - start) - 1
        if end - start > 1:
            split = _parted(boxes, order, start, end, axis, around[node, axis] + around[node, 3 + axis])
            parts[waiting, 0], parts[waiting, 1] = split, end
            parts[waiting + 1, 0], parts[waiting + 1, 1] = start, split
            waiting += 2
    return nodes, around


@compiled
def _enclose(boxes: Array, order: Indices, start: int, end: int, around: Array, node: int) -> int:
    """Writes the box around some boxes; gives its longest axis."""
    longest = 0
    for axis in range(3):
        low, high = np.inf, -np.inf
        for place in range(start, end):
            low, high = min(low, boxes[order[place], axis]), max(high, boxes[order[place], 3 + axis])
        around[node, axis], around[node, 3 + axis] = low, high
        if high - low > around[node, 3 + longest] - around[node, longest]:
            longest = axis
    return longest


@compiled
def _parted(boxes: Array, order: Indices, start: int, end: int, axis: int, twice_middle: float) -> int:
    """Brings the boxes below the middle of an axis to the front; gives where the others begin, half-way if none do."""
    split = start
    for place in range(start, end):
        box = order[place]
        if boxes[box, axis] + boxes[box, 3 + axis] < twice_middle:
            order[place], order[split] = order[split], box
            split += 1
    return split if start < split < end else (start + end) // 2


@compiled
def squared_gap(boxes: Array, box: int, x: float, y: float, z: float) -> float:
    """Squared distance between a point and a box, a row of a table, m²."""
    dx = max(boxes[box, 0] - x, x - boxes[box, 3], 0.0)
    dy = max(boxes[box, 1] - y, y - boxes[box, 4], 0.0)
    dz = max(boxes[box, 2] - z, z - boxes[box, 5], 0.0)
    return float(dx * dx + dy * dy + dz * dz)


# --- Trials: which cells does any of many stances win?
#
# Only that one of them does is asked, not which one needs least, so their order is free. What is in the way is tested
# as late as possible: first all cells are won that some trial wins that is known to be free; then, for the others, a
# few of the trials that would win each are tested, until every cell is won or lost.

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


def winners(here: Viewpoint, trials: Trials, rows: Indices) -> Mask:
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


# --- A workspace: the cells of a grid around an agent, and which of them are solid. All maps of a viewpoint share it.


@dataclass(frozen=True, eq=False)
class Workspace:
    """Cells of a grid.

    Attributes:
        grid: The grid.
        cells: Its cells, block by block.
        solid: Whether each lies in something solid that is not the agent's own, the grid's shape.
    """

    grid: Grid
    cells: Cells
    solid: NDArray[np.bool_]


_LAST: WeakKeyDictionary[Viewpoint, Workspace] = WeakKeyDictionary()


def workspace_of(here: Viewpoint, grid: Grid) -> Workspace:
    """The workspace of an agent as the stage shows it, which is as it stands; the last one is kept."""
    last = _LAST.get(here)
    if last is None or last.grid != grid:
        last = _LAST[here] = Workspace(grid, Cells.of(grid), solid_cells(here.stage, grid, but=here.agent.name))
    return last
