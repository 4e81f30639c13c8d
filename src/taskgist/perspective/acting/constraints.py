"""What a virtual action must respect besides the joints' ranges: head, torso and base push into nothing (5.1.4).

Tracked bodies touch and interpenetrate a little, as a sitter does with the chair. Therefore only a contact blocks
that is deeper than the same two shapes' contact in the current state, by more than ``collision_m``.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.region import Region
from taskgist.settings import Contact, Settings
from taskgist.world import Agent, Stage, holding_of
from taskgist.world.geometry.box_gaps import any_near
from taskgist.world.geometry.boxes import ball_around, near_ball

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Blocking:
    """A contact that blocks.

    Attributes:
        part: The agent's own part.
        other: What it meets: an object, a piece of furniture or another agent.
        depth_m: How deep.
    """

    part: str
    other: str
    depth_m: float

    def __str__(self) -> str:
        return f"{self.part} against {self.other}, {self.depth_m:.2f} m deep"

    def as_miss(self) -> dict[str, object]:
        """What shows that only this is in the way."""
        return {"blocking": self.evidence}

    @property
    def evidence(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return {"part": self.part, "other": self.other, "depth_m": self.depth_m}


class Collisions:
    """Judges states of an agent by what its head, torso and base would push into.

    ``obstacles`` are the shapes that are in the way of it, (n,); they stay where they are, whatever the agent does.

    Args:
        stage: The scene in the agent's current state, with whose contacts others are compared.
        agent: The agent.
        settings: Tolerance.
        held: Objects that the agent holds: they are in nobody's way.
    """

    def __init__(self, stage: Stage, agent: Agent, settings: Settings, held: Collection[str]) -> None:
        self._stage, self._agent = stage, agent
        self.obstacles = _obstacles(stage, agent, held)
        self._tolerance_m = settings.efforts.collision_m
        self._farthest_m = settings.efforts.move_radius_m + settings.efforts.move_step_m
        self._usual_m = {
            (geom, other): depth for geom, other, depth in stage.overlaps(agent.core_geoms, self.obstacles)
        }

    @cached_property
    def boxes(self) -> Array:
        """Boxes around the obstacles, (n, 18); see ``geometry.boxes``."""
        return self._stage.boxes(self.obstacles)

    def find(self) -> Blocking | None:
        """The first contact that blocks in the state that the stage shows; None where it is free."""
        first = self._first()
        if first is None:
            return None
        geom, other, depth_m = first
        return Blocking(part_of(self._stage, self._agent, geom), self._stage.scene.owners[other], depth_m)

    def _first(self) -> tuple[int, int, float] | None:
        """Its two shapes, and how deep they overlap."""
        tolerance_m, usual_m = self._tolerance_m, self._usual_m
        contacts = self._stage.overlaps(self._agent.core_geoms, self.obstacles, deeper_than_m=tolerance_m)
        return next((each for each in contacts if each[2] > usual_m.get(each[:2], 0.0) + tolerance_m), None)

    def add_to(self, region: Region) -> None:
        """Let a region hold the agent's head, torso and base as the stage shows them."""
        core = self._agent.core_geoms
        region.add_balls(self._stage.geom_centers(core), self._stage.scene.model.geom_rbound[core])

    def footprint(self) -> Callable[[tuple[float, float]], bool]:
        """Tells whether the agent, as the stage shows it now, would be free when moved over the floor, by offset."""
        core = self._agent.core_geoms
        positions, matrices = self._stage.geoms(core)
        own = self._stage.boxes(core)
        x, y, z, radius_m = ball_around(own)
        around = self.boxes[near_ball(self.boxes, x, y, z, radius_m + self._farthest_m)]

        def free(offset_m: tuple[float, float]) -> bool:
            if not any_near(own, offset_m, around, -self._tolerance_m / 2):
                return True
            self._stage.place(core, positions + (*offset_m, 0.0), matrices)
            return self._first() is None

        return free


def _obstacles(stage: Stage, agent: Agent, held: Collection[str]) -> NDArray[np.intp]:
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


def part_of(stage: Stage, agent: Agent, geom: int) -> str:
    """Name of the part of an agent that a shape belongs to."""
    body = int(stage.scene.model.geom_bodyid[geom])
    return next((part for part, bodies in agent.parts.items() if body in bodies), "body")
