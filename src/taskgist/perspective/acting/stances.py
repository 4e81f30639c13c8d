"""Stances of an effort level, all at once: the states that base, legs and torso may take, by increasing amount.

States are made one by one, when asked for; where the stances bring eye, head and shoulders is known for all of them
from the start, so that what none of them can see or reach is told without showing a single state.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.floor import Place, moved
from taskgist.perspective.acting.frames import Frames, Placed
from taskgist.perspective.acting.torso import Bend
from taskgist.perspective.acting.virtual_actions import MOVE, Amount, Stance
from taskgist.world import Agent

Array = NDArray[np.float64]
DIGITS = 6
"""Amounts that agree to so many digits are equal, wherever the scene stands."""
FIRST_PART, GROWTH = 8, 4
"""How many stances are looked at together at first, and how many times as many then."""


@dataclass(frozen=True, eq=False)
class Stances:
    """Stances by increasing amount.

    Attributes:
        agent: Whose.
        start: The posture from which they start.
        frames: Where eye, head and shoulders are in that posture.
        bends: What the torso may do.
        bend: Which of these each stance does, (n,).
        offsets_m: How far the base moves, metres in the world, (n, 2).
        turned_rad: How far the whole agent turns on the spot, (n,).
        amounts: Metres moved, radians turned on the spot, radians of the torso, (n, 3).
        walks: Whether the base moves at all.
    """

    agent: Agent
    start: Stance
    frames: Frames
    bends: Sequence[Bend]
    bend: NDArray[np.intp]
    offsets_m: Array
    turned_rad: Array
    amounts: Array
    walks: bool

    def __len__(self) -> int:
        return len(self.bend)

    def __getitem__(self, index: int) -> Stance:
        """The stance of that index."""
        bend = self.bends[self.bend[index]]
        state, used = self.start.state.replace(bend.changes), bend.actions
        if self.walks:
            offset = (float(self.offsets_m[index, 0]), float(self.offsets_m[index, 1]))
            state, used = moved(state, self.agent, offset, float(self.turned_rad[index])), (MOVE, *used)
        return Stance(state, (*self.start.actions, *used), Amount(*self.amounts[index].tolist()))

    @cached_property
    def parts(self) -> tuple[Stances, ...]:
        """The stances in parts of growing size, equal amounts together: what takes little is mostly found early."""
        keys = np.round(self.amounts, DIGITS)
        changes = np.array([*(np.flatnonzero((keys[1:] != keys[:-1]).any(axis=1)) + 1), len(self)])
        parts, start, size = [], 0, FIRST_PART
        while start < len(self):
            end = int(changes[min(int(np.searchsorted(changes, start + size)), len(changes) - 1)])
            parts.append(self._part(slice(start, end)))
            start, size = end, size * GROWTH
        return tuple(parts)

    def _part(self, which: slice) -> Stances:
        rows = (self.bend[which], self.offsets_m[which], self.turned_rad[which], self.amounts[which])
        return Stances(self.agent, self.start, self.frames, self.bends, *rows, self.walks)

    def groups(self, chosen: NDArray[np.bool_]) -> Iterator[list[int]]:
        """Indices of the chosen stances, those of equal amount together, the least amount first."""
        indices = np.flatnonzero(chosen)
        keys = np.round(self.amounts[indices], DIGITS).tolist()
        for _, same in itertools.groupby(range(len(indices)), key=keys.__getitem__):
            yield [int(indices[each]) for each in same]

    @cached_property
    def placed(self) -> Placed:
        """Where eye, head and shoulders get to."""
        bent = self.frames.bent(self.frames.by([bend.changes for bend in self.bends]))
        return self.frames.displaced(bent, self.bend, self.offsets_m, self.turned_rad)


def bent(agent: Agent, start: Stance, frames: Frames, bends: Sequence[Bend]) -> Stances:
    """A posture with turns and leans of the torso."""
    places = (np.zeros((1, 2)), np.zeros(1), np.zeros(1))
    return _every(agent, start, frames, bends, places, walks=False)


def displaced(
    agent: Agent,
    start: Stance,
    frames: Frames,
    bends: Sequence[Bend],
    *,
    places: Sequence[Place],
    turned_rad: Array,
) -> Stances:
    """A standing agent at places, turned there on the spot, with what its torso may do."""
    offsets = np.array([place.offset_m for place in places]).reshape(-1, 2)
    ways = np.array([place.way_m for place in places])
    return _every(agent, start, frames, bends, (offsets, ways, turned_rad), walks=True)


def _every(
    agent: Agent,
    start: Stance,
    frames: Frames,
    bends: Sequence[Bend],
    places: tuple[Array, Array, Array],
    *,
    walks: bool,
) -> Stances:
    """Every place (offsets, ways and turns) with every bend."""
    offsets_m, ways_m, turned_rad = places
    place, bend = (index.ravel() for index in np.indices((len(ways_m), len(bends))))
    torso_rad = np.array([each.by_rad for each in bends])
    amounts = np.stack((ways_m[place], np.abs(turned_rad[place]), torso_rad[bend]), axis=1)
    order = np.lexsort(np.round(amounts, DIGITS).T[::-1])
    place = place[order]
    return Stances(agent, start, frames, bends, bend[order], offsets_m[place], turned_rad[place], amounts[order], walks)


def turns_towards(target: Array, base: Array, facing_rad: float, places: Sequence[Place]) -> Array:
    """How far an agent turns at each place so that its chest faces a target, radians from −π to π.

    Args:
        target: Metres, (3,).
        base: Where the base is now, metres, at least (2,).
        facing_rad: Where the chest faces now, about the vertical.
        places: The places.
    """
    to = target[:2] - base[:2] - np.array([place.offset_m for place in places]).reshape(-1, 2)
    turns = np.where(np.hypot(*to.T) > 1e-6, np.arctan2(to[:, 1], to[:, 0]) - facing_rad, 0.0)
    return np.asarray(turns - 2 * math.pi * np.round(turns / (2 * math.pi)))
