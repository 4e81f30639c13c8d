"""Flights: things that have been let go, and move by physics."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.world import FreeMotion

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Flight:
    """A thing that moves on its own.

    Attributes:
        thing: Its name.
        from_s: When it was let go, or pushed.
        motion: How it has moved since then.
    """

    thing: str
    from_s: float
    motion: FreeMotion

    def poses(self, times_s: Array) -> Array:
        """Where it is at some times from then on: positions in metres and wxyz, (n, 7)."""
        return self.motion.at(times_s - self.from_s)
