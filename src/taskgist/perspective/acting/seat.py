"""The seat that an agent would sit down onto (Make_Sitting)."""

from __future__ import annotations

from taskgist.settings import Efforts
from taskgist.world import Agent, Stage, seat_position

DOWN = (0.0, 0.0, -1.0)
HEADROOM_M = 0.05
"""How far above the highest seat the search begins."""


def seat_height_m(stage: Stage, agent: Agent, settings: Efforts) -> float | None:
    """Height of what the agent would sit down onto, metres; None if nothing there has a seat's height.

    Args:
        stage: The scene in the agent's state. Agents are looked through, and nobody sits on one.
        agent: The agent.
        settings: Heights of seats.
    """
    lowest, highest = settings.seat_height_m
    scene = stage.scene
    things = [geom for geom, owner in enumerate(scene.owners) if owner not in scene.agents]
    above = (*seat_position(stage, agent), highest + HEADROOM_M)
    geoms, distances = stage.cast(above, [DOWN], only=things)
    height = highest + HEADROOM_M - float(distances[0])
    return height if geoms[0] >= 0 and lowest <= height <= highest else None
