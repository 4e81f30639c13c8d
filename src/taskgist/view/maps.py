"""Pictures of ability maps: the workspace from above and in space, side by side, with people and things."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from taskgist.perspective.maps.ability_map import AbilityMap
from taskgist.perspective.maps.grid import Grid
from taskgist.perspective.maps.places import Place
from taskgist.perspective.maps.zone import Zone
from taskgist.view.rendering import looking, pinhole, render
from taskgist.view.saving import save_figure
from taskgist.world import Pose, Stage
from taskgist.world.geometry.rotations import yaw_of

Array = NDArray[np.float64]
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
ARROW_M = 0.42
LABEL = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "black", "alpha": 0.9}


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
    """Draw the grid from above, its first axis to the right; the fuller a column, the stronger its colour."""
    grid, levels = layers.grid, layers.levels
    width, depth = (count * grid.cell_m for count in grid.shape[:2])
    extent = (0.0, width, 0.0, depth)
    axes.imshow(1 - FADED * (1 - _from_above(stage, grid)), extent=extent)
    share = (levels < NOTHING).mean(axis=2)
    least = levels.min(axis=2)
    opacity = np.where(share > 0, FAINTEST + (DENSEST - FAINTEST) * np.minimum(1.0, 2 * share), 0.0)
    opacity[least == max(layers.names)] *= LAST if len(layers.names) > 1 else 1.0
    palette = np.array((*COLOURS, (1.0, 1.0, 1.0)))
    image = np.concatenate((palette[least], opacity[..., None]), axis=2)
    axes.imshow(np.swapaxes(image, 0, 1), origin="lower", extent=extent, interpolation="nearest")
    _draw_people(axes, stage, grid)
    _draw_things(axes, stage, grid)
    spots = np.array([place.position_m for place in layers.places]).reshape(-1, 3)
    axes.plot(*_local(grid, spots)[:, :2].T, ".", color="black", markersize=2.5)
    shown = "the least effort in each column" if len(layers.names) > 1 else "the stronger, the more of a column"
    axes.set_title(f"from above: {shown}", fontsize=10)
    axes.set_xlabel("metres", fontsize=9)
    axes.set_xlim(0, width)
    axes.set_ylim(0, depth)
    axes.tick_params(labelsize=8)


def _from_above(stage: Stage, grid: Grid) -> Array:
    """The room from so high above that all rays are as good as parallel."""
    width, depth = (count * grid.cell_m for count in grid.shape[:2])
    center = grid.axes @ (width / 2, depth / 2, HIGH_M) + grid.origin_m
    ahead, left, up = grid.axes.T
    pixels = (round(width / ABOVE_PIXEL_M), round(depth / ABOVE_PIXEL_M))
    angles = (2 * math.atan(width / 2 / HIGH_M), 2 * math.atan(depth / 2 / HIGH_M))
    return render(stage, Pose(center, np.stack((-up, -ahead, left), axis=1)), pinhole(angles, *pixels)).rgb


def draw_space(axes: Axes, stage: Stage, layers: Layers) -> None:
    """Draw the room from the side with the cells as a translucent surface in it."""
    camera = looking(*_camera(layers.grid))
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


def _camera(grid: Grid) -> tuple[Array, Array]:
    """A place from which the whole grid is in the picture, and the point to look at; metres."""
    size = grid.cell_m * np.array(grid.shape)
    middle = grid.axes @ (size / 2) + grid.origin_m
    middle[2] = 0.42 * size[2]
    distance = 0.95 * float(np.hypot(*size[:2])) / (2 * math.tan(SPACE_FOV_RAD[0] / 2)) + 0.9
    away = grid.axes @ np.array((-0.45, -1.0, 0.62))
    return middle + distance * away / np.linalg.norm(away), middle


def _draw_people(axes: Axes, stage: Stage, grid: Grid) -> None:
    for name in stage.scene.agents:
        base = stage.state.qpos[stage.scene.base_slice(name)]
        x, y = _local(grid, base[:3])[:2]
        heading = yaw_of(base[3:]) - grid.yaw_rad
        tip = (x + ARROW_M * math.cos(heading), y + ARROW_M * math.sin(heading))
        axes.annotate(
            "", tip, (x, y), arrowprops={"arrowstyle": "-|>", "color": "black", "lw": 1.5}, annotation_clip=True
        )
        axes.text(x, y, name, ha="center", va="center", fontsize=9, clip_on=True, bbox=LABEL)


def _draw_things(axes: Axes, stage: Stage, grid: Grid) -> None:
    for name in stage.scene.objects:
        x, y = _local(grid, stage.state.qpos[stage.scene.object_slice(name)][:3])[:2]
        axes.plot(x, y, "x", color="black", markersize=5, markeredgewidth=1.2)
        axes.annotate(name, (x, y), xytext=(4, 3), textcoords="offset points", fontsize=8, annotation_clip=True)


def _local(grid: Grid, point: Array) -> Array:
    return np.asarray((point - grid.origin_m) @ grid.axes)
