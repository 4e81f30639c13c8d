"""Places on supports where an object could stand, so that agents see or reach it with so much effort at most.

Candidates are the columns of the maps' grid. In each column whatever is level and turned upwards is a support: tables,
shelf boards, seats, the floor. An object is a box; it stands stably if there is level ground of one height under
middle, corners and edges of its base, and it stands free if no solid shape comes into it. Agents never carry anything.
What is asked of the maps is asked of the cell that holds the box's middle.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass
from functools import lru_cache, reduce

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled
from taskgist.errors import InputError
from taskgist.maps.ability_map import JUDGES, AbilityMap, ability_map
from taskgist.maps.grid import Grid, Zone
from taskgist.perspective.effort import Ability
from taskgist.perspective.queries import All, Condition, Not, Question
from taskgist.perspective.scene_efforts import SceneEfforts
from taskgist.settings import DEFAULT, Settings
from taskgist.world.geometry.distances import RADIUS, boxes_gap_m, surely_overlap
from taskgist.world.geometry.rays import Shapes, local, normal_at, surface
from taskgist.world.geometry.shapes import distances_outside_m
from taskgist.world.geometry.solids import FIELD
from taskgist.world.stage import Stage

EVEN_M = 0.005
"""Ground whose heights differ by no more than this under a box carries it (ours)."""
GAP_M = 0.002
"""How far above its support a box is tried, so that touching is no overlap."""
COARSE_M, FINE_M = 0.04, 0.008
"""Spacing of the points of a box with which round shapes and meshes that come into it are found, and of those where one
comes near; what is thinner than the finer one may be overlooked at an edge. Boxes are held against it exactly."""
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
    ground = Ground(stage, settings, but=instead_of)
    columns = _columns(where)
    if supports is not None:
        columns = columns[_over(stage, carriers, columns)]
    top = where.grid.origin_m[2] + where.grid.cell_m * where.grid.shape[2]
    bases, owners = ground.level_faces(columns, top, carriers)
    chosen = np.flatnonzero(where.contains(bases + (0.0, 0.0, size_m[2] / 2)))
    chosen = chosen[_carried(ground, bases[chosen], size_m, where.grid.axes)]
    chosen = chosen[_free(stage, bases[chosen], size_m, where.grid.axes, but=instead_of)]
    places = [(*bases[row].tolist(), owners[row]) for row in chosen.tolist()]
    return tuple(Place((x, y, height), owner) for x, y, height, owner in places)


def _columns(where: Zone) -> Array:
    """Middles of the columns of the grid in which a zone has cells, metres in the world, (n, 2)."""
    centers = where.grid.centers().reshape(*where.grid.shape, 3)[:, :, 0, :2]
    return np.asarray(centers[where.cells.any(axis=2)])


def _over(stage: Stage, carriers: Set[str | None], columns: Array) -> Mask:
    """Which columns, (n, 2), may meet some carriers: those that cross the boxes around their shapes."""
    over = np.zeros(len(columns), dtype=bool)
    geoms = np.flatnonzero([owner in carriers for owner in stage.scene.owners])
    for low, high in stage.bounds_of_each(geoms):
        over |= ((columns >= low[:2]) & (columns <= high[:2])).all(axis=1)
    return over


# --- Ground: what vertical rays meet that things can stand on.


class Ground:
    """Faces of furniture and things in the state that a stage shows, as rays from above meet them; nobody's body.

    Args:
        stage: The scene in a state.
        settings: For what counts as level.
        but: An object that is to be moved; it is passed through.
    """

    def __init__(self, stage: Stage, settings: Settings = DEFAULT, *, but: str | None = None) -> None:
        self._stage, self._level = stage, math.cos(settings.contact.support_slope_rad)
        scene = stage.scene
        out = {*scene.agents, but}
        things = [geom for geom, owner in enumerate(scene.owners) if owner not in out and stage.seen[geom]]
        of_formula, of_none = _parted(things, stage.shapes.formless)
        self._shapes, self._bounds = of_formula, stage.bounds_of_each(of_formula)
        counts = [_triangle_count(stage, geom) for geom in of_none.tolist()]
        few = np.array([0 < count <= FEW_TRIANGLES for count in counts], dtype=bool)
        self._corners, self._of_corners = _triangles(stage, of_none[few])
        self._meshes, self._mesh_bounds = of_none[~few], stage.bounds_of_each(of_none[~few])

    def beneath(self, origins: Array) -> tuple[Indices, Array, Array]:
        """What rays that go straight down meet first.

        Args:
            origins: Where they start, metres, (n, 3).

        Returns:
            The shapes, −1 for none, (n,); how far beneath they are, metres, infinite for none, (n,); and how far their
            outward normals point upwards, from −1 to 1, (n,).
        """
        self._stage.count_rays(len(origins))
        geoms, drops_m, upward = _first_beneath(self._stage.shapes, self._shapes, self._bounds, origins)
        _first_triangle_beneath(self._corners, self._of_corners, origins, geoms, drops_m, upward)
        for ray in np.flatnonzero(_over_any(origins, self._mesh_bounds)).tolist():
            normal = np.zeros((1, 3))
            (geom,), (drop_m,) = self._stage.cast(origins[ray], DOWN, only=self._meshes, normals=normal)
            if geom >= 0 and drop_m < drops_m[ray]:
                geoms[ray], drops_m[ray], upward[ray] = geom, drop_m, normal[0, 2]
        return geoms, drops_m, upward

    def level_faces(self, columns: Array, top_m: float, carriers: Set[str | None]) -> tuple[Array, list[str]]:
        """All level faces in some columns, from below in each.

        Args:
            columns: Metres in the world, (n, 2).
            top_m: Height from which they are looked for.
            carriers: Whose faces count.

        Returns:
            Where they are, metres, (m, 3), in the order of the columns, and whose they are.
        """
        owners, rows = self._stage.scene.owners, np.arange(len(columns))
        at = np.column_stack((columns, np.full(len(columns), top_m)))
        found, columns_of, geoms_of = [np.empty((0, 3))], [rows[:0]], [rows[:0]]
        for _ in range(MOST_SUPPORTS):
            geoms, drops_m, upward = self.beneath(at)
            met = geoms >= 0
            rows, geoms, at = rows[met], geoms[met], at[met] - np.outer(drops_m[met], UP)
            counts = (upward[met] >= self._level) & np.array([owners[geom] in carriers for geom in geoms], dtype=bool)
            found.append(at[counts])
            columns_of.append(rows[counts])
            geoms_of.append(geoms[counts])
            at = at - NEXT_M * UP
            if not len(rows):
                break
        column, faces = np.concatenate(columns_of), np.concatenate(found)
        order = np.lexsort((faces[:, 2], column))
        return faces[order], [owners[geom] for geom in np.concatenate(geoms_of)[order]]


DOWN = np.array([[0.0, 0.0, -1.0]])
UP = -DOWN[0]


FEW_TRIANGLES = 2000
"""Rays at meshes of more triangles are left to MuJoCo, which sorts them first."""


def _triangle_count(stage: Stage, geom: int) -> int:
    """Of a mesh; 0 for a height field."""
    model = stage.scene.model
    return 0 if model.geom_type[geom] == FIELD else int(model.mesh_facenum[model.geom_dataid[geom]])


def _triangles(stage: Stage, meshes: Indices) -> tuple[Array, Indices]:
    """Corners of the triangles of some meshes in the world, (n, 3, 3), and whose they are, (n,)."""
    model, corners, owners = stage.scene.model, [np.empty((0, 3, 3))], [np.empty(0, dtype=np.intp)]
    for geom in meshes.tolist():
        mesh = int(model.geom_dataid[geom])
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]].astype(float)
        faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
        corners.append(stage.geom(geom).to_world(vertices)[faces])
        owners.append(np.full(len(faces), geom, dtype=np.intp))
    return np.concatenate(corners), np.concatenate(owners)


@compiled
def _first_triangle_beneath(
    corners: Array, of: Indices, origins: Array, first: Indices, nearest: Array, upward: Array
) -> None:
    """Put triangles, (k, 3, 3), that are nearer beneath some points in the place of what was found so far."""
    for k in range(len(corners)):
        ax, ay, az = corners[k, 0, 0], corners[k, 0, 1], corners[k, 0, 2]
        bx, by, bz = corners[k, 1, 0] - ax, corners[k, 1, 1] - ay, corners[k, 1, 2] - az
        cx, cy, cz = corners[k, 2, 0] - ax, corners[k, 2, 1] - ay, corners[k, 2, 2] - az
        nx, ny, nz = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        if abs(nz) <= 1e-12 * length or length == 0.0:
            continue
        for ray in range(len(origins)):
            px, py = origins[ray, 0] - ax, origins[ray, 1] - ay
            u, v = (px * cy - py * cx) / nz, (bx * py - by * px) / nz
            if u < 0.0 or v < 0.0 or u + v > 1.0:
                continue
            drop = origins[ray, 2] - (az + u * bz + v * cz)
            if 0.0 <= drop < nearest[ray]:
                first[ray], nearest[ray], upward[ray] = of[k], drop, nz / length


def _parted(geoms: list[int], formless: Mask) -> tuple[Indices, Indices]:
    """Shapes with a formula for the rays that meet them, and the others."""
    every = np.array(geoms, dtype=np.intp)
    return every[~formless[every]], every[formless[every]]


def _over_any(points: Array, bounds: Array) -> Mask:
    """Which points, (n, 3), stand over or within any box, (k, 2, 3)."""
    over = np.zeros(len(points), dtype=bool)
    for low, high in bounds:
        over |= ((points[:, :2] >= low[:2]) & (points[:, :2] <= high[:2])).all(axis=1) & (points[:, 2] >= low[2])
    return over


@compiled
def _first_beneath(of: Shapes, shapes: Indices, bounds: Array, origins: Array) -> tuple[Indices, Array, Array]:
    """The first of some shapes beneath each point, (n, 3); see ``Ground.beneath``; their boxes are (k, 2, 3)."""
    first, nearest = np.full(len(origins), -1, dtype=np.intp), np.full(len(origins), np.inf)
    upward = np.zeros(len(origins))
    for ray in range(len(origins)):
        px, py, pz = origins[ray, 0], origins[ray, 1], origins[ray, 2]
        for k in range(len(shapes)):
            if px < bounds[k, 0, 0] or px > bounds[k, 1, 0] or py < bounds[k, 0, 1] or py > bounds[k, 1, 1]:
                continue
            if pz < bounds[k, 0, 2] or pz - bounds[k, 1, 2] >= nearest[ray]:
                continue
            shape = shapes[k]
            m, size, kind = of.matrices[shape], of.sizes[shape], of.kinds[shape]
            x, y, z = local(m, origins[ray] - of.positions[shape])
            dx, dy, dz = -m[6], -m[7], -m[8]
            t = surface(kind, size[0], size[1], size[2], x, y, z, dx, dy, dz)
            if t < nearest[ray]:
                first[ray], nearest[ray] = shape, t
                n = normal_at(kind, size[0], size[1], size[2], x + t * dx, y + t * dy, z + t * dz)
                upward[ray] = m[6] * n[0] + m[7] * n[1] + m[8] * n[2]
    return first, nearest, upward


# --- Boxes that stand on it, and free.


def _carried(ground: Ground, bases: Array, size_m: tuple[float, float, float], axes: Array) -> Mask:
    """Whether there is ground of one height under corners and edges of boxes at some places, (n, 3)."""
    halves = np.array([(i, j, 0.0) for i, j in itertools.product((-0.5, 0.0, 0.5), repeat=2) if (i, j) != (0.0, 0.0)])
    rim = bases[:, None] + (halves * size_m) @ axes.T + (EVEN_M + GAP_M) * UP
    _, drops_m, _ = ground.beneath(rim.reshape(-1, 3))
    return np.asarray((drops_m <= 2 * EVEN_M + GAP_M).reshape(-1, len(halves)).all(axis=1))


def _free(stage: Stage, bases: Array, size_m: tuple[float, float, float], axes: Array, *, but: str | None) -> Mask:
    """Whether no solid shape comes into boxes at some places, (n, 3)."""
    middles = bases + (GAP_M + size_m[2] / 2) * UP
    half = np.array(size_m) / 2
    row = np.array([0.0, 0.0, 0.0, *axes.ravel(), *half, np.linalg.norm(half), half.min(), 1.0])
    free = np.ones(len(bases), dtype=bool)
    solid = [geom for geom in stage.solid_geoms().tolist() if stage.scene.owners[geom] != but]
    solid = [geom for geom in solid if not stage.is_plane(geom)]
    table = stage.boxes(np.array(solid, dtype=np.intp))
    for k, geom in enumerate(solid):
        met = _box_meets(row, middles, free, table, k)
        free[met == MEETS] = False
        for place in np.flatnonzero(met == MAY_MEET).tolist():
            free[place] = not _comes_in(stage, geom, middles[place], size_m, axes)
    return free


CLEAR, MAY_MEET, MEETS = 0, 1, 2


@compiled
def _box_meets(box: Array, middles: Array, which: Mask, table: Array, other: int) -> NDArray[np.int8]:
    """Whether a box, a row of a table of boxes, meets another shape of such a table, from some places, (n, 3)."""
    found, first = np.zeros(len(middles), dtype=np.int8), box.reshape(1, -1).copy()
    reach_m = box[RADIUS] + table[other, RADIUS]
    for place in range(len(middles)):
        if not which[place]:
            continue
        away_m2 = 0.0
        for axis in range(3):
            first[0, axis] = middles[place, axis]
            away_m2 += (middles[place, axis] - table[other, axis]) ** 2
        if away_m2 >= reach_m * reach_m or boxes_gap_m(first, 0, table, other, 0.0) >= 0.0:
            continue
        found[place] = MEETS if surely_overlap(first, 0, table, other, 0.0) else MAY_MEET
    return found


def _comes_in(stage: Stage, geom: int, middle: Array, size_m: tuple[float, float, float], axes: Array) -> bool:
    """Whether a shape contains a point of the box: of a coarse grid, or of a fine one where it comes near."""
    pose, model = stage.geom(geom), stage.scene.model

    def away_m(points: Array) -> Array:
        return distances_outside_m(model, geom, pose.to_local(middle + points @ axes.T))

    points = _filled(size_m, COARSE_M)
    away = away_m(points)
    if (away <= 0.0).any():
        return True
    finer = (points[away <= COARSE_M][:, None] + _filled((COARSE_M,) * 3, FINE_M)).reshape(-1, 3)
    half = np.array(size_m) / 2
    return bool((away_m(np.clip(finer, -half, half)) <= 0.0).any())


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
