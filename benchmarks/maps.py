"""Ability maps, beside asking the search about every cell."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal

import numpy as np

from benchmarks.figure import Figure
from benchmarks.rooms import furnished
from benchmarks.timing import all_cores, once, seconds, work
from taskgist.maps.ability_map import ability_map
from taskgist.perspective import Viewpoint, effort_from
from taskgist.settings import DEFAULT
from taskgist.world import Stage

AGENTS, OBJECTS, ASKED = 3, 12, 40
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
