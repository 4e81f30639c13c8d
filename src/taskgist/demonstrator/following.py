"""Following: the body follows a hand along its way, from posture to posture, at people's pace."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.body import Body
from taskgist.demonstrator.hand import HandPose
from taskgist.demonstrator.motion import Motion
from taskgist.errors import SceneError
from taskgist.world import State

Array = NDArray[np.float64]

MEAN_SPEED_M_S = 0.45
"""Mean speed of a hand; the peak is nearly twice as much (unhurried reaching [Flash & Hogan 1985])."""
LEVER_M = 0.20
"""Lever with which the largest turn of a joint counts like a way of the hand: it bounds the joints' speeds."""
SHORTEST_S = 0.6
WAY_ITERATIONS, GOAL_ITERATIONS = 10, 60
"""Most steps of a fit on the way, where the next knot goes on from there, and at the goal, which must be met."""
LARGEST_ERROR_M = 0.003
"""How far a hand may end from its goal."""
MORE_LEAN_RAD = tuple(math.radians(degrees) for degrees in (0.0, 4.0, 8.0, 12.0))
"""How much farther than thought one leans where the arm does not get to its goal."""
SHORTEST_STEP_M = 1e-4
"""Keeps postures apart whose hands are at the same place."""
Phase = Literal["out", "over", "back"]
LEANING: Mapping[Phase, Callable[[Array], Array]] = {
    "out": lambda way: way**2,
    "over": lambda way: way,
    "back": lambda way: 1.0 - (1.0 - way) ** 2,
}
"""Share of the torso's movement after a share of the hand's way: near the body a hand needs no lean."""


def followed(
    body: Body, state: State, side: str, way: Sequence[HandPose], *, torso_rad: Array, phase: Phase, role: str
) -> list[State]:
    """States in which a hand follows a way, the one to start from included.

    Who does not get to the goal leans a little more.

    Args:
        body: Whose hand.
        state: Where everything is at first.
        side: The hand.
        way: Where it passes, the last one being the goal.
        torso_rad: Turn and lean of the torso at the goal, (2,).
        phase: Out from rest, over from place to place, or back to rest, which follows after the goal.
        role: Who that is in the demonstration, for the error.

    Raises:
        SceneError: The hand does not get to its goal; on the way back it need not.
    """
    if phase == "back":
        states, _ = _through(body, state, side, way, torso_rad, phase)
        return [*states, body.with_posture(states[-1], body.resting_posture)]
    for more in MORE_LEAN_RAD:
        torso = np.clip(torso_rad + (0.0, more), *body.ranges_rad[:2].T)
        states, error = _through(body, state, side, way, torso, phase)
        if error <= LARGEST_ERROR_M:
            return states
    raise SceneError(
        f"the {side} hand ends {1000 * error:.0f} mm from where it shall be",
        where=body.agent.name,
        field=f"{side}_palm",
        value=tuple(way[-1].palm.round(3).tolist()),
        hint=f"put the thing or its goal nearer to the {role} agent",
    )


def _through(
    body: Body, state: State, side: str, way: Sequence[HandPose], torso_rad: Array, phase: Phase
) -> tuple[list[State], float]:
    """States in which the hand passes its way, and how many metres the last one is from its goal."""
    states, error = [state], 0.0
    begin = body.posture(state)[:2]
    shares = LEANING[phase](np.linspace(0.0, 1.0, len(way) + 1)[1:])
    for hand, share in zip(way, shares, strict=True):
        torso = begin + share * (torso_rad - begin)
        iterations = GOAL_ITERATIONS if hand is way[-1] else WAY_ITERATIONS
        state, error = body.reaching(state, side, hand, torso, iterations=iterations)
        states.append(state)
    return states, error


def paced(
    body: Body, side: str, states: Sequence[State], *, start_s: float, tempo: float, duration_s: float | None
) -> Motion:
    """The motion of a body through states.

    Args:
        body: The body.
        side: The hand that it is about.
        states: The states, two or more.
        start_s: When it begins.
        tempo: How much longer than usual it takes, as a factor.
        duration_s: How long it takes; None: as long as unhurried people take.
    """
    palms = np.array([body.hand(state, side).palm for state in states])
    postures = np.array([body.posture(state) for state in states])
    moved = np.linalg.norm(np.diff(palms, axis=0), axis=1)
    turned = np.abs(np.diff(postures, axis=0)).max(axis=1)
    steps = np.hypot(moved, LEVER_M * turned) + SHORTEST_STEP_M
    ways = np.concatenate(([0.0], np.cumsum(steps)))
    lasts = duration_s or max(SHORTEST_S, ways[-1] / MEAN_SPEED_M_S) * tempo
    return Motion(postures, ways / ways[-1], start_s, lasts)
