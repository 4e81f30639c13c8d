"""Holding: decided once, here. Hand status, placement and effort 0 all read it.

A hand holds an object when it is close to it and the object rests on nothing ("the object is not on a support and the
hand is close to the object", 8.5). Nothing that rests on a support is held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taskgist.settings import Contact
from taskgist.world.body.agent import Agent, ArmIndices
from taskgist.world.contacts import container_of, support_of
from taskgist.world.stage import Stage
from taskgist.world.state import Hold


@dataclass(frozen=True)
class Holding:
    """Who holds an object in one state.

    Attributes:
        hands: The holding hands as (agent, side), in the scene's order.
        support: What the object rests on, or None.
        container: What the object lies in, or None.
        complete: False when an untracked hand might hold it, or an untracked object might carry it: then empty
            ``hands`` or a missing ``support`` say nothing.
    """

    hands: tuple[tuple[str, str], ...]
    support: str | None
    container: str | None
    complete: bool


def holding_of(stage: Stage, name: str, settings: Contact) -> Holding | None:
    """Who holds an object, and what it rests on or lies in; None if the object was not tracked.

    Args:
        stage: The scene in a state.
        name: The object.
        settings: Distances.
    """
    state = stage.state
    if not state.known([name]):
        return None
    container = container_of(stage, name, settings)
    support = support_of(stage, name, settings)
    if container or support:
        return Holding((), support, container, complete=True)
    hands, complete = [], all(state.known([other]) for other in stage.scene.objects)
    for agent_name in stage.scene.agents:
        agent = stage.scene.agent(agent_name)
        for arm in agent.arms:
            if not hand_known(stage, agent, arm):
                complete = False
            elif _holds(stage, Hold(agent_name, arm.profile.side, name), arm, settings):
                hands.append((agent_name, arm.profile.side))
    return Holding(tuple(hands), None, None, complete)


def _holds(stage: Stage, hold: Hold, arm: ArmIndices, settings: Contact) -> bool:
    if stage.state.holding is not None:
        return hold in stage.state.holding
    return is_near(stage, arm, hold.object, settings)


def is_near(stage: Stage, arm: ArmIndices, name: str, settings: Contact) -> bool:
    """Whether a hand is close enough to an object to hold it."""
    return hand_gap_m(stage, arm, name, limit_m=settings.grip_m) < settings.grip_m


def objects_near(stage: Stage, agent: Agent, settings: Contact) -> tuple[str, ...]:
    """Objects that a hand of an agent is close enough to, to hold them."""
    hands = np.concatenate([arm.hand_geoms for arm in agent.arms]) if agent.arms else np.array([], dtype=np.intp)
    pairs = stage.near_pairs(hands, stage.scene.objects_geoms, limit_m=settings.grip_m)
    candidates = {stage.scene.owners[geom] for _, geom in pairs}
    near = {name for name in candidates if any(is_near(stage, arm, name, settings) for arm in agent.arms)}
    return tuple(name for name in stage.scene.objects if name in near)


def hand_known(stage: Stage, agent: Agent, arm: ArmIndices) -> bool:
    """Whether the hand was tracked."""
    return stage.state.known([f"{agent.name}/{arm.profile.side}_arm", agent.name])


def hand_gap_m(stage: Stage, arm: ArmIndices, name: str, *, limit_m: float) -> float:
    """Signed gap in metres between a hand and an object, at most ``limit_m``."""
    return stage.closest(arm.hand_geoms, stage.scene.solid_geoms_of(name), limit_m=limit_m)[0]


def rests_on(stage: Stage, arm: ArmIndices, settings: Contact) -> str | None:
    """The support that a hand lies on: something beneath it, neither agent nor object in the hand; None otherwise."""
    scene = stage.scene
    others = [g for g in stage.solid_geoms() if scene.owners[g] not in scene.agents]
    gap, hand_geom, other = stage.closest(arm.hand_geoms, others, limit_m=settings.support_m)
    if gap >= settings.support_m or other < 0:
        return None
    above = stage.geom_centers([hand_geom])[0]
    hits, _ = stage.cast(above, [(0.0, 0.0, -1.0)], exclude_body=arm.hand_body)
    owner = scene.owners[other]
    return owner if hits[0] >= 0 and scene.owners[hits[0]] == owner else None
