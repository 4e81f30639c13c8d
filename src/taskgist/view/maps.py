"""Pictures of ability maps: the workspace from above and in space, side by side, with people and things."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle
from matplotlib.ticker import MultipleLocator
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.maps.ability_map import AbilityMap
from taskgist.maps.grid import Grid, Zone
from taskgist.maps.places import Place
from taskgist.view.rendering import looking, pinhole, render, save_figure
from taskgist.world.geometry.transforms import Pose, yaw_of
from taskgist.world.stage import Stage

# --- People and things on a map from above, in the room's coordinates, with names that do not cover each other.

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


COLOURS = ((0.99, 0.80, 0.18), (0.50, 0.76, 0.25), (0.13, 0.60, 0.54), (0.20, 0.40, 0.66), (0.36, 0.17, 0.47))
"""Of levels 0 to 4: from light, little effort, to dark."""
NOTHING = 5
HIGH_M, ABOVE_PIXEL_M = 150.0, 0.0075
FADED = 0.75
"""How much of the room's colours is left under a map."""
SPACE_PX = (560, 440)
SPACE_FOV_RAD = (math.radians(52), math.radians(42))
STEP_SHARE = 0.5
"""Samples along a ray of the view in space, as a share of a cell."""
SURFACE = (0.14, 0.12, 0.11, 0.08, 0.03)
"""Opacity of one sample on the surface of each level's cells: what takes much effort surrounds all else."""
FAINTEST, DENSEST = 0.25, 0.7
"""Opacity of columns in which one cell, or half of them, belong to what is shown."""
LAST = 0.6
"""Of which the greatest level has so much: it surrounds all else."""
SIDES = (-114, -66, 66, 114, -24, 24, 156, -156)
"""From where the view in space may look, degrees from the grid's first axis, the usual one first."""
PROBES = 150
"""Cells that decide from which side most of them are seen."""


@dataclass(frozen=True, eq=False)
class Layers:
    """What a picture shows of each cell.

    Attributes:
        grid: The grid.
        levels: What to colour each cell by, 0 to 4, or 5 for nothing, the grid's shape.
        names: What the levels are called.
        places: Places on supports to mark.
    """

    grid: Grid
    levels: NDArray[np.integer]
    names: Mapping[int, str]
    places: Sequence[Place] = field(default_factory=tuple)

    @classmethod
    def of_map(
        cls, found: AbilityMap, names: Sequence[str], *, max_level: int = 4, places: Sequence[Place] = ()
    ) -> Layers:
        """A map's levels, up to one of them."""
        levels = np.where((found.levels >= 0) & (found.levels <= max_level), found.levels, NOTHING)
        return cls(found.grid, levels, {level: names[level] for level in range(max_level + 1)}, places)

    @classmethod
    def of_zone(cls, zone: Zone, name: str, places: Sequence[Place] = ()) -> Layers:
        """A zone, in one colour."""
        return cls(zone.grid, np.where(zone.cells, 2, NOTHING), {2: name}, places)


def map_picture(stage: Stage, layers: Layers, path: Path, *, title: str) -> Path:
    """Save a picture of cells: from above, coloured by the least level in each column, and in space.

    Args:
        stage: The scene in the state that was mapped.
        layers: What to show.
        path: The PNG file to write.
        title: Title of the whole picture.
    """
    figure = Figure(figsize=(13, 6.4), layout="constrained")
    figure.suptitle(title, fontsize=13)
    above, space = figure.subplots(1, 2, gridspec_kw={"width_ratios": [1, 1.12]})
    draw_above(above, stage, layers)
    draw_space(space, stage, layers)
    shown = [level for level in layers.names if (layers.levels == level).any()]
    handles = [Patch(color=COLOURS[level], label=layers.names[level]) for level in shown]
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), frameon=False, fontsize=10)
    return save_figure(figure, path)


def draw_above(axes: Axes, stage: Stage, layers: Layers) -> None:
    """Draw the grid from above in the room's coordinates, x to the right; the fuller a column, the stronger."""
    grid = layers.grid
    low, high = _corners(grid)
    axes.imshow(1 - FADED * (1 - _from_above(stage, low, high)), extent=(low[0], high[0], low[1], high[1]))
    width, depth = (count * grid.cell_m for count in grid.shape[:2])
    placed = Affine2D().rotate(grid.yaw_rad).translate(*grid.origin_m[:2]) + axes.transData
    image = np.swapaxes(_columns(layers), 0, 1)
    axes.imshow(image, origin="lower", extent=(0.0, width, 0.0, depth), interpolation="nearest", transform=placed)
    axes.add_patch(Rectangle((0, 0), width, depth, fill=False, edgecolor="0.35", linewidth=0.8, transform=placed))
    draw_people(axes, stage)
    draw_things(axes, stage, low, high)
    spots = np.array([place.position_m for place in layers.places]).reshape(-1, 3)
    axes.plot(*spots[:, :2].T, ".", color="black", markersize=2.5)
    shown = "the least effort in each column" if len(layers.names) > 1 else "the stronger, the more of a column"
    axes.set_title(f"from above: {shown}", fontsize=10)
    axes.set_xlabel("x of the room, metres", fontsize=9)
    axes.set_ylabel("y of the room, metres", fontsize=9)
    axes.set_xlim(low[0], high[0])
    axes.set_ylim(low[1], high[1])
    axes.set_aspect("equal")
    axes.xaxis.set_major_locator(MultipleLocator(0.5))
    axes.yaxis.set_major_locator(MultipleLocator(0.5))
    axes.grid(color="0.3", linewidth=0.3, alpha=0.5)
    axes.tick_params(labelsize=8)


def _columns(layers: Layers) -> Array:
    """Colour and opacity of each column of cells, (columns of the grid, 4)."""
    levels = layers.levels
    share, least = (levels < NOTHING).mean(axis=2), levels.min(axis=2)
    opacity = np.where(share > 0, FAINTEST + (DENSEST - FAINTEST) * np.minimum(1.0, 2 * share), 0.0)
    opacity[least == max(layers.names)] *= LAST if len(layers.names) > 1 else 1.0
    palette = np.array((*COLOURS, (1.0, 1.0, 1.0)))
    return np.concatenate((palette[least], opacity[..., None]), axis=2)


def _corners(grid: Grid) -> tuple[Array, Array]:
    """Opposite corners, in the room and along its axes, of what holds the whole grid: metres, (2,) each."""
    width, depth = (count * grid.cell_m for count in grid.shape[:2])
    flat = np.array([(0, 0, 0), (width, 0, 0), (width, depth, 0), (0, depth, 0)]) @ grid.axes.T + grid.origin_m
    return flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)


def _from_above(stage: Stage, low: Array, high: Array) -> Array:
    """The room from so high above that all rays are as good as parallel."""
    width, depth = (float(side) for side in high - low)
    center = np.array((*(low + high) / 2, HIGH_M))
    right, ahead, up = np.eye(3)
    pixels = (round(width / ABOVE_PIXEL_M), round(depth / ABOVE_PIXEL_M))
    angles = (2 * math.atan(width / 2 / HIGH_M), 2 * math.atan(depth / 2 / HIGH_M))
    return render(stage, Pose(center, np.stack((-up, -right, ahead), axis=1)), pinhole(angles, *pixels)).rgb


def draw_space(axes: Axes, stage: Stage, layers: Layers) -> None:
    """Draw the room from the side with the cells as a translucent surface in it."""
    camera = _camera(stage, layers)
    directions = pinhole(SPACE_FOV_RAD, *SPACE_PX)
    room = render(stage, camera, directions).rgb
    rays = directions.reshape(-1, 3) @ camera.matrix.T
    geoms, met_m = stage.cast(camera.position, rays)
    met_m[geoms < 0] = np.inf
    veil, clear = _through(layers, camera.position, rays, met_m)
    image = room * clear.reshape(room.shape[:2])[..., None] + veil.reshape(room.shape)
    axes.imshow(np.clip(image, 0, 1))
    axes.set_title("in space", fontsize=10)
    axes.set_axis_off()


def _through(layers: Layers, origin: Array, rays: Array, met_m: Array) -> tuple[Array, Array]:
    """Colour that cells add along rays, (n, 3), and the share of light from behind that they let through, (n,)."""
    grid, shell = layers.grid, _surface(layers.levels)
    palette, opacity = np.array(COLOURS), np.array(SURFACE)
    veil, clear = np.zeros((len(rays), 3)), np.ones(len(rays))
    local, ways = (origin - grid.origin_m) @ grid.axes / grid.cell_m, rays @ grid.axes / grid.cell_m
    enter_m, leave_m = _within(shell, local, ways)
    leave_m = np.minimum(leave_m, met_m)
    active, at_m = np.flatnonzero(enter_m < leave_m), enter_m
    while len(active):
        cells = np.floor(local + at_m[active, None] * ways[active]).astype(int)
        levels = shell[tuple(np.clip(cells, 0, np.array(grid.shape) - 1).T)]
        near, shown = active[levels < NOTHING], levels[levels < NOTHING]
        veil[near] += (clear[near] * opacity[shown])[:, None] * palette[shown]
        clear[near] *= 1 - opacity[shown]
        at_m[active] += STEP_SHARE * grid.cell_m
        active = active[at_m[active] < leave_m[active]]
    return veil, clear


def _within(shell: NDArray[np.integer], local: Array, ways: Array) -> tuple[Array, Array]:
    """Where rays enter and leave the box around all cells that are shown, metres, (n,) each; in cells, (3,), (n, 3)."""
    shown = np.argwhere(shell < NOTHING)
    if not len(shown):
        return np.full(len(ways), np.inf), np.zeros(len(ways))
    low, high = shown.min(axis=0), shown.max(axis=0) + 1
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (low - local) / ways, (high - local) / ways
    enter = np.nanmax(np.minimum(first, second), axis=1)
    return np.maximum(enter, 0.0), np.nanmin(np.maximum(first, second), axis=1)


def _surface(levels: NDArray[np.integer]) -> NDArray[np.integer]:
    """Levels of cells that have a neighbour of another level, 5 for all others."""
    padded = np.pad(levels, 1, constant_values=NOTHING)
    differs = np.zeros(levels.shape, dtype=bool)
    for axis in range(3):
        for shift in (-1, 1):
            neighbour = np.roll(padded, shift, axis=axis)[1:-1, 1:-1, 1:-1]
            differs |= neighbour != levels
    return np.where(differs, levels, NOTHING)


def _camera(stage: Stage, layers: Layers) -> Pose:
    """A place from which the whole grid is in the picture, on the side from which walls hide least of what is shown."""
    grid = layers.grid
    size = grid.cell_m * np.array(grid.shape)
    middle = grid.axes @ (size / 2) + grid.origin_m
    middle[2] = 0.42 * size[2]
    distance = 1.15 * float(np.hypot(*size[:2])) / (2 * math.tan(SPACE_FOV_RAD[0] / 2)) + 0.9
    bearings = np.radians(SIDES)
    away = np.stack((1.1 * np.cos(bearings), 1.1 * np.sin(bearings), np.full(len(SIDES), 0.62)), axis=1) @ grid.axes.T
    places = middle + distance * away / np.linalg.norm(away, axis=1, keepdims=True)
    cells = np.argwhere(layers.levels < NOTHING)
    probes = (cells[:: len(cells) // PROBES + 1] + 0.5) * grid.cell_m @ grid.axes.T + grid.origin_m
    return looking(max(places, key=lambda place: _clear(stage, place, probes)), middle)


def _clear(stage: Stage, place: Array, points: Array) -> int:
    """How many tenths of the points are seen from a place."""
    if not len(points):
        return 0
    ways = points - place
    far_m = np.linalg.norm(ways, axis=1)
    geoms, met_m = stage.cast(place, ways / far_m[:, None])
    return round(10 * float(np.mean((geoms < 0) | (met_m >= far_m))))
