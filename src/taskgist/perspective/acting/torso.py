"""Turns and leans of the torso (Eq. 4)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from taskgist.perspective.acting.virtual_actions import LEAN, STILL_RAD, TURN
from taskgist.settings import Efforts
from taskgist.world import Agent, State
from taskgist.world.body.profile import Axis


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
