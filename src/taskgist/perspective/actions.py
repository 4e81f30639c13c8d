"""Virtual actions: what an agent might do, by the paper's names (Eq. 1-6), and how much of it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from taskgist.errors import UnknownNameError
from taskgist.settings import Efforts
from taskgist.world.bodies.agent import Agent
from taskgist.world.bodies.profile import Axis
from taskgist.world.postures import seat_position
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- The seat that an agent would sit down onto (Make_Sitting).

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


# --- Turns and leans of the torso (Eq. 4).


@dataclass(frozen=True)
class Bend:
    """A turn and a lean of the torso.

    Attributes:
        changes: New angles in radians, by index into qpos; joints that stay are left out.
        actions: The virtual actions.
        by_rad: How far turn and lean are from the current ones, together.
    """

    changes: Mapping[int, float] = field(default_factory=dict)
    actions: tuple[str, ...] = ()
    by_rad: float = 0.0


def bends_of(agent: Agent, current: State, settings: Efforts, actions: frozenset[str]) -> list[Bend]:
    """Every turn with every lean of the torso, the torso as it is among them.

    Args:
        agent: The agent.
        current: From which the amount counts.
        settings: Steps of turn and lean.
        actions: Virtual actions that may be used.
    """
    profile, joints = agent.profile, agent.joints
    turns = _bends(TURN, profile.turn, joints, current, settings.turn_step_rad) if TURN in actions else [Bend()]
    leans = _bends(LEAN, profile.lean, joints, current, settings.lean_step_rad) if LEAN in actions else [Bend()]
    return [
        Bend({**turn.changes, **lean.changes}, turn.actions + lean.actions, turn.by_rad + lean.by_rad)
        for turn, lean in itertools.product(turns, leans)
    ]


def _bends(action: str, axis: Axis | None, joints: Mapping[str, int], current: State, step_rad: float) -> list[Bend]:
    """The current angle, which is always allowed, then all multiples of a step within the joint's range."""
    if axis is None:
        return [Bend()]
    index = joints[axis.joint]
    now = float(current.qpos[index])
    low, high = (limit / step_rad for limit in axis.range_rad)
    angles = [count * step_rad for count in range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)]
    others = [angle for angle in angles if abs(angle - now) > STILL_RAD]
    return [Bend(), *(Bend({index: angle}, (action,), abs(angle - now)) for angle in others)]
