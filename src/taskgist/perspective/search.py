"""The search within one effort level (5.1.5).

Stances come from the least amount to the greatest. The first amount at which the ability holds without a collision is
the level's answer; of several states with equal amounts the best one is taken (most pixels, nearest shoulder).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import Amount, Stance
from taskgist.perspective.judge import Among, Judge, Miss, Outcome
from taskgist.world import State

HEAD = "head"
BLOCKED = -10.0
"""Shortfall of what would do but for a collision: nothing is nearer, and nothing more worth telling."""


@dataclass(frozen=True, eq=False)
class Found:
    """Where an ability holds, and how much it takes to get there."""

    stance: Stance
    outcome: Outcome

    @property
    def state(self) -> State:
        """The attained state."""
        return self.stance.state.replace(self.outcome.angles_rad)

    @property
    def actions(self) -> tuple[str, ...]:
        """Virtual actions in order."""
        return (*self.stance.actions, *self.outcome.actions)

    @property
    def amount(self) -> Amount:
        """How much of them."""
        return replace(self.stance.amount, head_rad=self.outcome.head_rad)

    @property
    def order(self) -> tuple[object, ...]:
        """Least amount first, then the best."""
        return (self.amount.key, self.outcome.merit)


def least(here: Standpoint, judge: Judge, level: int, target: NDArray[np.float64]) -> Found | Miss:
    """The least amount of an effort level that gives an ability, or why none does.

    Args:
        here: Whose ability, and from where.
        judge: The ability towards an object.
        level: Effort level, 0 to 4.
        target: The object's middle, metres, (3,).
    """
    if level == 0:
        result = judge.without_effort()
        return Found(here.here, result) if isinstance(result, Outcome) else result
    misses: list[Miss] = []
    looked_at: list[Among] = []
    for stances in (part for batch in here.stances(level, target) for part in judge.parts(batch)):
        among = judge.among(stances)
        looked_at.append(among)
        for group in stances.groups(among.hopeful):
            found = [each for index in group for each in _free(here, among, index, stances[index], misses)]
            if found:
                return min(found, key=lambda each: each.order)
    misses += [among.miss() for among in looked_at if not among.hopeful.all()]
    return min(misses) if misses else here.no_stance(level)


def _free(here: Standpoint, among: Among, index: int, stance: Stance, misses: list[Miss]) -> Iterator[Found]:
    """The best outcome from a stance that respects the constraints, if any; notes why others do not count."""
    for result in among.outcomes(index):
        if isinstance(result, Miss):
            misses.append(result)
            continue
        found = Found(stance, result)
        blocking = here.blocked(found.state)
        if blocking is None:
            yield found
            return
        misses.append(Miss(BLOCKED, f"{' + '.join(found.actions)} is blocked: {blocking}", blocking.as_miss))
        if blocking.part != HEAD:
            return  # outcomes of one stance differ in the head only
