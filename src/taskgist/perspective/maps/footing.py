"""Footing: the stances of an effort level from which a map is made, and in which of them nothing is in the way.

They are the stances of the search (``Standpoint.stances``), all of them. At level 4 the search turns the chest to its
target; so does a map, to every cell by itself. Only what blocks is tested in steps there: with the chest turned to the
next multiple of ``efforts.turn_step_rad`` from where the agent heads now, not exactly to the cell.

A *way* is how the agent stands: a state. A *trial* is a way somewhere on the floor. Maps of both abilities ask for the
same footing, so it is kept for as long as its standpoint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.maps.clear import clear_places
from taskgist.world import Pose, State
from taskgist.world.geometry.rotations import yaw_of

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
UNKNOWN, BLOCKED, FREE = -1, 0, 1
AHEAD_M = 1000.0
SAME_M = 1e-9


class Footing:
    """Trials that do not turn to what the agent sees or reaches.

    Attributes:
        states: The ways.
        way: Which of them each trial is, (n,).
        places_m: Where the base stands in each, metres in the world, (n, 2); nowhere unless ``turns``.
        turns: Whether the chest turns to each cell.
        facing: Where the agent heads now, and the step in which what blocks is tested, radians, (2,).
        free: Whether a trial is ``FREE`` or ``BLOCKED`` by the step of the chest, or ``UNKNOWN`` so far, (n, steps).
    """

    turns = False

    def __init__(self, states: Sequence[State], way: NDArray[np.intp], places_m: Array, facing: Array) -> None:
        self.states, self.way, self.places_m, self.facing = states, way, places_m, facing
        self.free: NDArray[np.int8] = np.full((len(way), 1), FREE, dtype=np.int8)

    def frame(self, way: int) -> Pose:  # noqa: ARG002 - as those that turn
        """The frame in which all of a way is told."""
        return Pose(np.zeros(3), np.eye(3))

    def test(self, here: Standpoint, asked: Mask) -> None:  # noqa: ARG002 - as those that turn
        """Find out about some trials and steps, (n, steps)."""
        assert not asked.any(), "all is known"


class TurningFooting(Footing):
    """Trials that turn: leans of the torso, each at every place of the floor.

    Args:
        here: The agent's standpoint.
        states: The ways, standing where the walk starts.
        target: What the chest points to in these, metres, at least (2,).
        offsets_m: Places of the floor, from where the walk starts, (places, 2).
    """

    turns = True

    def __init__(self, here: Standpoint, states: Sequence[State], target: Array, offsets_m: Array) -> None:
        self._bases = [np.array(state.qpos[here.agent.base][:2]) for state in states]
        self._chests_rad = [math.atan2(*(target[:2] - base)[::-1]) for base in self._bases]
        places = [base + offsets_m for base in self._bases]
        facing = np.array((yaw_of(here.state.qpos[here.agent.base][3:]), here.settings.efforts.turn_step_rad))
        way = np.repeat(np.arange(len(states)), len(offsets_m))
        super().__init__(states, way, np.concatenate(places), facing)
        ways = zip(states, self._bases, places, strict=True)
        clear = np.concatenate([clear_places(here, *each) for each in ways])
        steps = round(2 * math.pi / self.facing[1])
        self.free = np.repeat(np.where(clear, FREE, UNKNOWN).astype(np.int8)[:, None], steps, axis=1)
        self._shapes: dict[int, tuple[Array, Array]] = {}

    def frame(self, way: int) -> Pose:
        """A frame that stands under the base and looks along the chest."""
        cos, sin = math.cos(self._chests_rad[way]), math.sin(self._chests_rad[way])
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return Pose(np.array((*self._bases[way], 0.0)), turn)

    def test(self, here: Standpoint, asked: Mask) -> None:
        """Place the agent's shapes, and ask what they push into."""
        for trial, step in np.argwhere(asked & (self.free == UNKNOWN)).tolist():
            self.free[trial, step] = FREE if self._is_free(here, trial, step) else BLOCKED

    def _is_free(self, here: Standpoint, trial: int, step: int) -> bool:
        way = int(self.way[trial])
        positions, matrices = self._shapes_of(here, way)
        angle = self.facing[0] + step * self.facing[1]
        cos, sin = math.cos(angle), math.sin(angle)
        turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        place = (*self.places_m[trial], 0.0)
        turned = (turn @ matrices).reshape(-1, 9)
        here.stage.place(here.agent.core_geoms, positions @ turn.T + place, turned)
        return here.collisions.find() is None

    def _shapes_of(self, here: Standpoint, way: int) -> tuple[Array, Array]:
        """The shapes of head, torso and base in the frame of a way: metres, (n, 3), and (n, 3, 3)."""
        if way not in self._shapes:
            stage, frame = here.stage.show(self.states[way]), self.frame(way)
            positions, matrices = stage.geoms(here.agent.core_geoms)
            self._shapes[way] = frame.to_local(positions), frame.matrix.T @ matrices.reshape(-1, 3, 3)
        return self._shapes[way]


_KEPT: WeakKeyDictionary[Standpoint, dict[int, Footing]] = WeakKeyDictionary()


def footing_of(here: Standpoint, level: int) -> Footing:
    """The footing of an effort level, 0 to 4."""
    kept = _KEPT.setdefault(here, {})
    if level not in kept:
        kept[level] = _turning(here) if level == 4 else _standing(here, level)
    return kept[level]


def _standing(here: Standpoint, level: int) -> Footing:
    """What touches now is no obstacle to staying as one is."""
    batches = here.stances(level, here.state.qpos[here.agent.base][:3])
    states = [batch[index].state for batch in batches for index in range(len(batch))]
    if level > 1:
        states = [state for state in states if here.blocked(state) is None]
    return Footing(states, np.arange(len(states)), np.zeros((len(states), 2)), np.zeros(2))


def _turning(here: Standpoint) -> Footing:
    base = here.state.qpos[here.agent.base]
    heading = yaw_of(base[3:])
    target = base[:3] + AHEAD_M * np.array([math.cos(heading), math.sin(heading), 0.0])
    batches = list(here.stances(4, target))
    if not batches:
        return Footing((), np.arange(0), np.zeros((0, 2)), np.zeros(2))
    offsets = np.unique(np.round(np.concatenate([batch.offsets_m for batch in batches]), 9), axis=0)
    first = batches[0]
    at_start = np.flatnonzero(np.abs(first.offsets_m).max(axis=1) < SAME_M)
    return TurningFooting(here, [first[int(index)].state for index in at_start], target, offsets)
