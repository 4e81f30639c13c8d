"""Held: level 0 of reach and grasp.

Only the agent's own hands matter. One that was not tracked leaves it unknown, unless the object rests on something or
is farther away than the whole arm.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.perspective.judge import Miss, Outcome
from taskgist.perspective.standpoint import Standpoint
from taskgist.world import ArmIndices, Holding, hand_known, holding_of, object_points

WHOLE_ARM = 1.25
"""A hand holds nothing farther from its shoulder than this times the arm's length (ours; a human's is 1.1)."""


class Hold:
    """Whether the agent holds the object: level 0 of reach and grasp.

    Args:
        here: Whose, and from where.
        name: The object.
    """

    def __init__(self, here: Standpoint, name: str) -> None:
        self._here = here
        self._stage = here.stage.show(here.state)
        self._holding = holding_of(self._stage, name, here.settings.contact)
        self._points = object_points(self._stage, name, here.settings.reach.cell_m)

    @property
    def side(self) -> str | None:
        """Side of the hand that holds the object; None if no hand is known to."""
        hands = self._holding.hands if self._holding else ()
        return next((side for agent, side in hands if agent == self._here.agent.name), None)

    @property
    def unknown(self) -> str | None:
        """Why it is unknown: a hand that was not tracked might hold the object."""
        if self.side is not None or _at_rest(self._holding):
            return None
        agent = self._here.agent
        for arm in agent.arms:
            if not hand_known(self._stage, agent, arm) and self._could_hold(arm):
                return f"{agent.name}'s {arm.profile.side} hand not tracked, and it might hold the object"
        return None

    def outcome(self) -> Outcome | Miss:
        """Held, or not."""
        if self.side is None:
            return Miss(math.inf, "not held")
        return Outcome(self._here.state, evidence=lambda: {"arm": self.side, "held": True})

    def _could_hold(self, arm: ArmIndices) -> bool:
        shoulder = self._stage.show(self._here.state).shoulder(arm).position
        nearest = float(np.linalg.norm(self._points - shoulder, axis=1).min(initial=np.inf))
        return nearest <= WHOLE_ARM * arm.profile.length_m


def _at_rest(holding: Holding | None) -> bool:
    return holding is not None and bool(holding.support or holding.container)
