"""Held: level 0 of reach and grasp.

Only the agent's own hands matter. One that was not tracked leaves it unknown, unless the object rests on something or
is farther away than the whole arm.
"""

from __future__ import annotations

import math

import numpy as np

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.judge import Miss, Outcome, Why
from taskgist.perspective.target import Target
from taskgist.world import ArmIndices, hand_known, holding_of

WHOLE_ARM = 1.25
"""A hand holds nothing farther from its shoulder than this times the arm's length (ours; a human's is 1.1)."""


class Hold:
    """Whether the agent holds the object: level 0 of reach and grasp.

    Args:
        here: Whose, and from where.
        target: The object.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        self._here, self._target = here, target

    @property
    def side(self) -> str | None:
        """Side of the hand that holds the object; None if no hand is known to."""
        return self._here.held.get(self._target.name)

    @property
    def unknown(self) -> str | None:
        """Why it is unknown: a hand that was not tracked might hold the object."""
        if self.side is not None:
            return None
        here = self._here
        stage, agent = here.stage.show(here.state), here.agent
        for arm in agent.arms:
            if not hand_known(stage, agent, arm) and self._could_hold(arm) and not self._at_rest():
                return f"{agent.name}'s {arm.profile.side} hand not tracked, and it might hold the object"
        return None

    def outcome(self) -> Outcome | Why:
        """Held, or not."""
        if self.side is None:
            return lambda: Miss(math.inf, "not held")
        return Outcome(evidence=lambda: {"arm": self.side, "held": True})

    def _could_hold(self, arm: ArmIndices) -> bool:
        shoulder = self._here.stage.shoulder(arm).position
        nearest = float(np.linalg.norm(self._target.points - shoulder, axis=1).min(initial=np.inf))
        return nearest <= WHOLE_ARM * arm.profile.length_m

    def _at_rest(self) -> bool:
        contact, target = self._here.settings.contact, self._target
        self._here.consulted.target.add_balls(target.centers, target.radii_m + contact.container_m)
        holding = holding_of(self._here.stage, target.name, contact)
        return holding is not None and bool(holding.support or holding.container)
