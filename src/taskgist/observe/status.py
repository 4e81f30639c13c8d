"""Status of hands, postures and placements in one state: raw facts, before time confirms them (5.2, 5.3.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from taskgist.facts import vocabulary as v
from taskgist.settings import Contact
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.contacts import Rest
from taskgist.world.holding import Holding, hand_known, holding_of, rests_on
from taskgist.world.postures import posture_of
from taskgist.world.stage import Stage
from taskgist.world.state import Hold

POSTURE_SYMBOLS = {"standing": v.STANDING, "sitting": v.SITTING}


@dataclass(frozen=True)
class Placed:
    """Where an object is: the symbol (None: unknown), and by what: support, container, or hands."""

    symbol: str | None
    by: tuple[str, ...] = ()


@dataclass(frozen=True)
class HandUse:
    """What a hand does: the symbol for *some* object (None: unknown), and which object or support."""

    symbol: str | None
    of: str | None = None


@dataclass(frozen=True)
class Statuses:
    """Raw facts of one state.

    Attributes:
        placements: By object.
        hands: By (agent, side).
        postures: By agent; None is unknown.
    """

    placements: Mapping[str, Placed]
    hands: Mapping[tuple[str, str], HandUse]
    postures: Mapping[str, str | None]


def placement_key(placed: Placed) -> str | None:
    """What of a placement must last to be confirmed."""
    return placed.symbol


def hand_key(use: HandUse) -> tuple[str | None, str | None]:
    """What of a hand's use must last: which object it holds matters, on which support it rests does not."""
    return use.symbol, use.of if use.symbol == v.HOLDING_OBJECT else None


def statuses_of(stage: Stage, settings: Contact, resting: Callable[[Stage, str], Rest] | None = None) -> Statuses:
    """Raw facts of the state that a stage shows.

    Args:
        stage: The scene in a state.
        settings: Distances.
        resting: Finds what objects rest on and lie in; see ``holding_of``.
    """
    scene = stage.scene
    held = {name: holding_of(stage, name, settings, resting) for name in scene.objects}
    agents = [scene.agent(name) for name in scene.agents]
    return Statuses(
        placements={name: placed(holding) for name, holding in held.items()},
        hands={
            (agent.name, arm.profile.side): hand_use(stage, agent, arm, held.__getitem__, settings)
            for agent in agents
            for arm in agent.arms
        },
        postures={agent.name: posture_symbol(stage, agent, settings) for agent in agents},
    )


def placed(holding: Holding | None) -> Placed:
    """Placement with the precedence of DESIGN 4.5: Inside_Container, On_Support, In_Hand, In_Air."""
    if holding is None:
        return Placed(None)
    if holding.container:
        return Placed(v.INSIDE_CONTAINER, (holding.container,))
    if holding.support:
        return Placed(v.ON_SUPPORT, (holding.support,))
    if holding.hands:
        return Placed(v.IN_HAND, tuple(f"{agent}'s {side} hand" for agent, side in holding.hands))
    return Placed(v.IN_AIR if holding.complete else None)


def hand_use(
    stage: Stage, agent: Agent, arm: ArmIndices, held: Callable[[str], Holding | None], settings: Contact
) -> HandUse:
    """What one hand does (Eq. 16); holding comes before resting.

    Args:
        stage: The scene in a state.
        agent: Whose hand.
        arm: Which hand.
        held: Gives who holds an object; asked of those only that the hand may hold.
        settings: Distances.
    """
    if not hand_known(stage, agent, arm):
        return HandUse(None)
    hand = (agent.name, arm.profile.side)
    for name in _may_hold(stage, *hand):
        holding = held(name)
        if holding and hand in holding.hands:
            return HandUse(v.HOLDING_OBJECT, name)
    support = rests_on(stage, arm, settings)
    return HandUse(v.RESTING_ON_SUPPORT, support) if support else HandUse(v.FREE_OF_OBJECT)


def _may_hold(stage: Stage, agent: str, side: str) -> list[str]:
    """Objects that a hand may hold: all, unless it was decided over time what it is that moves with the hand."""
    decided = stage.state.holding
    return [name for name in stage.scene.objects if decided is None or Hold(agent, side, name) in decided]


def posture_symbol(stage: Stage, agent: Agent, settings: Contact) -> str | None:
    """Posture of an agent; None if it is unknown."""
    posture = posture_of(stage, agent, settings)
    return POSTURE_SYMBOLS[posture] if posture else None
