"""Turns and leans of the torso (Eq. 4)."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

from taskgist.perspective.virtual_actions import LEAN, STILL_RAD, TURN, Stance
from taskgist.settings import Efforts
from taskgist.world import Agent, State
from taskgist.world.profile import Axis

Bend = tuple[dict[int, float], float]
"""Angle of a joint by its index into qpos, and how far that is from the current one; radians."""


def bent(stance: Stance, current: State, agent: Agent, settings: Efforts, actions: frozenset[str]) -> list[Stance]:
    """A stance with every turn and lean of the torso, by increasing amount: the stance itself first.

    Args:
        stance: With the torso as it is now.
        current: From which the amount counts.
        agent: The agent.
        settings: Steps of turn and lean.
        actions: Virtual actions that may be used.
    """
    turns = _bends(agent.profile.turn, agent, current, settings.turn_step_rad if TURN in actions else None)
    leans = _bends(agent.profile.lean, agent, current, settings.lean_step_rad if LEAN in actions else None)
    stances = [_with(stance, turn, lean) for turn, lean in itertools.product(turns, leans)]
    return sorted(stances, key=lambda each: each.amount.key)


def _with(stance: Stance, turn: Bend, lean: Bend) -> Stance:
    used = [action for action, (_, by_rad) in ((TURN, turn), (LEAN, lean)) if by_rad > STILL_RAD]
    return Stance(
        stance.state.replace(turn[0] | lean[0]),
        (*stance.actions, *used),
        replace(stance.amount, torso_rad=turn[1] + lean[1]),
    )


def _bends(axis: Axis | None, agent: Agent, current: State, step_rad: float | None) -> list[Bend]:
    """The current angle, which is always allowed, then all multiples of a step within the joint's range."""
    if axis is None or step_rad is None:
        return [({}, 0.0)]
    index = agent.joints[axis.joint]
    now = float(current.qpos[index])
    low, high = (limit / step_rad for limit in axis.range_rad)
    angles = [count * step_rad for count in range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)]
    others = [angle for angle in angles if abs(angle - now) > STILL_RAD]
    return [({}, 0.0), *(({index: angle}, abs(angle - now)) for angle in others)]
