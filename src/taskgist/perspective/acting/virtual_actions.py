"""Virtual actions: what an agent might do, by the paper's names (Eq. 1-6), and how much of it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from taskgist.errors import UnknownNameError
from taskgist.world import Agent, State

PAN, TILT = "Pan_Head", "Tilt_Head"
TURN, LEAN = "Turn_Torso", "Lean_Torso"
STAND, SIT = "Make_Standing", "Make_Sitting"
MOVE = "Move_To"
NO_ACTION = "No_Action_Required"
"""What level 0 takes (5.1.5)."""
NO_KNOWN_ACTION = "No_Possible_Known_Action"
"""What level 5 takes."""

STILL_RAD = 1e-9
"""Turns below this are rounding."""


def stretch(side: str) -> str:
    """Name of stretching out the arm of a side (Eq. 3)."""
    return f"Stretch_Out_Arm({side})"


def actions_of(agent: Agent) -> tuple[str, ...]:
    """The virtual actions that an agent's body has, in the order in which they are listed."""
    p = agent.profile
    has = {PAN: p.pan, TILT: p.tilt, TURN: p.turn, LEAN: p.lean, MOVE: p.moves}
    both = "sitting" in p.legs.can and "standing" in p.legs.can
    postures = (STAND, SIT) if both else ()
    return (*(action for action, part in has.items() if part), *postures, *(stretch(side) for side in agent.sides))


def checked_actions(agent: Agent, actions: Iterable[str] | None) -> frozenset[str]:
    """The given actions, or all that the agent has.

    Raises:
        UnknownNameError: The agent has no such action.
    """
    known = actions_of(agent)
    chosen = known if actions is None else tuple(actions)
    for action in chosen:
        if action not in known:
            raise UnknownNameError("virtual action", action, known)
    return frozenset(chosen)


@dataclass(frozen=True, order=True)
class Amount:
    """How much of an effort: compared in this order, so that a step weighs more than any turn (5.1.6).

    Attributes:
        moved_m: Length of the way over the floor, metres.
        turned_rad: Turn of the whole body on the spot, radians.
        torso_rad: Turn and lean of the torso together, radians.
        head_rad: Pan and tilt of the head together, radians.
    """

    moved_m: float = 0.0
    turned_rad: float = 0.0
    torso_rad: float = 0.0
    head_rad: float = 0.0

    @property
    def key(self) -> tuple[float, float, float, float]:
        """For comparing: rounded, so that equal amounts stay equal wherever the scene stands."""
        return (round(self.moved_m, 6), round(self.turned_rad, 6), round(self.torso_rad, 6), round(self.head_rad, 6))


@dataclass(frozen=True, eq=False)
class Stance:
    """A state that virtual actions of base, legs and torso lead to; head and arms are as they were.

    Attributes:
        state: The state.
        actions: What leads there, in order.
        amount: How much of it.
    """

    state: State
    actions: tuple[str, ...] = ()
    amount: Amount = Amount()
