"""Which cells an agent sees from many stances, its head aimed at each: the point-like twin of ``see`` (5.1.1)."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.maps.head import Head, head_of, shapes_of_head
from taskgist.perspective.maps.sight import (
    COLUMNS,
    NONE,
    NOT_SEEN,
    PLACE,
    SEEN,
    SEEN_UNLESS_MESH,
    TURNED,
    eye_positions,
    hidden_from_box,
    seen_cells,
)
from taskgist.perspective.maps.trials import (
    Facing,
    FreeFacing,
    Indices,
    Mask,
    Trial,
    always_free,
    facings,
    free_in,
    stances_of,
)
from taskgist.world import Pose, Stage, State
from taskgist.world.geometry.raycast import FORMULAS

Array = NDArray[np.float64]


class SeeTrials:
    """The trials of each effort level for seeing the cells of a grid.

    Args:
        here: Whose ability, and from where.
        centers: Centres of the cells, metres, (cells, 3).
    """

    def __init__(self, here: Standpoint, centers: Array) -> None:
        self._here, self._centers = here, centers
        self._head = head_of(here)
        eye = here.agent.profile.eye
        across, up = eye.fov_rad
        self._views = (math.cos(eye.gaze_cone_rad), math.tan(across / 2), math.tan(up / 2))
        seen = np.flatnonzero(here.stage.show(here.state).seen)
        mine = np.isin(seen, here.agent.geoms)
        self._own_geoms = np.setdiff1d(seen[mine], shapes_of_head(here))
        self._thing_geoms = seen[~mine]
        self._things = _shapes(here.stage, self._thing_geoms, _in_world)
        self._meshes = self._formless(seen)
        self._hider = np.full(len(centers), NONE, dtype=np.int32)

    def of(self, level: int) -> list[Trial]:
        """Trials of a level, 0 to 4."""
        if level == 0:
            return [self._fixed(self._here.state, self._head.stiff, always_free)]
        if level == 4:
            ways = facings(self._here)
            views = [(way, self._eyes(way.state, way.local), self._own(way.state, way.local)) for way in ways]
            return [self._turned(*view, spot) for view in views for spot in range(len(view[0].places_m))]
        return [
            self._fixed(stance.state, self._head, free_in(self._here, stance.state) if level > 1 else always_free)
            for stance in stances_of(self._here, level)
        ]

    def cull(self, cells: Indices, low_m: Array, high_m: Array) -> Mask:
        """Cells that are hidden from wherever the eye may be."""
        return hidden_from_box(self._centers, cells, self._things, self._hider, low_m, high_m)

    def _fixed(self, state: State, head: Head, free: Callable[[Indices], Mask]) -> Trial:
        eyes, own = self._eyes(state, _in_world), self._own(state, _in_world)
        mark = eyes[[0, 1, 2, 3, 6, 9]]  # where it is, and where it looks
        low, high = _box(head, eyes)
        return Trial(low, high, mark, self._able(head, eyes, own, state), free)

    def _turned(self, way: Facing, eyes: Array, own: Array, spot: int) -> Trial:
        place = way.places_m[spot]
        eyes = np.array(eyes)
        eyes[PLACE:TURNED], eyes[TURNED] = place, 1.0
        low, high = _box(self._head, eyes)
        wide = float(np.hypot(*np.maximum(-low, high)[:2]))
        low, high = np.array((*(place - wide), low[2])), np.array((*(place + wide), high[2]))
        free = FreeFacing(self._here, way, place, self._centers, clear=bool(way.clear[spot]))
        return Trial(low, high, (low + high) / 2, self._able(self._head, eyes, own, way.state), free)

    def _able(self, head: Head, eyes: Array, own: Array, state: State) -> Callable[[Indices], Mask]:
        limit = head.off_rad + self._here.agent.profile.eye.gaze_cone_rad
        off = (math.cos(limit), math.sin(limit)) if limit < math.pi else (-1.0, 0.0)
        gaze = np.array((*self._views, *off))

        def able(cells: Indices) -> Mask:
            found = seen_cells(self._centers, cells, head.numbers, gaze, eyes, own, self._things, self._hider)
            doubtful = np.flatnonzero(found == SEEN_UNLESS_MESH)
            if len(doubtful):
                found[doubtful] = self._past_meshes(cells[doubtful], head, eyes, state)
            return np.asarray(found == SEEN)

        return able

    def _past_meshes(self, cells: Indices, head: Head, eyes: Array, state: State) -> NDArray[np.uint8]:
        """Asks for the meshes one by one: they have no formula. An agent that turns has its own where it began."""
        stage = self._here.stage.show(state)
        meshes = np.setdiff1d(self._meshes, self._here.agent.geoms) if eyes[TURNED] else self._meshes
        origins = eye_positions(self._centers, cells, head.numbers, eyes)
        ways = self._centers[cells] - origins
        lengths = np.linalg.norm(ways, axis=1)
        found = np.full(len(cells), SEEN, dtype=np.uint8)
        for row, (origin, way, length) in enumerate(zip(origins, ways, lengths, strict=True)):
            geoms, distances = stage.cast(origin, way[None] / length, only=meshes)
            if geoms[0] >= 0 and distances[0] < length:
                found[row] = NOT_SEEN
        return found

    def _eyes(self, state: State, local: Callable[[Pose], tuple[Array, Array]]) -> Array:
        position, matrix = local(self._here.stage.show(state.replace(self._head.middle)).eye(self._here.agent))
        return np.array((*position, *matrix.ravel(), 0.0, 0.0, 0.0))

    def _own(self, state: State, local: Callable[[Pose], tuple[Array, Array]]) -> Array:
        return _shapes(self._here.stage.show(state), self._own_geoms, local)

    def _formless(self, geoms: Indices) -> Indices:
        kinds = self._here.stage.scene.model.geom_type[geoms]
        return np.setdiff1d(geoms[~np.isin(kinds, FORMULAS)], shapes_of_head(self._here))


def _box(head: Head, eyes: Array) -> tuple[Array, Array]:
    """The box in which the eye stays from a stance, in the frame of that stance."""
    middle, half = (head.low_m + head.high_m) / 2, (head.high_m - head.low_m) / 2
    position, matrix = eyes[:3], eyes[3:PLACE].reshape(3, 3)
    center, around = position + matrix @ middle, np.abs(matrix) @ half
    return center - around, center + around


def _in_world(pose: Pose) -> tuple[Array, Array]:
    return pose.position, pose.matrix


def _shapes(stage: Stage, geoms: Indices, local: Callable[[Pose], tuple[Array, Array]]) -> Array:
    """A table of some shapes where the stage shows them, in the frame of ``local``; see ``maps_sight``."""
    model = stage.scene.model
    radii = np.where(model.geom_rbound[geoms] == 0.0, np.inf, model.geom_rbound[geoms])
    table = np.empty((len(geoms), COLUMNS))
    for row, geom in enumerate(geoms.tolist()):
        at, turn = local(stage.geom(geom))
        kind = float(model.geom_type[geom])
        table[row] = (kind, *model.geom_size[geom], *model.geom_aabb[geom], radii[row], *at, *turn.ravel())
    return table
