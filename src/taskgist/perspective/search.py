"""The search within one effort level (5.1.5).

Stances come from the least amount to the greatest. The first amount at which the ability holds without a collision is
the level's answer; of several states with equal amounts the best one is taken (most pixels, nearest shoulder).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.constraints import Blocking
from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import Amount, Stance
from taskgist.perspective.judge import Among, Judge, Miss, Outcome, Why
from taskgist.world import State

HEAD = "head"
BLOCKED = -10.0
"""Shortfall of what would do but for a collision: nothing is nearer, and nothing more worth telling."""


@dataclass(frozen=True, eq=False)
class Found:
    """Where an ability holds, and how much it takes to get there."""

    stance: Stance
    outcome: Outcome

    @cached_property
    def state(self) -> State:
        """The attained state."""
        angles = self.outcome.angles_rad
        return self.stance.state.replace(angles) if angles else self.stance.state

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


def least(here: Standpoint, judge: Judge, level: int, target: NDArray[np.float64]) -> Found | Why:
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
    whys: list[Why] = []
    looked_at: list[Among] = []
    for stances in here.stances(level, target):
        among = judge.among(stances)
        looked_at.append(among)
        for group in _groups(stances, among):
            found = [each for index in group for each in _free(here, among, index, stances[index], whys)]
            if found:
                return min(found, key=lambda each: each.order)
    return partial(_nearest, here, level, whys, looked_at)


def _groups(stances: Stances, among: Among) -> Iterator[list[int]]:
    """Stances from which the ability may hold, those of equal amount together, the least amount first."""
    count = len(stances)
    first = among.next(0, count)
    while first < count:
        end = int(stances.ends[first])
        group, index = [first], among.next(first + 1, end)
        while index < end:
            group.append(index)
            index = among.next(index + 1, end)
        yield group
        first = among.next(end, count)


def _free(here: Standpoint, among: Among, index: int, stance: Stance, whys: list[Why]) -> Iterator[Found]:
    """The best outcome from a stance that respects the constraints, if any; notes why others do not count."""
    for result in among.outcomes(index):
        if not isinstance(result, Outcome):
            whys.append(result)
            continue
        found = Found(stance, result)
        blocking = here.blocked(found.state)
        if blocking is None:
            yield found
            return
        whys.append(partial(_blocked, found.actions, blocking))
        if blocking.part != HEAD:
            return  # outcomes of one stance differ in the head only


def _blocked(actions: tuple[str, ...], blocking: Blocking) -> Miss:
    return Miss(BLOCKED, f"{' + '.join(actions)} is blocked: {blocking}", blocking.as_miss)


def _nearest(here: Standpoint, level: int, whys: list[Why], looked_at: list[Among]) -> Miss:
    """The nearest of all misses of a level."""
    misses = [why() for why in whys] + [miss for among in looked_at if (miss := among.miss()) is not None]
    return min(misses) if misses else here.no_stance(level)
