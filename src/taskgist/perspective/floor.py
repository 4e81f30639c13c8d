"""The floor that an agent can get to (Move_To, 5.1.4).

It is a grid around the agent, flooded from where it stands. The grid is anchored at the agent, its axes lie along the
agent's heading. A cell can be stood on if head, torso and base collide with nothing there; a step to one of the eight
neighbours is possible if the same is true half-way, so that nobody walks through a thin wall. Cells come in the order
of the way's length, and only as many as are asked for.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.target import touched
from taskgist.settings import Efforts
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import turned_about_z, yaw_of
from taskgist.world.state import State

Cell = tuple[int, int]
HalfCell = tuple[float, float]
"""A cell, or a place between two."""
STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))

TILE = 8
"""Side in cells of the squares of which it is found out at once where they are clear: two metres."""
HALVES = np.arange(-TILE, TILE) / 2

BATCHES_M = (0.6, 2.0, 4.0, math.inf)
"""Lengths of the way up to which places are looked at together."""


@dataclass(frozen=True)
class Place:
    """A cell that can be got to: offset from the start along world axes, and length of the way, all in metres."""

    offset_m: tuple[float, float]
    way_m: float
    cell: Cell = (0, 0)


class Standing(Protocol):
    """Tells where an agent could stand, by offsets in metres along the world's axes (``constraints.Footprint``)."""

    def clear(self, offsets_m: Array) -> list[bool]:
        """Whether it surely could, quickly, (k, 2)."""
        ...

    def free(self, offset_m: tuple[float, float]) -> bool:
        """Whether it could."""
        ...


class Floor:
    """Places that an agent can get to, nearest first.

    Args:
        start: The standing agent's state.
        agent: The agent.
        settings: Step and radius.
        standing: Whether the agent collides with nothing when moved by an offset.
        note: Told how long the ways are over which places are asked for.

    Attributes:
        note: As given.
        free_at: What is known of that by now, by cell; half cells lie between.
        goes_on: Whether the floor goes on where the radius ends, as far as is known by now.
    """

    def __init__(
        self,
        start: State,
        agent: Agent,
        settings: Efforts,
        standing: Standing,
        note: Callable[[float], None] = lambda _: None,
    ) -> None:
        self._settings, self._standing, self.note = settings, standing, note
        yaw, step_m = yaw_of(start.qpos[agent.base][3:]), settings.move_step_m
        self._forward = (step_m * math.cos(yaw), step_m * math.sin(yaw))
        self.free_at: dict[HalfCell, bool] = {}
        self._clear_at: dict[HalfCell, bool] = {}
        self._begin()

    def _begin(self) -> None:
        self.goes_on = False
        self._batches: list[list[Place]] = []
        self._flood = self._flooded()
        self._next: Place | None = next(self._flood, None)

    def batches(self) -> Iterator[list[Place]]:
        """Places in order of the way, in batches up to a growing length; what was flooded once is kept."""
        for index, limit_m in enumerate(BATCHES_M):
            self.note(limit_m)
            if index == len(self._batches):
                self._batches.append(self._up_to(limit_m))
            if self._batches[index]:
                yield self._batches[index]

    def first_beyond(self, away_m: float) -> Place | None:
        """The first place that is farther than this from the start; None if no way leads to one."""
        places = (place for batch in self.batches() for place in batch)
        return next((place for place in places if math.hypot(*place.offset_m) >= away_m), None)

    def _up_to(self, limit_m: float) -> list[Place]:
        batch: list[Place] = []
        while self._next is not None and self._next.way_m <= limit_m:
            batch.append(self._next)
            self._next = next(self._flood, None)
        return batch

    def _flooded(self) -> Iterator[Place]:
        """Dijkstra's algorithm over the grid."""
        ways: dict[Cell, float] = {(0, 0): 0.0}
        queue: list[tuple[float, Cell]] = [(0.0, (0, 0))]
        done: set[Cell] = set()
        steps = [(*step, math.hypot(*step) * self._settings.move_step_m) for step in STEPS]
        while queue:
            way, cell = heapq.heappop(queue)
            if cell in done:
                continue
            done.add(cell)
            yield Place(self.offset_m(*cell), way, cell)
            for ahead, aside, step_m in steps:
                following, longer = (cell[0] + ahead, cell[1] + aside), way + step_m
                if longer < ways.get(following, math.inf) and following not in done and self._leads(cell, following):
                    ways[following] = longer
                    heapq.heappush(queue, (longer, following))

    def _leads(self, cell: Cell, following: Cell) -> bool:
        half_way = ((cell[0] + following[0]) / 2, (cell[1] + following[1]) / 2)
        if not self._within(following):
            self.goes_on = self.goes_on or self._stands(half_way)
            return False
        return self._stands(following) and self._stands(half_way)

    def _within(self, cell: Cell) -> bool:
        return math.hypot(*cell) * self._settings.move_step_m <= self._settings.move_radius_m + 1e-9

    def _stands(self, at: HalfCell) -> bool:
        if at not in self.free_at:
            if at not in self._clear_at:
                self._look_around(at)
            self.free_at[at] = self._clear_at[at] or self._standing.free(self.offset_m(*at))
        return self.free_at[at]

    def _look_around(self, at: HalfCell) -> None:
        """Find out where it is surely free in a square of cells, at once: one after the other takes longer."""
        ahead, aside = (math.floor(along / TILE + 0.5) * TILE + HALVES for along in at)
        cells = np.stack(np.meshgrid(ahead, aside, indexing="ij"), axis=-1).reshape(-1, 2)
        clear = self._standing.clear(self._offsets_m(cells))
        self._clear_at.update(((x, y), known) for (x, y), known in zip(cells.tolist(), clear, strict=True))

    def go_on(self, standing: Standing, filled: Array, moved: Array) -> float:
        """Go on to another state, in which the agent stands where it stood and something else has moved.

        Args:
            standing: As at first, in that state.
            filled: Lowest and highest corner of the box that the agent fills at the start, metres, (2, 3).
            moved: Boxes in which something moved, (k, 2, 3).

        Returns:
            How far the nearest cell is, metres, of which something else is true now; infinite if there is none. Ways
            that are shorter are as they were.
        """
        self._standing, self._clear_at = standing, {}
        cells = np.array(list(self.free_at)).reshape(-1, 2)
        offsets_m = self._offsets_m(cells)
        touching = touched(filled + np.insert(offsets_m, 2, 0.0, axis=1)[:, None], moved)
        asked, clear = cells[touching].tolist(), standing.clear(offsets_m[touching])
        now = {(x, y): known or standing.free(self.offset_m(x, y)) for (x, y), known in zip(asked, clear, strict=True)}
        changed = [at for at, is_free in now.items() if self.free_at[at] != is_free]
        self.free_at |= now
        if changed:
            self._begin()
        return min((math.hypot(*at) * self._settings.move_step_m for at in changed), default=math.inf)

    def offset_m(self, ahead: float, aside: float) -> tuple[float, float]:
        """Where a cell is, from the start, metres along the world's axes."""
        x, y = self._forward
        return ahead * x - aside * y, ahead * y + aside * x

    def _offsets_m(self, cells: Array) -> Array:
        """The same of some cells, (k, 2)."""
        (x, y), (ahead, aside) = self._forward, cells.T
        return np.stack((ahead * x - aside * y, ahead * y + aside * x), axis=1)


def moved(state: State, agent: Agent, offset_m: tuple[float, float], turn_rad: float = 0.0) -> State:
    """The state in which an agent's base has moved over the floor and turned about the vertical."""
    base = np.array(state.qpos[agent.base])
    base[:2] += offset_m
    base[3:] = turned_about_z(base[3:], turn_rad)
    return state.replace(at=agent.base, to=base)
