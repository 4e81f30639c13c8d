"""What a virtual action must respect besides the joints' ranges: head, torso and base push into nothing (5.1.4).

Tracked bodies touch and interpenetrate a little, as a sitter does with the chair. Therefore only a contact blocks
that is deeper than the same two shapes' contact in the current state, by more than ``collision_m``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Settings
from taskgist.world import Agent, Stage, hand_gap_m, holding_of


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

    @property
    def evidence(self) -> dict[str, object]:
        """Plain data, fit for JSON."""
        return {"part": self.part, "other": self.other, "depth_m": self.depth_m}


class Collisions:
    """Judges states of an agent by what its head, torso and base would push into.

    ``obstacles`` are the shapes that are in the way of it, (n,).

    Args:
        stage: The scene in the agent's current state, with whose contacts others are compared.
        agent: The agent.
        settings: Tolerance.
    """

    def __init__(self, stage: Stage, agent: Agent, settings: Settings) -> None:
        self._stage, self._agent = stage, agent
        self.obstacles = obstacles(stage, agent, settings)
        self._tolerance_m = settings.efforts.collision_m
        self._usual_m = {
            (geom, other): depth for geom, other, depth in stage.overlaps(agent.core_geoms, self.obstacles)
        }

    def find(self) -> Blocking | None:
        """The first contact that blocks in the state that the stage shows; None where it is free."""
        for geom, other, depth_m in self._stage.overlaps(self._agent.core_geoms, self.obstacles):
            if depth_m > self._usual_m.get((geom, other), 0.0) + self._tolerance_m:
                return Blocking(part_of(self._stage, self._agent, geom), self._stage.scene.owners[other], depth_m)
        return None


def obstacles(stage: Stage, agent: Agent, settings: Settings) -> NDArray[np.intp]:
    """Solid shapes that are neither the agent's own nor of anything that it holds."""
    free = {agent.name, *held_by(stage, agent, settings)}
    return np.array([geom for geom in stage.solid_geoms() if stage.scene.owners[geom] not in free], dtype=np.intp)


def held_by(stage: Stage, agent: Agent, settings: Settings) -> tuple[str, ...]:
    """Objects that an agent holds."""
    grip_m = settings.contact.grip_m
    near = [
        name
        for name in stage.scene.objects
        if any(hand_gap_m(stage, arm, name, limit_m=grip_m) < grip_m for arm in agent.arms)
    ]
    holdings = {name: holding_of(stage, name, settings.contact) for name in near}
    return tuple(
        name
        for name, holding in holdings.items()
        if holding and agent.name in (hand_of for hand_of, _ in holding.hands)
    )


def part_of(stage: Stage, agent: Agent, geom: int) -> str:
    """Name of the part of an agent that a shape belongs to."""
    body = int(stage.scene.model.geom_bodyid[geom])
    return next((part for part, bodies in agent.parts.items() if body in bodies), "body")
