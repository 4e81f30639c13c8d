"""Ability maps, beside asking the search about every cell."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np

from benchmarks.figure import Figure
from benchmarks.rooms import furnished
from benchmarks.timing import all_cores, once, seconds, work
from taskgist.maps.ability_map import ability_map
from taskgist.maps.grid import Grid, Zone
from taskgist.maps.places import places_for
from taskgist.perspective import Viewpoint, effort_from
from taskgist.settings import DEFAULT
from taskgist.world import Stage
from taskgist_lab.ordinary.furnishing import furnished as ordinary
from tests.maps.places_twin import PlacesTwin

AGENTS, OBJECTS, ASKED = 3, 12, 40
PART_M = 0.5
ABILITIES: tuple[Literal["see", "reach"], ...] = ("see", "reach")


def figures() -> Iterator[Figure]:
    """Sight and reach of three agents, all levels, each in its own workspace."""
    stage = Stage(furnished(AGENTS, OBJECTS))

    cells = math.prod(ability_map(stage, stage.scene.agents[0], "reach").grid.shape)
    on_one_core = seconds(lambda: all_maps(stage), repeats=3)
    with all_cores() as cores:
        taken = seconds(lambda: all_maps(stage), repeats=3)
    yield Figure(
        "maps",
        f"{AGENTS} agents, sight and reach, all levels, {cells:,} cells each",
        taken,
        {
            "the same on one core": on_one_core,
            f"asking the search of every cell (from {ASKED} of them)": cell_by_cell(stage, cells),
        },
        goal="1 s",
        met=taken <= 1.0,
        counts=work(stage, lambda: all_maps(stage)),
        note=f"on {cores} cores",
    )
    yield from places()


def places() -> Iterator[Figure]:
    """Places for a cup in the workspaces of all people of an ordinary room, the floor's among them."""
    stage, size_m = Stage(ordinary(7, 3).scene()), (0.08, 0.08, 0.10)
    everywhere = _all_of(Grid.around(stage, *stage.scene.agents))
    part = _all_of(Grid.around(stage, stage.scene.agents[0], settings=replace(DEFAULT.maps, half_width_m=PART_M)))
    found, taken = len(places_for(stage, size_m, everywhere)), seconds(lambda: places_for(stage, size_m, everywhere))
    columns = math.prod(everywhere.grid.shape[:2]) / math.prod(part.grid.shape[:2])
    one_by_one = columns * once(lambda: PlacesTwin(stage, size_m, part).places())
    among = f"{math.prod(everywhere.grid.shape[:2]):,} columns among {stage.scene.model.ngeom} shapes"
    yield Figure(
        "maps",
        f"{found:,} places for a cup, {among}",
        taken,
        {"one column, box and ray at a time (from a part of them)": one_by_one},
        goal="0.3 s",
        met=taken <= 0.3,
        counts=work(stage, lambda: places_for(stage, size_m, everywhere)),
    )


def _all_of(grid: Grid) -> Zone:
    return Zone(grid, np.ones(grid.shape, dtype=bool))


def all_maps(stage: Stage) -> None:
    """Where everybody sees and reaches, at all levels."""
    for agent in stage.scene.agents:
        here = Viewpoint(stage, agent, DEFAULT)
        for ability in ABILITIES:
            ability_map(here, ability=ability)


def cell_by_cell(stage: Stage, cells: int) -> float:
    """The same by way of the search, with an object carried from cell to cell; from a few cells at random."""
    name, rng = stage.scene.objects[0], np.random.default_rng(0)
    before = stage.state
    total = 0.0
    for agent in stage.scene.agents:
        base = before.qpos[stage.scene.agent(agent).base][:3]
        for _ in range(ASKED):
            place = (*(base[:2] + rng.uniform(-1.5, 1.5, 2)), rng.uniform(0, 2))
            stage.show(before.replace(at=stage.scene.object_slice(name), to=(*place, 1, 0, 0, 0)))
            here = Viewpoint(stage, agent, DEFAULT)
            total += once(lambda here=here: [effort_from(here, name, ability) for ability in ABILITIES])  # type: ignore[misc]
    stage.show(before)
    return total * cells / ASKED
