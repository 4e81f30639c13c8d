"""The floor that an agent can get to: a grid around it, flooded from where it stands (Move_To).

The grid is anchored at the agent, its axes lie along the agent's heading. A cell can be stood on if head, torso and
base collide with nothing there; a step to one of the eight neighbours is possible if the same is true half-way, so
that nobody walks through a thin wall. Cells come in the order of the way's length, and only as many as are asked for.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from taskgist.settings import Efforts
from taskgist.world import Agent, State
from taskgist.world.rotations import about_z, multiply, yaw_of

Cell = tuple[int, int]
STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))


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
        free: Whether the agent collides with nothing in a state.
    """

    def __init__(self, start: State, agent: Agent, settings: Efforts, free: Callable[[State], bool]) -> None:
        self._start, self._agent, self._settings, self._free = start, agent, settings, free
        yaw = yaw_of(start.qpos[agent.base][3:])
        self._forward = settings.move_step_m * np.array((math.cos(yaw), math.sin(yaw)))
        self._free_at: dict[tuple[float, float], bool] = {}
        self._found: list[Place] = []
        self._flood = self._flooded()

    def __iter__(self) -> Iterator[Place]:
        """Places in order of the way; what was flooded once is kept."""
        index = 0
        while True:
            if index == len(self._found):
                place = next(self._flood, None)
                if place is None:
                    return
                self._found.append(place)
            yield self._found[index]
            index += 1

    def _flooded(self) -> Iterator[Place]:
        """Dijkstra's algorithm over the grid."""
        ways: dict[Cell, float] = {(0, 0): 0.0}
        queue: list[tuple[float, Cell]] = [(0.0, (0, 0))]
        done: set[Cell] = set()
        while queue:
            way, cell = heapq.heappop(queue)
            if cell in done:
                continue
            done.add(cell)
            yield Place(self._offset(*cell), way)
            for step in STEPS:
                following = (cell[0] + step[0], cell[1] + step[1])
                longer = way + math.hypot(*step) * self._settings.move_step_m
                if longer < ways.get(following, math.inf) and following not in done and self._leads(cell, following):
                    ways[following] = longer
                    heapq.heappush(queue, (longer, following))

    def _leads(self, cell: Cell, following: Cell) -> bool:
        half_way = ((cell[0] + following[0]) / 2, (cell[1] + following[1]) / 2)
        return self._within(following) and self._stands(following) and self._stands(half_way)

    def _within(self, cell: Cell) -> bool:
        return math.hypot(*cell) * self._settings.move_step_m <= self._settings.move_radius_m + 1e-9

    def _stands(self, at: tuple[float, float]) -> bool:
        if at not in self._free_at:
            self._free_at[at] = self._free(moved(self._start, self._agent, self._offset(*at)))
        return self._free_at[at]

    def _offset(self, ahead: float, aside: float) -> tuple[float, float]:
        x, y = self._forward
        return float(ahead * x - aside * y), float(ahead * y + aside * x)


def moved(state: State, agent: Agent, offset_m: tuple[float, float], turn_rad: float = 0.0) -> State:
    """The state in which an agent's base has moved over the floor and turned about the vertical."""
    base = np.array(state.qpos[agent.base])
    base[:2] += offset_m
    base[3:] = multiply(about_z(turn_rad), base[3:])
    return state.replace(at=agent.base, to=base)
