"""Frames: states of one scene in order of time, any of which can be asked for."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from taskgist.world.state import State


class Frames(Protocol):
    """A sequence of states; a recording is one."""

    @property
    def times_s(self) -> NDArray[np.float64]:
        """Times of the frames in seconds, strictly increasing, (n,)."""

    def state(self, index: int) -> State:
        """The state in a frame."""
