"""Which cells an agent sees from many stances, its head aimed at each: the point-like twin of ``see`` (5.1.1)."""

from __future__ import annotations

import math

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.maps.footing import (
    DOUBTFUL,
    FIRST,
    FREE,
    UNKNOWN,
    Footing,
    Sweep,
    Tree,
    Trials,
    footing_of,
    step_of,
    sweep_of,
    tree_of,
)
from taskgist.maps.gaze import EYE_COLUMNS, PLACE, TURNED, Head, eye_positions, head_of, shapes_of_head
from taskgist.maps.grid import Cells
from taskgist.maps.sight import BOUNDS, COLUMNS, KIND, MATRIX, NONE, POSITION, RADIUS, SIZE, Eyes, Shadows, seen_cells
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.geometry.rays import FORMULAS
from taskgist.world.geometry.transforms import Pose
from taskgist.world.stage import Stage

WORLD = Pose(np.zeros(3), np.eye(3))


class CellsToSee:
    """What seeing asks for, whatever the effort level.

    Args:
        here: Whose ability, and from where.
        cells: What is to be seen.
    """

    def __init__(self, here: Viewpoint, cells: Cells) -> None:
        self.here, self.cells = here, cells
        self.head = head_of(here)
        eye = here.agent.profile.eye
        self.view = np.array((math.cos(eye.gaze_cone_rad), *(math.tan(angle / 2) for angle in eye.fov_rad)))
        seen = np.flatnonzero(here.stage.show(here.state).seen)
        mine = np.isin(seen, here.agent.geoms)
        self.own_geoms = np.setdiff1d(seen[mine], shapes_of_head(here))
        self.own = shapes(here.stage, self.own_geoms, WORLD)
        self.things = shapes(here.stage, seen[~mine], WORLD)
        kinds = here.stage.scene.model.geom_type[seen]
        self.meshes = np.setdiff1d(seen[~np.isin(kinds, FORMULAS)], shapes_of_head(here))
        self.hider = np.full(len(cells.points), NONE, dtype=np.int32)

    def trials(self, level: int) -> Trials | None:
        """The trials of a level, 0 to 4; None if there are none."""
        footing = footing_of(self.here, level)
        return SeeTrials(self, footing, self.head if level else self.head.stiff) if len(footing.way) else None


class SeeTrials:
    """The trials of one effort level for seeing cells."""

    def __init__(self, asking: CellsToSee, footing: Footing, head: Head) -> None:
        self.footing, self.cells = footing, asking.cells
        self._asking, self._head = asking, head
        self._cones = head.cones(asking.here.agent.profile.eye.gaze_cone_rad)
        self._eyes, self._own = self._tables()
        marks = np.column_stack((footing.places_m, self._eyes[:, 2]))
        self._first = far_apart(marks, FIRST) if footing.turns else np.arange(len(marks))

    def run(self, sweep: Sweep) -> None:
        """See ``Trials``."""
        self._run(sweep, self._eyes, self._first, self.footing.way)

    def look_closely(self, rows: Indices) -> Mask:
        """Ask for the meshes one by one, trial by trial: they have no formula."""
        won = np.zeros(len(rows), dtype=bool)
        for trial in range(len(self._eyes)):
            left = np.flatnonzero(~won)
            if not len(left):
                break
            one = slice(trial, trial + 1)
            sweep = sweep_of(self, rows[left], np.abs(self.footing.free[one]))  # as free as may be
            self._run(sweep, self._eyes[one], np.array([0]), self.footing.way[one])
            left = left[sweep.found == DOUBTFUL]
            left = left[self._past_meshes(rows[left], trial)]
            won[left] = self._free(rows[left], trial)
        return won

    def _run(self, sweep: Sweep, eyes: Array, first: Indices, way: Indices) -> None:
        asking, own = self._asking, self._own
        seeing = Eyes(self._head.numbers, asking.view, self._cones, eyes, first, self._tree_of(eyes))
        shadows = Shadows(way, own.reshape(-1, COLUMNS), own.shape[1], asking.things, asking.hider)
        seen_cells(seeing, shadows, sweep, self.cells.starts(sweep.rows))

    def _free(self, rows: Indices, trial: int) -> Mask:
        """Whether nothing is in the way when the agent turns to each of some cells."""
        ahead = self.cells.points[rows, :2] - self.footing.places_m[trial]
        count = self.footing.free.shape[1]
        steps = [step_of(self.footing.facing, count, x, y) for x, y in ahead.tolist()]
        asked = np.zeros(self.footing.free.shape, dtype=bool)
        asked[trial, steps] = self.footing.free[trial, steps] == UNKNOWN
        self.footing.test(self._asking.here, asked)
        return np.asarray(self.footing.free[trial, steps] == FREE)

    def _past_meshes(self, rows: Indices, trial: int) -> Mask:
        """Whether rays get past all meshes. An agent that turns has its own where it began."""
        asking = self._asking
        stage = asking.here.stage.show(self.footing.states[self.footing.way[trial]])
        meshes = np.setdiff1d(asking.meshes, asking.here.agent.geoms) if self.footing.turns else asking.meshes
        origins = eye_positions(asking.cells.points, rows, self._head.numbers, asking.view, self._eyes, trial)
        ways = asking.cells.points[rows] - origins
        lengths = np.linalg.norm(ways, axis=1)
        passed = np.ones(len(rows), dtype=bool)
        for row, (origin, way, length) in enumerate(zip(origins, ways, lengths, strict=True)):
            geoms, distances = stage.cast(origin, way[None] / length, only=meshes)
            passed[row] = geoms[0] < 0 or distances[0] >= length
        return passed

    def _tables(self) -> tuple[Array, Array]:
        """Eyes by trial, and own shapes by way."""
        here, footing = self._asking.here, self.footing
        by_way = np.zeros((len(footing.states), EYE_COLUMNS))
        own = np.repeat(self._asking.own[None], len(footing.states), axis=0)
        for way, state in enumerate(footing.states):
            frame = footing.frame(way)
            eye = here.stage.show(state.replace(self._head.middle)).eye(here.agent)
            by_way[way, :3], by_way[way, 3:PLACE] = frame.to_local(eye.position), (frame.matrix.T @ eye.matrix).ravel()
            _place(own[way], here.stage.show(state), self._asking.own_geoms, frame)
        eyes = by_way[footing.way]
        eyes[:, PLACE:TURNED], eyes[:, TURNED] = footing.places_m, footing.turns
        return eyes, own

    def _tree_of(self, eyes: Array) -> Tree:
        """The tree of the boxes in which eyes stay."""
        middle, half = (self._head.low_m + self._head.high_m) / 2, (self._head.high_m - self._head.low_m) / 2
        matrices = eyes[:, 3:PLACE].reshape(-1, 3, 3)
        center, around = eyes[:, :3] + matrices @ middle, np.abs(matrices) @ half
        low, high = center - around, center + around
        if self.footing.turns:
            wide = np.hypot(*np.maximum(-low, high)[:, :2].T)[:, None]
            low[:, :2], high[:, :2] = eyes[:, PLACE:TURNED] - wide, eyes[:, PLACE:TURNED] + wide
        return tree_of(low, high)


def far_apart(marks: Array, count: int) -> Indices:
    """Indices of some points, (n, k), as many as asked for or all: each is the farthest from those before it."""
    chosen = [0]
    away = np.linalg.norm(marks - marks[0], axis=1)
    while len(chosen) < min(count, len(marks)):
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(marks - marks[chosen[-1]], axis=1))
    return np.array(chosen)


def shapes(stage: Stage, geoms: Indices, frame: Pose) -> Array:
    """A table of some shapes where the stage shows them, in a frame; see ``shadow``."""
    model = stage.scene.model
    table = np.empty((len(geoms), COLUMNS))
    table[:, KIND], table[:, SIZE:BOUNDS] = model.geom_type[geoms], model.geom_size[geoms]
    table[:, BOUNDS:RADIUS] = model.geom_aabb[geoms]
    table[:, RADIUS] = np.where(model.geom_rbound[geoms] == 0.0, np.inf, model.geom_rbound[geoms])
    _place(table, stage, geoms, frame)
    return table


def _place(table: Array, stage: Stage, geoms: Indices, frame: Pose) -> None:
    """Puts shapes of a table where the stage shows them."""
    positions, matrices = stage.geoms(geoms)
    table[:, POSITION:MATRIX] = frame.to_local(positions)
    table[:, MATRIX:] = (frame.matrix.T @ matrices.reshape(-1, 3, 3)).reshape(-1, 9)
