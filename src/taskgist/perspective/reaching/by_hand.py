"""What the judges of reach and grasp share: arms that are stretched out, and level 0, which is holding."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.judge import Outcome, Why, untracked_parts
from taskgist.perspective.reaching.hold import Hold
from taskgist.perspective.reaching.sector import Cloud, arms_of
from taskgist.perspective.target import Target
from taskgist.world import ArmIndices

Array = NDArray[np.float64]
PARTS: tuple[tuple[str, ...], ...] = ((), ("torso",), ("torso",), ("torso", "legs"), ("torso", "legs"))
"""Parts that must be tracked to judge each level."""


class ByHand:
    """Judges an ability of the hands towards one object.

    Args:
        here: Whose, and from where.
        target: The object.

    ``arms`` are the indices of those that may be stretched out.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        self._here, self.target = here, target
        self._stage, self._agent = here.stage, here.agent
        self.arms = arms_of(here)
        self._hold = Hold(here, target)

    @cached_property
    def surface(self) -> Cloud:
        """The object's cells."""
        return Cloud.of(self.target.points)

    @cached_property
    def sectors(self) -> Array:
        """Lengths and sectors of these arms for compiled functions, (a, 6)."""
        return np.array([self.arm(index).sector for index in self.arms]).reshape(-1, 6)

    @cached_property
    def shoulders(self) -> NDArray[np.intp]:
        """Which of the agent's frames their shoulders are, (a,)."""
        return self._here.first_shoulder + np.array(self.arms, dtype=np.intp)

    def arm(self, index: int) -> ArmIndices:
        """An arm of the agent by its index."""
        return self._agent.arms[index]

    def unknown(self, level: int) -> str | None:
        """The shoulders are where the torso is; legs matter from their level on; hands for holding only."""
        if level == 0:
            return self._hold.unknown
        return untracked_parts(self._here.state, self._agent.name, PARTS[level])

    def without_effort(self) -> Outcome | Why:
        """Level 0: held."""
        return self._hold.outcome()
