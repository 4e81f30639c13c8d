"""Stances of an effort level, all at once: the states that base, legs and torso may take, by increasing amount.

States are made one by one, when asked for. Where a stance brings eye, head and shoulders is told without showing it:
by what the torso does, and by where the base gets to.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.floor import Place, moved
from taskgist.perspective.acting.frames import Frames
from taskgist.perspective.acting.torso import Bend
from taskgist.perspective.acting.virtual_actions import MOVE, Amount, Stance
from taskgist.world import Agent, Pose
from taskgist.world.geometry.compiled import compiled
from taskgist.world.geometry.linkage import POSE, carry_pose

Array = NDArray[np.float64]
Numbers = NDArray[np.int32]
DIGITS = 6
"""Amounts that agree to so many digits are equal, wherever the scene stands."""
OVERHEAD_M = 1e-6
"""Nobody turns to what is this near to the axis of the base."""


@dataclass(frozen=True, eq=False)
class Bent:
    """A posture of an agent, with all that its torso may do in it.

    Attributes:
        agent: Whose.
        start: The posture.
        frames: Where eye, head and shoulders are in it.
        bends: What the torso may do.
        rows: Where each of these brings the frames, (b, f, 12).
        torso_rad: How much it is, (b,), rounded for comparing.
    """

    agent: Agent
    start: Stance
    frames: Frames
    bends: Sequence[Bend]
    rows: Array
    torso_rad: Array

    @classmethod
    def of(cls, agent: Agent, start: Stance, frames: Frames, bends: Sequence[Bend]) -> Bent:
        """A posture and bends of the torso."""
        amounts = np.round([bend.by_rad for bend in bends], DIGITS)
        return cls(agent, start, frames, bends, frames.bent([bend.changes for bend in bends]), amounts)


@dataclass(frozen=True, eq=False)
class Spots:
    """Where a base may go, in order of the way.

    Attributes:
        offsets_m: How far it moves, metres along the world's x and y, (p, 2).
        ways_m: Lengths of the ways, (p,).
        rounded_m: The same, rounded for comparing.
    """

    offsets_m: Array
    ways_m: Array
    rounded_m: Array

    @classmethod
    def of(cls, places: Sequence[Place]) -> Spots:
        """Some places."""
        offsets = np.array([place.offset_m for place in places]).reshape(-1, 2)
        ways = np.array([place.way_m for place in places])
        return cls(offsets, ways, np.round(ways, DIGITS))


HERE = Spots(np.zeros((1, 2)), np.zeros(1), np.zeros(1))
AHEAD = np.zeros(1)


class Table(NamedTuple):
    """Stances as compiled functions take them.

    Attributes:
        rows: Where each bend brings the frames, (b, f, 12).
        joints: How many joints of the head are among them.
        base: Where the base is before it moves, metres, (3,).
        offsets_m: How far it moves to each spot, (p, 2).
        turns: Sine and cosine of the turn there, (p, 2).
        spot: Which spot each stance has, (n,).
        bend: Which bend, (n,).
    """

    rows: Array
    joints: int
    base: Array
    offsets_m: Array
    turns: Array
    spot: Numbers
    bend: Numbers


class Stances:
    """Stances by increasing amount: every spot with every bend.

    Args:
        bent: The posture, and what the torso may do.
        spots: Where the base may go; it stays if left out.
        turned_rad: How far the whole agent turns on the spot, (p,).

    Attributes:
        bent: As given.
        table: For compiled functions.
        ends: For each stance, which is the first one after it of another amount, (n,).
    """

    def __init__(self, bent: Bent, spots: Spots = HERE, turned_rad: Array = AHEAD) -> None:
        self.bent, self._spots, self._turned_rad = bent, spots, turned_rad
        spot, bend, self.ends, sines = _ordered(spots.rounded_m, turned_rad, bent.torso_rad)
        self.table = Table(bent.rows, len(bent.frames.head), bent.frames.base, spots.offsets_m, sines, spot, bend)

    def __len__(self) -> int:
        return len(self.ends)

    def __getitem__(self, index: int) -> Stance:
        """The stance of that index."""
        spot, bend = self.table.spot[index], self.bent.bends[self.table.bend[index]]
        state, used = self.bent.start.state.replace(bend.changes), bend.actions
        way_m, turned_rad = float(self._spots.ways_m[spot]), float(self._turned_rad[spot])
        if self._spots is not HERE:
            x, y = self._spots.offsets_m[spot].tolist()
            state, used = moved(state, self.bent.agent, (x, y), turned_rad), (MOVE, *used)
        return Stance(state, (*self.bent.start.actions, *used), Amount(way_m, abs(turned_rad), bend.by_rad))

    @property
    def offsets_m(self) -> Array:
        """How far the base moves in each, metres along the world's x and y, (n, 2)."""
        return self.table.offsets_m[self.table.spot]

    def frames(self, index: int) -> Array:
        """Where a stance brings the frames, (f, 12)."""
        return _carried(self.table, index)

    def shoulder(self, index: int, arm: int) -> Pose:
        """Where a stance brings a shoulder, in the frame of what carries it."""
        row = self.frames(index)[self.bent.frames.first_shoulder + arm]
        return Pose(row[:3], row[3:].reshape(3, 3))


@compiled
def turns_towards(target: Array, base: Array, facing_rad: float, offsets_m: Array) -> Array:
    """How far an agent turns at each place so that its chest faces a target, radians from −π to π.

    Args:
        target: Metres, (3,).
        base: Where the base is now, metres, at least (2,).
        facing_rad: Where the chest faces now, about the vertical.
        offsets_m: How far the places are from there, (p, 2).
    """
    turns = np.zeros(len(offsets_m))
    for p in range(len(turns)):
        x, y = target[0] - base[0] - offsets_m[p, 0], target[1] - base[1] - offsets_m[p, 1]
        if math.hypot(x, y) > OVERHEAD_M:
            turn = math.atan2(y, x) - facing_rad
            turns[p] = turn - 2 * math.pi * np.rint(turn / (2 * math.pi))
    return turns


@compiled
def carry(table: Table, index: int, frame: int, pose: Array) -> None:
    """Write where a stance brings one frame, (12,)."""
    spot, turns = table.spot[index], table.turns
    offset, row = table.offsets_m[spot], table.rows[table.bend[index], frame]
    carry_pose(row, table.base, offset, turns[spot, 0], turns[spot, 1], pose)


@compiled
def _carried(table: Table, index: int) -> Array:
    found = np.empty((table.rows.shape[1], POSE))
    for frame in range(len(found)):
        carry(table, index, frame, found[frame])
    return found


@compiled
def _ordered(ways: Array, turned_rad: Array, torso: Array) -> tuple[Numbers, Numbers, Numbers, Array]:
    """Every spot with every bend, by way, turn and bend of the torso.

    Equal ones keep the order of spots, then of bends.

    Returns:
        Spot and bend of each, where its equals end, all (n,); and sine and cosine of the turn at each spot, (p, 2).
    """
    spots, bends = len(ways), len(torso)
    spot, bend = np.empty(spots * bends, dtype=np.int32), np.empty(spots * bends, dtype=np.int32)
    ends, sines = np.empty(spots * bends, dtype=np.int32), np.empty((spots, 2))
    turns = np.rint(np.abs(turned_rad) * 10.0**DIGITS)
    by_turn, by_torso = np.argsort(turns, kind="mergesort"), np.argsort(torso, kind="mergesort")
    by_amount = by_turn[np.argsort(ways[by_turn], kind="mergesort")]
    count, first = 0, 0
    while first < spots:
        one, last = by_amount[first], first + 1
        while last < spots and ways[by_amount[last]] == ways[one] and turns[by_amount[last]] == turns[one]:
            last += 1
        low = 0
        while low < bends:
            high = low + 1
            while high < bends and torso[by_torso[high]] == torso[by_torso[low]]:
                high += 1
            end = count + (last - first) * (high - low)
            for p in range(first, last):
                for b in range(low, high):
                    spot[count], bend[count], ends[count] = by_amount[p], by_torso[b], end
                    count += 1
            low = high
        first = last
    for p in range(spots):
        sines[p, 0], sines[p, 1] = math.sin(turned_rad[p]), math.cos(turned_rad[p])
    return spot, bend, ends, sines
