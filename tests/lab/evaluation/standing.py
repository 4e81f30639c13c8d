"""A recording in which nothing moves: what moves after all is noise."""

from __future__ import annotations

from functools import cache

import numpy as np

from taskgist.recording import Label, Provenance, Recording
from tests.importing.recordings import room

FRAMES, RATE_HZ = 300, 30


@cache
def still(task: str = "hide", number: int = 0) -> Recording:
    """Two people stand before a cup on a table, for ten seconds."""
    world = room()
    return Recording(
        scene=world,
        times_s=np.arange(FRAMES) / RATE_HZ,
        qpos=np.tile(world.initial.qpos, (FRAMES, 1)),
        tracked={"box": np.arange(FRAMES) % 7 > 0},
        label=Label(task, "P1", "P2", "cup", 1.0 + 0.1 * number, 9.0),
        provenance=Provenance(simulated=True, notes=("means: standing still",)),
        name="still",
    )
