"""Trials: the stances from which a map is made, each asked about many cells at once.

They are the stances of the search (``Standpoint.stances``), all of them. At level 4 the search turns the chest to its
target; so does a map, to every cell by itself. Only what blocks is tested in steps there: with the chest turned to the
next multiple of ``efforts.turn_step_rad`` from where the agent heads now, not exactly to the cell.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.floor import moved
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import Stance
from taskgist.perspective.maps.clear import clear_places
from taskgist.world import Pose, State
from taskgist.world.geometry.rotations import yaw_of

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
AHEAD_M = 1000.0
SAME_M = 1e-9


@dataclass(frozen=True, eq=False)
class Trial:
    """A stance that may give an ability towards some cells.

    Attributes:
        low_m: With ``high_m`` the box in which the eye (or the shoulders) may be, metres, (3,).
        high_m: See ``low_m``.
        mark: What tells it from others, for choosing different ones first: numbers, (k,).
        able: Whether the ability holds towards each of some cells, given by index (n,), were nothing in the way.
        free: Whether nothing is in the way then, for each of them.
    """

    low_m: Array
    high_m: Array
    mark: Array
    able: Callable[[Indices], Mask]
    free: Callable[[Indices], Mask]


def always_free(cells: Indices) -> Mask:
    """For the current state: what touches now is no obstacle."""
    return np.ones(len(cells), dtype=bool)


def free_in(here: Standpoint, state: State) -> Callable[[Indices], Mask]:
    """Whether an agent collides with nothing in a state, whatever the cell; found once, when first asked."""
    found: list[bool] = []

    def free(cells: Indices) -> Mask:
        if not found:
            found.append(here.blocked(state) is None)
        return np.full(len(cells), found[0])

    return free


def stances_of(here: Standpoint, level: int) -> list[Stance]:
    """The stances of a level below 4, which do not turn to what the agent sees or reaches."""
    target = here.state.qpos[here.agent.base][:3]
    return [batch[index] for batch in here.stances(level, target) for index in range(len(batch))]


@dataclass(frozen=True, eq=False)
class Facing:
    """A way to stand that turns to its target: one lean of the torso, anywhere on the floor.

    Attributes:
        state: Standing at the start, the chest turned where the agent heads now.
        base_m: Where the base stands in that state, metres, (2,).
        chest_rad: Where the chest points in it.
        places_m: Places of the floor to stand on so, metres in the world, (n, 2).
        clear: Whether nothing is near each of them, (n,).
    """

    state: State
    base_m: Array
    chest_rad: float
    places_m: Array
    clear: Mask

    def local(self, pose: Pose) -> tuple[Array, Array]:
        """A pose in the state, in a frame that stands under the base and looks along the chest: (3,) and (3, 3)."""
        cos, sin = math.cos(self.chest_rad), math.sin(self.chest_rad)
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return turn @ (pose.position - (*self.base_m, 0.0)), turn @ pose.matrix


def facings(here: Standpoint) -> list[Facing]:
    """The ways to stand of level 4."""
    base = here.state.qpos[here.agent.base]
    heading = yaw_of(base[3:])
    target = base[:3] + AHEAD_M * np.array([math.cos(heading), math.sin(heading), 0.0])
    batches = list(here.stances(4, target))
    if not batches:
        return []
    offsets = np.unique(np.round(np.concatenate([batch.offsets_m for batch in batches]), 9), axis=0)
    first = batches[0]
    at_start = np.flatnonzero(np.abs(first.offsets_m).max(axis=1) < SAME_M)
    return [_facing(here, first[int(index)], target, offsets) for index in at_start]


def _facing(here: Standpoint, stance: Stance, target: Array, offsets: Array) -> Facing:
    spot = np.array(stance.state.qpos[here.agent.base][:2])
    ahead, places = target[:2] - spot, spot + offsets
    clear = clear_places(here, stance.state, spot, places)
    return Facing(stance.state, spot, math.atan2(ahead[1], ahead[0]), places, clear)


class FreeFacing:
    """Whether an agent that turns to cells from a place collides with nothing, in steps of the chest's direction.

    Args:
        here: The agent's standpoint.
        way: How it stands.
        place_m: Where, metres in the world, (2,).
        centers: Centres of all cells, metres, (cells, 3).
        clear: Whether nothing is near, so that no test is needed.
    """

    def __init__(self, here: Standpoint, way: Facing, place_m: Array, centers: Array, *, clear: bool) -> None:
        self._here, self._way, self._place, self._centers, self._clear = here, way, place_m, centers, clear
        self._step_rad = here.settings.efforts.turn_step_rad
        self._heading_rad = yaw_of(here.state.qpos[here.agent.base][3:])
        self._known: dict[int, bool] = {}

    def __call__(self, cells: Indices) -> Mask:
        """Whether the agent may turn to each of some cells, (n,)."""
        if self._clear:
            return always_free(cells)
        ahead = self._centers[cells, :2] - self._place
        away = np.arctan2(ahead[:, 1], ahead[:, 0]) - self._heading_rad
        around = round(2 * math.pi / self._step_rad)
        steps = np.round(np.round(away / self._step_rad, 9)).astype(int) % around
        found = {int(step): self._free(int(step)) for step in np.unique(steps)}
        return np.array([found[step] for step in steps.tolist()], dtype=bool)

    def _free(self, step: int) -> bool:
        if step not in self._known:
            turn_rad = self._heading_rad + step * self._step_rad - self._way.chest_rad
            agent, state = self._here.agent, self._way.state
            offset = self._place - self._way.base_m
            moved_there = moved(state, agent, (float(offset[0]), float(offset[1])), turn_rad)
            self._known[step] = self._here.blocked(moved_there) is None
        return self._known[step]
