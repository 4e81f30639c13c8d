"""What virtual actions must respect besides the joints' ranges: no collisions, and a way over free floor (5.1.4).

Head, torso and base push into nothing. Tracked bodies touch and interpenetrate a little, as a sitter does with the
chair. Therefore only a contact blocks that is deeper than the same two shapes' contact in the current state, by more
than ``collision_m``.

For moving, the floor is a grid around the agent, flooded from where it stands. The grid is anchored at the agent, its
axes lie along the agent's heading. A cell can be stood on if head, torso and base collide with nothing there; a step
to one of the eight neighbours is possible if the same is true half-way, so that nobody walks through a thin wall.
Cells come in the order of the way's length, and only as many as are asked for.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.effort import Blocking
from taskgist.perspective.target import Recorder, Region, touched
from taskgist.settings import Contact, Efforts, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import holding_of, wearer_of
from taskgist.world.geometry.distances import any_near, ball_around_boxes, near_ball
from taskgist.world.geometry.solids import solids_of
from taskgist.world.geometry.transforms import turned_about_z, yaw_of
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- Collisions of head, torso and base.


class Collisions:
    """What the agent's head, torso and base would push into in other states, and what else is in the way of it.

    Args:
        stage: The scene in the agent's current state, with whose contacts others are compared.
        agent: The agent.
        settings: Tolerance.
        held: Objects that the agent holds: they are in nobody's way.
        recorder: Notes where was felt for something.

    Attributes:
        obstacles: The shapes that are in the way, (n,); they stay where they are, whatever the agent does.
        usual_m: How deep pairs of shapes, one of the agent, overlap in the current state, metres.
    """

    def __init__(
        self, stage: Stage, agent: Agent, settings: Settings, held: Collection[str], recorder: Recorder
    ) -> None:
        self._stage, self._agent, self._recorder = stage, agent, recorder
        self.obstacles = _obstacles(stage, agent, held)
        self._tolerance_m, self._passing_m = settings.efforts.collision_m, settings.efforts.passing_m
        self._farthest_m = settings.efforts.move_radius_m + settings.efforts.move_step_m
        self.usual_m = {(geom, other): depth for geom, other, depth in stage.overlaps(agent.core_geoms, self.obstacles)}

    @cached_property
    def boxes(self) -> Array:
        """Boxes around the obstacles, (n, 18); see ``geometry.boxes``."""
        return self._stage.boxes(self.obstacles)

    @cached_property
    def solids(self) -> Array:
        """The obstacles by formula, (n, 17); see ``geometry.solids``."""
        return solids_of(self._stage.scene.model, self.obstacles, *self._stage.geoms(self.obstacles))

    def blocking(self, state: State) -> Blocking | None:
        """The first contact that blocks a state, None if it is free; the stage shows that state afterwards."""
        self._recorder.add_body(self.filled(state))
        return self.find()

    def filled(self, state: State) -> Region:
        """The box that the agent's head, torso and base fill in a state; the stage shows that state afterwards."""
        core, region = self._agent.core_geoms, Region()
        if len(core):
            region.add_points(self._stage.show(state).bounds(core))
        return region

    def around(self, middle: Array, radius_m: float) -> tuple[Indices, Array]:
        """Obstacles that may reach into a ball about a point, (3,), and boxes around them, (k,) and (k, 18)."""
        self._recorder.target.add_balls(middle[None], np.array([radius_m]))
        near = self._near(middle, radius_m)
        return self.obstacles[near], self.boxes[near]

    def near(self, middle: Array, radius_m: float) -> Indices:
        """The same obstacles; whoever asks notes where he feels for them."""
        return self.obstacles[self._near(middle, radius_m)]

    def _near(self, middle: Array, radius_m: float) -> Indices:
        x, y, z = middle.tolist()
        return near_ball(self.boxes, x, y, z, radius_m)

    def find(self) -> Blocking | None:
        """The first contact that blocks in the state that the stage shows; None where it is free."""
        first = self._first(self._tolerance_m)
        if first is None:
            return None
        geom, other, depth_m = first
        return Blocking(part_of(self._stage, self._agent, geom), self._stage.scene.owners[other], depth_m)

    def _first(self, tolerance_m: float) -> tuple[int, int, float] | None:
        """The two shapes of the first contact that is deeper than usual by more than that, and how deep they are."""
        usual_m = self.usual_m
        contacts = self._stage.overlaps(self._agent.core_geoms, self.obstacles, deeper_than_m=tolerance_m)
        return next((each for each in contacts if each[2] > usual_m.get(each[:2], 0.0) + tolerance_m), None)

    def footprint(self) -> Callable[[tuple[float, float]], bool]:
        """Tells whether the agent, as the stage shows it now, could pass where an offset over the floor moves it."""
        core = self._agent.core_geoms
        positions, matrices = self._stage.geoms(core)
        own = self._stage.boxes(core)
        x, y, z, radius_m = ball_around_boxes(own)
        around = self.boxes[near_ball(self.boxes, x, y, z, radius_m + self._farthest_m)]

        def free(offset_m: tuple[float, float]) -> bool:
            if not any_near(own, offset_m, around, -self._passing_m / 2):
                return True
            self._stage.place(core, positions + (*offset_m, 0.0), matrices)
            return self._first(self._passing_m) is None

        return free


def _obstacles(stage: Stage, agent: Agent, held: Collection[str]) -> Indices:
    """Solid shapes that are neither the agent's own nor of anything that it holds."""
    counted = np.zeros(stage.scene.model.ngeom, dtype=np.bool_)
    counted[stage.solid_geoms()] = True
    for name in (agent.name, *held):
        counted[stage.scene.geoms_of(name)] = False
    return np.flatnonzero(counted)


def held_by(stage: Stage, agent: Agent, near: Iterable[str], settings: Contact) -> dict[str, str]:
    """Objects that an agent holds, with the side of the hand (the first in the profile's order).

    Only those near to its hands can be, unless it was decided over time who holds what.
    """
    decided = stage.state.holding
    candidates = near if decided is None else sorted({hold.object for hold in decided if hold.agent == agent.name})
    held = {}
    for name in candidates:
        holding = holding_of(stage, name, settings)
        sides = [side for holder, side in (holding.hands if holding else ()) if holder == agent.name]
        if sides:
            held[name] = sides[0]
    return held


def near_body(stage: Stage, agent: Agent, settings: Contact) -> tuple[str, ...]:
    """Objects that are near enough to an agent's body to lie on it."""
    pairs = stage.near_pairs(agent.geoms, stage.scene.objects_geoms, limit_m=settings.support_m)
    near = {stage.scene.owners[geom] for _, geom in pairs}
    return tuple(name for name in stage.scene.objects if name in near and stage.state.known([name]))


def wears(stage: Stage, agent: Agent, name: str, settings: Contact) -> bool:
    """Whether an object that nothing else carries, nor holds, lies on an agent's lap, or elsewhere on its body."""
    holding = holding_of(stage, name, settings)
    if holding is None or holding.support or holding.container or holding.hands:
        return False
    return wearer_of(stage, name, settings)[0] == agent.name


def part_of(stage: Stage, agent: Agent, geom: int) -> str:
    """Name of the part of an agent that a shape belongs to."""
    body = int(stage.scene.model.geom_bodyid[geom])
    return next((part for part, bodies in agent.parts.items() if body in bodies), "body")


# --- The floor that an agent can get to (Move_To).

Cell = tuple[int, int]
STEPS: tuple[Cell, ...] = ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1))

BATCHES_M = (0.6, 2.0, 4.0, math.inf)
"""Lengths of the way up to which places are looked at together."""


@dataclass(frozen=True)
class Place:
    """A cell that can be got to: offset from the start along world axes, and length of the way, all in metres."""

    offset_m: tuple[float, float]
    way_m: float
    cell: Cell = (0, 0)


class Floor:
    """Places that an agent can get to, nearest first.

    Args:
        start: The standing agent's state.
        agent: The agent.
        settings: Step and radius.
        free: Whether the agent collides with nothing when moved by an offset in metres along the world's axes.
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
        free: Callable[[tuple[float, float]], bool],
        note: Callable[[float], None] = lambda _: None,
    ) -> None:
        self._settings, self._free, self.note = settings, free, note
        yaw, step_m = yaw_of(start.qpos[agent.base][3:]), settings.move_step_m
        self._forward = (step_m * math.cos(yaw), step_m * math.sin(yaw))
        self.free_at: dict[tuple[float, float], bool] = {}
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

    def _stands(self, at: tuple[float, float]) -> bool:
        if at not in self.free_at:
            self.free_at[at] = self._free(self.offset_m(*at))
        return self.free_at[at]

    def go_on(self, free: Callable[[tuple[float, float]], bool], filled: Array, moved: Array) -> float:
        """Go on to another state, in which the agent stands where it stood and something else has moved.

        Args:
            free: As at first, in that state.
            filled: Lowest and highest corner of the box that the agent fills at the start, metres, (2, 3).
            moved: Boxes in which something moved, (k, 2, 3).

        Returns:
            How far the nearest cell is, metres, of which something else is true now; infinite if there is none. Ways
            that are shorter are as they were.
        """
        self._free, cells = free, list(self.free_at)
        offsets = np.array([(*self.offset_m(*cell), 0.0) for cell in cells]).reshape(-1, 1, 3)
        touching = touched(filled + offsets, moved).tolist()
        before = {cell: self.free_at.pop(cell) for cell, moves in zip(cells, touching, strict=True) if moves}
        changed = [cell for cell, was_free in before.items() if self._stands(cell) != was_free]
        if changed:
            self._begin()
        return min((math.hypot(*cell) * self._settings.move_step_m for cell in changed), default=math.inf)

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
