"""Walking: the stances of an agent that gets up, goes somewhere and turns there to what it wants (Move_To)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.floor import Floor, Place
from taskgist.perspective.acting.stances import Bent, Spots, Stances, turns_towards

Array = NDArray[np.float64]


class Walk:
    """An agent ready to walk.

    Args:
        upright: The agent standing, with what its torso may do.
        facing_rad: Where its chest faces then, about the vertical.
        floor: Where it can get to.
    """

    def __init__(self, upright: Bent, facing_rad: float, floor: Floor) -> None:
        self._upright, self._facing_rad, self.floor = upright, facing_rad, floor
        self._base = np.array(upright.start.state.qpos[upright.agent.base])
        self._spots: list[Spots] = []
        self._last: tuple[bytes, list[Stances]] = b"", []

    def stances(self, target: Array) -> Iterator[Stances]:
        """Batches of growing distance: most objects are near to where somebody can stand.

        Args:
            target: What the agent turns to, metres, (3,).
        """
        if self._last[0] != target.tobytes():
            self._last = target.tobytes(), []
        known = self._last[1]  # the three abilities ask for the same ones, one after the other
        for index, spots in enumerate(self._floor_spots()):
            if index == len(known):
                turned_rad = turns_towards(target, self._base, self._facing_rad, spots.offsets_m)
                known.append(Stances(self._upright, spots, turned_rad))
            yield known[index]

    def _floor_spots(self) -> Iterator[Spots]:
        """The floor in batches, for all targets the same."""
        for index, places in enumerate(self.floor.batches()):
            if index == len(self._spots):
                self._spots.append(Spots.of(places))
            yield self._spots[index]

    @property
    def places(self) -> tuple[Place, ...]:
        """All places that the agent can get to."""
        return tuple(place for batch in self.floor.batches() for place in batch)
