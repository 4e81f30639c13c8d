"""Places on supports where an object could stand, so that agents see or reach it with so much effort at most.

Candidates are the columns of the maps' grid. In each column whatever is level and turned upwards is a support: tables,
shelf boards, seats, the floor. An object is a box; it stands stably if there is level ground of one height under
middle, corners and edges of its base, and it stands free if no solid shape comes into it. Agents never carry anything.
What is asked of the maps is asked of the cell that holds the box's middle.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache, reduce

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import InputError
from taskgist.maps.ability_map import JUDGES, AbilityMap, ability_map
from taskgist.maps.grid import Grid, Zone
from taskgist.perspective.effort import Ability
from taskgist.perspective.queries import All, Condition, Not, Question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.settings import DEFAULT, Settings
from taskgist.world.geometry.shapes import distances_outside_m
from taskgist.world.stage import Stage

DOWN = np.array([[0.0, 0.0, -1.0]])
EVEN_M = 0.005
"""Ground whose heights differ by no more than this under a box carries it (ours)."""
GAP_M = 0.002
"""How far above its support a box is tried, so that touching is no overlap."""
COARSE_M, FINE_M = 0.04, 0.008
"""Spacing of the points of a box with which shapes that come into it are found, and of those where one comes near;
what is thinner than the finer one may be overlooked at an edge."""
NEXT_M = 1e-4
MOST_SUPPORTS = 12
"""Level faces looked for above one another, so that the search ends whatever the model holds."""


@dataclass(frozen=True)
class Place:
    """A place on a support for the middle of an object's base.

    Attributes:
        position_m: Metres in the world.
        support: What would carry it.
    """

    position_m: tuple[float, float, float]
    support: str


def places_for(
    stage: Stage,
    size_m: tuple[float, float, float],
    where: Zone,
    *,
    supports: Iterable[str] | None = None,
    instead_of: str | None = None,
    settings: Settings = DEFAULT,
) -> tuple[Place, ...]:
    """Places where an object of some size could stand in a zone.

    Args:
        stage: The scene in a state.
        size_m: Width, depth and height of the object, along the grid's axes, metres.
        where: Where its middle shall be: zones of ability maps, such as ``map.at_most(2)``, and what ``&``, ``|``,
            ``-`` and ``~`` make of them.
        supports: What may carry it; everything that can if left out.
        instead_of: An object that is to be moved: it neither carries nor blocks.
        settings: For what counts as level.

    Returns:
        In the order of the grid, from below upwards in each column.

    Raises:
        InputError: A size is not positive.
    """
    if not all(0 < side < math.inf for side in size_m):
        raise InputError(
            "an object needs positive sizes", field="size_m", value=size_m, hint="metres, as (0.1, 0.1, 0.2)"
        )
    carriers = frozenset(stage.scene.owners if supports is None else supports) - {instead_of}
    search = _Search(stage, size_m, where.grid, carriers, settings, instead_of)
    found = [
        Place((float(x), float(y), float(height)), owner)
        for x, y in _columns(where)
        for height, owner in search.ground(x, y)
        if where.contains([(x, y, height + size_m[2] / 2)])[0] and search.stands(x, y, height)
    ]
    return tuple(found)


def _columns(where: Zone) -> Array:
    """Middles of the columns of the grid in which a zone has cells, metres in the world, (n, 2)."""
    centers = where.grid.centers().reshape(*where.grid.shape, 3)[:, :, 0, :2]
    return np.asarray(centers[where.cells.any(axis=2)])


class _Search:
    """Level ground, and boxes that stand on it."""

    def __init__(
        self,
        stage: Stage,
        size_m: tuple[float, float, float],
        grid: Grid,
        carriers: frozenset[str | None],
        settings: Settings,
        moved: str | None,
    ) -> None:
        self._stage, self._size, self._grid, self._carriers = stage, size_m, grid, carriers
        self._level = math.cos(settings.contact.support_slope_rad)
        scene = stage.scene
        out = {*scene.agents, moved}
        self._things = [geom for geom, owner in enumerate(scene.owners) if owner not in out and stage.seen[geom]]
        solid = [int(geom) for geom in stage.solid_geoms() if not stage.is_plane(int(geom))]
        self._solid = [geom for geom in solid if scene.owners[geom] != moved]
        self._centers = stage.geom_centers(self._solid)
        self._radii = np.array(scene.model.geom_rbound[self._solid])
        self._top = grid.origin_m[2] + grid.cell_m * grid.shape[2]

    def ground(self, x: float, y: float) -> list[tuple[float, str]]:
        """Heights of all level faces in a column, from below, and what they belong to."""
        found, height = [], self._top
        normal = np.zeros((1, 3))
        for _ in range(MOST_SUPPORTS):
            geoms, distances = self._stage.cast((x, y, height), DOWN, only=self._things, normals=normal)
            if geoms[0] < 0:
                break
            height -= float(distances[0])
            owner = self._stage.scene.owners[int(geoms[0])]
            if normal[0, 2] >= self._level and owner in self._carriers:
                found.append((height, owner))
            height -= NEXT_M
        return found[::-1]

    def stands(self, x: float, y: float, height: float) -> bool:
        """Whether the box stands there stably and free of overlap."""
        return self._free(x, y, height) and self._carried(x, y, height)

    def _carried(self, x: float, y: float, height: float) -> bool:
        halves = [(i, j) for i, j in itertools.product((-0.5, 0.0, 0.5), repeat=2) if (i, j) != (0.0, 0.0)]
        for i, j in halves:
            shift = self._grid.axes[:2, :2] @ (i * self._size[0], j * self._size[1])
            start = (x + shift[0], y + shift[1], height + EVEN_M + GAP_M)
            geoms, distances = self._stage.cast(start, DOWN, only=self._things)
            if geoms[0] < 0 or distances[0] > 2 * EVEN_M + GAP_M:
                return False
        return True

    def _free(self, x: float, y: float, height: float) -> bool:
        """No solid shape comes into the box."""
        middle = np.array((x, y, height + GAP_M + self._size[2] / 2))
        reach_m = math.hypot(*self._size) / 2
        near = np.linalg.norm(self._centers - middle, axis=1) < self._radii + reach_m
        return not any(self._meets(self._solid[int(index)], middle) for index in np.flatnonzero(near))

    def _meets(self, geom: int, middle: Array) -> bool:
        """Whether a shape contains a point of the box: of a coarse grid, or of a fine one where it comes near."""
        points = _filled(self._size, COARSE_M)
        away_m = self._away_m(geom, middle, points)
        if (away_m <= 0.0).any():
            return True
        near = points[away_m <= COARSE_M]
        finer = (near[:, None] + _filled((COARSE_M,) * 3, FINE_M)).reshape(-1, 3)
        half = np.array(self._size) / 2
        return bool((self._away_m(geom, middle, np.clip(finer, -half, half)) <= 0.0).any())

    def _away_m(self, geom: int, middle: Array, points: Array) -> Array:
        pose = self._stage.geom(geom)
        there = middle + points @ self._grid.axes.T
        return distances_outside_m(self._stage.scene.model, geom, pose.to_local(there))


@lru_cache(maxsize=16)
def _filled(size_m: tuple[float, float, float], spacing_m: float) -> Array:
    """Points all over a box about the origin, its faces included, metres, (n, 3)."""
    steps = [np.linspace(-side / 2, side / 2, max(2, math.ceil(side / spacing_m) + 1)) for side in size_m]
    return np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)


# --- Set questions about places: where A reaches, B sees and C does not.


@dataclass(frozen=True, eq=False)
class Answered:
    """A question's answer for every cell.

    Attributes:
        yes: Where it holds, and nothing solid is.
        unknown: Where that cannot be said for want of tracking.
        maps: The maps from which it was found.
    """

    yes: Zone
    unknown: Zone
    maps: tuple[AbilityMap, ...]


def zone_where(efforts: SceneEfforts, question: Question, *, grid: Grid | None = None) -> Answered:
    """Answer a set question for places instead of objects.

    Args:
        efforts: Of one state.
        question: As for ``objects_where``.
        grid: Where; by default the workspaces of all agents that the question names, along the first one's heading.

    Raises:
        InputError: It asks about grasping, for which there are no maps, or about nobody.
        UnknownNameError: There is no such agent.
    """
    agents = dict.fromkeys(agent for agent, _ in question.abilities)
    if not agents or any(ability not in JUDGES for _, ability in question.abilities):
        raise InputError("maps tell where agents see and reach", field="where", hint="ask about see and reach")
    stage = efforts.stage
    for agent in agents:
        stage.scene.agent(agent)
    where = grid or Grid.around(stage, *agents, settings=efforts.settings.maps)
    maps = {
        (agent, ability): ability_map(efforts.viewpoint(agent), ability=ability, grid=where)
        for agent, ability in question.abilities
    }
    solid = reduce(np.logical_or, (each.solid for each in maps.values()))
    free = Zone(where, ~solid)
    yes, no = _split(question, maps)
    return Answered(yes & free, free - yes - no, tuple(maps.values()))


def _split(question: Question, maps: Mapping[tuple[str, Ability], AbilityMap]) -> tuple[Zone, Zone]:
    """Where a question is true, and where it is false."""
    if isinstance(question, Not):
        yes, no = _split(question.part, maps)
        return no, yes
    if isinstance(question, All):
        split = [_split(part, maps) for part in question.parts]
        return reduce(Zone.__and__, (yes for yes, _ in split)), reduce(Zone.__or__, (no for _, no in split))
    assert isinstance(question, Condition), "questions are conditions and what combines them"
    found = maps[question.agent, question.ability]
    yes = found.at_most(question.max_level) - found.at_most(question.min_level - 1)
    return yes, ~(yes | found.unknown)
