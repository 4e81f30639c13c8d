"""The floor that an agent can get to: a grid around it, flooded from where it stands (Move_To).

The grid is anchored at the agent, its axes lie along the agent's heading. A cell can be stood on if head, torso and
base collide with nothing there; a step to one of the eight neighbours is possible if the same is true half-way, so
that nobody walks through a thin wall. Cells come in the order of the way's length, and only as many as are asked for.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.collisions import touched
from taskgist.settings import Efforts
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import turned_about_z, yaw_of
from taskgist.world.state import State

Cell = tuple[int, int]
STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))

BATCHES_M = (0.6, math.inf)
"""Lengths of the way up to which places are looked at together."""
NOTHING: Mapping[tuple[float, float], bool] = MappingProxyType({})


@dataclass(frozen=True)
class Place:
    """A cell that can be got to: offset from the start along world axes, and length of the way, all in metres."""

    offset_m: tuple[float, float]
    way_m: float


class Floor:
    """Places that an agent can get to, nearest first.

    Args:
        start: The standing agent's state.
        agent: The agent.
        settings: Step and radius.
        free: Whether the agent collides with nothing when moved by an offset in metres along the world's axes.
        known: What is known of that already, by cell; half cells lie between.

    ``free_at`` is what is known by now.
    """

    def __init__(
        self,
        start: State,
        agent: Agent,
        settings: Efforts,
        free: Callable[[tuple[float, float]], bool],
        known: Mapping[tuple[float, float], bool] = NOTHING,
    ) -> None:
        self._settings, self._free = settings, free
        yaw, step_m = yaw_of(start.qpos[agent.base][3:]), settings.move_step_m
        self._forward = (step_m * math.cos(yaw), step_m * math.sin(yaw))
        self.free_at: dict[tuple[float, float], bool] = dict(known)
        self._batches: list[list[Place]] = []
        self._flood = self._flooded()
        self._next: Place | None = next(self._flood, None)

    def batches(self) -> Iterator[list[Place]]:
        """Places in order of the way, in batches up to a growing length; what was flooded once is kept."""
        for index, limit_m in enumerate(BATCHES_M):
            if index == len(self._batches):
                self._batches.append(self._up_to(limit_m))
            if self._batches[index]:
                yield self._batches[index]

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
            yield Place(self.offset_m(*cell), way)
            for ahead, aside, step_m in steps:
                following, longer = (cell[0] + ahead, cell[1] + aside), way + step_m
                if longer < ways.get(following, math.inf) and following not in done and self._leads(cell, following):
                    ways[following] = longer
                    heapq.heappush(queue, (longer, following))

    def _leads(self, cell: Cell, following: Cell) -> bool:
        half_way = ((cell[0] + following[0]) / 2, (cell[1] + following[1]) / 2)
        return self._within(following) and self._stands(following) and self._stands(half_way)

    def _within(self, cell: Cell) -> bool:
        return math.hypot(*cell) * self._settings.move_step_m <= self._settings.move_radius_m + 1e-9

    def _stands(self, at: tuple[float, float]) -> bool:
        if at not in self.free_at:
            self.free_at[at] = self._free(self.offset_m(*at))
        return self.free_at[at]

    def known_after(self, filled: Array, moved: Array) -> dict[tuple[float, float], bool]:
        """What is known of the floor and stays so when something moved.

        Args:
            filled: Lowest and highest corner of the box that the agent fills at the start, metres, (2, 3).
            moved: Boxes in which something moved, (k, 2, 3).
        """
        cells = list(self.free_at)
        offsets = np.array([(*self.offset_m(*cell), 0.0) for cell in cells]).reshape(-1, 1, 3)
        lost = touched(filled + offsets, moved).tolist()
        return {cell: self.free_at[cell] for cell, gone in zip(cells, lost, strict=True) if not gone}

    def offset_m(self, ahead: float, aside: float) -> tuple[float, float]:
        """Where a cell is, from the start, metres along the world's axes."""
        x, y = self._forward
        return ahead * x - aside * y, ahead * y + aside * x


def moved(state: State, agent: Agent, offset_m: tuple[float, float], turn_rad: float = 0.0) -> State:
    """The state in which an agent's base has moved over the floor and turned about the vertical."""
    base = np.array(state.qpos[agent.base])
    base[:2] += offset_m
    base[3:] = turned_about_z(base[3:], turn_rad)
    return state.replace(at=agent.base, to=base)
