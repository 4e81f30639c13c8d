"""What virtual actions must respect besides the joints' ranges: collisions, and what the agent holds or wears (5.1.4).

Head, torso and base push into nothing. Tracked bodies touch and interpenetrate a little, as a sitter does with the
chair. Therefore only a contact blocks that is deeper than the same two shapes' contact in the current state, by more
than ``collision_m``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import cached_property

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.effort import Blocking
from taskgist.perspective.target import Recorder, Region
from taskgist.settings import Contact, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import holding_of, wearer_of
from taskgist.world.geometry.distances import ball_around_boxes, clear_after, near_ball
from taskgist.world.geometry.solids import solids_of
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
        first = self.first_contact(self._tolerance_m)
        if first is None:
            return None
        geom, other, depth_m = first
        return Blocking(part_of(self._stage, self._agent, geom), self._stage.scene.owners[other], depth_m)

    def first_contact(self, tolerance_m: float) -> tuple[int, int, float] | None:
        """The two shapes of the first contact that is deeper than usual by more than that, and how deep they are."""
        usual_m = self.usual_m
        contacts = self._stage.overlaps(self._agent.core_geoms, self.obstacles, deeper_than_m=tolerance_m)
        return next((each for each in contacts if each[2] > usual_m.get(each[:2], 0.0) + tolerance_m), None)

    def footprint(self) -> Footprint:
        """The agent as the stage shows it now, to be moved over the floor."""
        return Footprint(self, self._stage, self._agent, self._farthest_m, self._passing_m)


class Footprint:
    """Whether an agent, as a stage showed it, could pass where an offset over the floor moves it."""

    def __init__(self, collisions: Collisions, stage: Stage, agent: Agent, farthest_m: float, passing_m: float) -> None:
        self._collisions, self._stage, self._core, self._passing_m = collisions, stage, agent.core_geoms, passing_m
        self._positions, self._matrices = stage.geoms(self._core)
        self._own = stage.boxes(self._core)
        x, y, z, radius_m = ball_around_boxes(self._own)
        self._around = collisions.boxes[near_ball(collisions.boxes, x, y, z, radius_m + farthest_m)]

    def clear(self, offsets_m: Array) -> list[bool]:
        """Whether it is free for sure after moving by offsets along the world's axes, metres, (k, 2)."""
        clear: list[bool] = clear_after(self._own, offsets_m, self._around, -self._passing_m / 2).tolist()
        return clear

    def free(self, offset_m: tuple[float, float]) -> bool:
        """Whether it collides with nothing after moving by an offset."""
        self._stage.place(self._core, self._positions + (*offset_m, 0.0), self._matrices)
        return self._collisions.first_contact(self._passing_m) is None


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
