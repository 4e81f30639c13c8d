"""Small recordings of two people and a cup on a table, one flaw at a time."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskgist.recording import Label, Provenance, Recording
from taskgist.world import Scene
from tests.scenes import TABLE, agent, box, cylinder, scene

FRAMES = 31
LABEL = Label("show", "P1", "P2", "cup", 0.2, 0.8)


def room(*bodies: str, extra: str = "") -> Scene:
    people = agent("P1", -0.8, 0.0) + agent("P2", 0.8, 0.0, 180)
    return scene(TABLE, cylinder("cup", 0.1, 0.0, 0.771), *bodies, agents=people, scene_extra=extra)


def still(world: Scene, frames: int = FRAMES) -> NDArray[np.float64]:
    """Nothing moves, (frames, nq)."""
    return np.tile(world.initial.qpos, (frames, 1))


def small(world: Scene | None = None, **fields: Any) -> Recording:
    """A second in which nothing happens, but for what the fields say."""
    world = world or room()
    given = {
        "times_s": np.arange(FRAMES) / 30,
        "qpos": still(world),
        "label": LABEL,
        "name": "small",
        "provenance": Provenance(simulated=True),  # nobody else stands as still
        **fields,
    }
    return Recording(scene=world, **given)


def sunk_box() -> str:
    """A box that reaches 6 cm into the table."""
    return box("box", 0.0, 0.4, 0.74, (0.05, 0.05, 0.08))
