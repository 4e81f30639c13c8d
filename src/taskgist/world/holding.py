"""Who holds an object in one state: decided here for hand status, placement and effort 0 alike.

A hand holds an object when it is close to it and the object rests on nothing ("the object is not on a support and the
hand is close to the object", 8.5). Nothing that rests on a support is held. Where states follow each other,
``observe/carrying.py`` tells hands that hold from those that only pass, and writes it into the states.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from taskgist.settings import Contact
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.contacts import Rest, rest_of
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


def holding_of(
    stage: Stage, name: str, settings: Contact, resting: Callable[[Stage, str], Rest] | None = None
) -> Holding | None:
    """Who holds an object, and what it rests on or lies in; None if the object was not tracked.

    Args:
        stage: The scene in a state.
        name: The object.
        settings: Distances.
        resting: Finds what it rests on and lies in, such as a ``RestingMemory``; found at once if left out.
    """
    state = stage.state
    if not state.known([name]):
        return None
    rest = resting(stage, name) if resting else rest_of(stage, name, settings)
    if rest.container or rest.support:
        return Holding((), rest.support, rest.container, complete=True)
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
    near = {name for arm in agent.arms for name in _near(stage, arm, settings)}
    return tuple(name for name in stage.scene.objects if name in near)


def possible_holds(stage: Stage, settings: Contact) -> frozenset[Hold]:
    """Which tracked hands of all agents are close enough to which tracked objects, to hold them."""
    scene, near = stage.scene, set[Hold]()
    for name in scene.agents:
        agent = scene.agent(name)
        for arm in agent.arms:
            if hand_known(stage, agent, arm):
                near.update(Hold(name, arm.profile.side, each) for each in _near(stage, arm, settings))
    return frozenset(hold for hold in near if stage.state.known([hold.object]))


def _near(stage: Stage, arm: ArmIndices, settings: Contact) -> list[str]:
    """Objects that a hand is close to; few are looked at closely, for few are anywhere near."""
    pairs = stage.near_pairs(arm.hand_geoms, stage.scene.objects_geoms, limit_m=settings.grip_m)
    candidates = {stage.scene.owners[geom] for _, geom in pairs}
    return [name for name in candidates if is_near(stage, arm, name, settings)]


def hand_known(stage: Stage, agent: Agent, arm: ArmIndices) -> bool:
    """Whether the hand was tracked."""
    return stage.state.known([f"{agent.name}/{arm.profile.side}_arm", agent.name])


def hand_gap_m(stage: Stage, arm: ArmIndices, name: str, *, limit_m: float) -> float:
    """Signed gap in metres between a hand and an object, at most ``limit_m``."""
    return stage.closest(arm.hand_geoms, stage.scene.solid_geoms_of(name), limit_m=limit_m)[0]


def rests_on(stage: Stage, arm: ArmIndices, settings: Contact) -> str | None:
    """The support that a hand lies on: something beneath it, neither agent nor object in the hand; None otherwise."""
    scene = stage.scene
    pairs = stage.near_pairs(arm.hand_geoms, stage.solid_geoms(), limit_m=settings.support_m)
    others = sorted({other for _, other in pairs if scene.owners[other] not in scene.agents})
    gap, hand_geom, other = stage.closest(arm.hand_geoms, others, limit_m=settings.support_m)
    if gap >= settings.support_m or other < 0:
        return None
    above = stage.geom_centers([hand_geom])[0]
    hits, _ = stage.cast(above, [(0.0, 0.0, -1.0)], exclude_body=arm.hand_body)
    owner = scene.owners[other]
    return owner if hits[0] >= 0 and scene.owners[hits[0]] == owner else None
