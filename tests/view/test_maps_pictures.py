"""Pictures of ability maps: cells where they are, in their colours."""

from __future__ import annotations

import math
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from taskgist.maps.ability_map import ability_map
from taskgist.maps.grid import Grid, Zone
from taskgist.maps.places import Place
from taskgist.perspective import EFFORT_NAMES
from taskgist.settings import DEFAULT, Maps
from taskgist.view.maps import COLOURS, NOTHING, Layers, draw_above, map_picture
from taskgist.world import Stage
from tests.scenes import TABLE, agent, cylinder, scene

ROOM = scene(TABLE, cylinder("cup", 0.1, 0.0, 0.771), agents=agent("P1", -0.8, 0.0) + agent("P2", 0.8, 0.0, 180))
GRID = Grid((-1.6, -1.0, 0.0), 0.0, 0.1, (32, 20, 20))


def colours_above(layers: Layers) -> np.ndarray:
    """Colours and opacities of the cells of the view from above, (columns of the grid, 4)."""
    axes = Figure().subplots()
    draw_above(axes, Stage(ROOM), layers)
    image = axes.get_images()[1].get_array()
    assert image is not None
    return np.swapaxes(np.asarray(image), 0, 1)


def test_columns_have_the_colour_of_their_least_level() -> None:
    found = ability_map(Stage(ROOM), "P1", "reach", grid=GRID)
    image = colours_above(Layers.of_map(found, EFFORT_NAMES["reach"], max_level=2))
    least = np.where(found.levels <= 2, found.levels, NOTHING).min(axis=2)
    for level in (1, 2):
        assert (least == level).any()
        assert image[least == level][:, :3] == pytest.approx(
            np.broadcast_to(COLOURS[level], ((least == level).sum(), 3))
        )
    assert (image[least == NOTHING][:, 3] == 0).all()
    assert (image[least != NOTHING][:, 3] > 0).all()


def test_axes_from_above_are_those_of_the_room() -> None:
    """Whatever way the grid is turned, a position can be read from the picture."""
    grid = Grid((0.5, -1.0, 0.0), math.radians(30), 0.1, (20, 10, 5))
    axes = Figure().subplots()
    draw_above(axes, Stage(ROOM), Layers.of_zone(Zone(grid, np.ones(grid.shape, dtype=bool)), "somewhere"))
    placed = axes.get_images()[1].get_transform() - axes.transData
    corners = np.array([(0, 0), (2, 0), (2, 1), (0, 1)])
    expected = [(0.5, -1.0), (0.5 + math.sqrt(3), 0.0), (math.sqrt(3), math.sqrt(3) / 2), (0.0, math.sqrt(3) / 2 - 1)]
    assert placed.transform(corners) == pytest.approx(np.array(expected))
    assert axes.get_xlim() == pytest.approx((0.0, 0.5 + math.sqrt(3)))
    assert axes.get_ylim() == pytest.approx((-1.0, math.sqrt(3) / 2))


def test_fuller_columns_are_stronger() -> None:
    cells = np.zeros(GRID.shape, dtype=bool)
    cells[5, 5, :3], cells[9, 9, :10] = True, True
    image = colours_above(Layers.of_zone(Zone(GRID, cells), "somewhere"))
    assert 0 < image[5, 5, 3] < image[9, 9, 3]
    assert np.count_nonzero(image[..., 3]) == 2


def test_a_zone_shows_in_space_where_it_is(tmp_path: Path) -> None:
    cells = np.zeros(GRID.shape, dtype=bool)
    cells[12:18, 8:12, 15:19] = True
    elsewhere = np.zeros_like(cells)
    elsewhere[0, 0, 0] = True
    pictures = [
        map_picture(Stage(ROOM), Layers.of_zone(Zone(GRID, each), "zone"), tmp_path / f"{n}.png", title="a zone")
        for n, each in enumerate((cells, elsewhere))
    ]
    shown, empty = (matplotlib.image.imread(path)[..., :3] for path in pictures)
    changed = (np.abs(shown - empty).sum(axis=2) > 0.1)[:-60, shown.shape[1] // 2 :]
    assert 0.005 < changed.mean() < 0.3
    assert shown.shape[:2] == (640, 1300)


def test_places_and_maps_of_all_levels_are_drawn(tmp_path: Path) -> None:
    stage = Stage(ROOM)
    shown = stage.state
    for ability in ("see", "reach"):
        settings = DEFAULT.__class__(maps=Maps(cell_m=0.25))
        found = ability_map(stage, "P2", ability, settings=settings)
        layers = Layers.of_map(found, EFFORT_NAMES[ability], places=(Place((0.0, 0.1, 0.72), "table"),))
        path = map_picture(stage, layers, tmp_path / f"{ability}.png", title=ability)
        assert path.read_bytes().startswith(b"\x89PNG")
    assert stage.state is shown
