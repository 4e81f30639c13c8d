"""Candidates in the air, in a hand: held up before somebody's face, or handed over.

There a thing is where hands would hold it; whose hands is for others.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.perspective.search import able
from taskgist.planning.placing import HEADINGS, Asking, Candidate, Means
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, multiply
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

R3 = 1.2207440846057596 ** -np.arange(1.0, 4.0)
"""Steps of a sequence of points that covers a cube evenly [Roberts 2018]."""
VIEW_M, BELOW_EYES_M = (0.35, 1.0), 0.12
"""How far from the eye a thing is held to be looked at (about half a metre is comfortable), and how far below the line
between two faces, so that neither hides the other."""
VIEW_RAD, BELOW_RAD = math.radians(35.0), math.radians(35.0)
"""How far aside, and how far beneath that line."""
TAKING, TAKING_RAD = (0.45, 0.9), math.radians(45.0)
"""From which shares of the taker's arm a thing is handed over, and how far aside of where the taker faces."""
TAKING_BELOW_RAD = (0.0, math.radians(50.0))
"""How far below the shoulder."""
LOW_LEVEL = 2
"""Who takes a thing needs no more effort to reach it than turning or leaning the torso."""
AIR_M = 0.02
"""How far a thing in a hand is from all but the arms at least."""
POINTS = 512
"""So many points are tried with each way of turning the thing."""


def held_up(asking: Asking) -> Iterator[Candidate]:
    """Held up before the target's face, on the way to the performer's, at the height of the faces and below."""
    stage = asking.stage.show(asking.start)
    scene = stage.scene
    eye = stage.eye(scene.agent(asking.target)).position
    sight = stage.eye(scene.agent(asking.performer)).position - eye
    yaw, pitch = math.atan2(sight[1], sight[0]), math.atan2(sight[2], math.hypot(sight[0], sight[1]))
    far_m = max(VIEW_M[0], min(VIEW_M[1], float(np.linalg.norm(sight)) - VIEW_M[0]))
    arms = np.concatenate([arm.geoms for arm in scene.agent(asking.performer).arms])

    def place(share: Array) -> Array:
        distance = VIEW_M[0] + share[0] * (far_m - VIEW_M[0])
        aside, below = (2 * share[1] - 1) * VIEW_RAD, share[2] * BELOW_RAD
        ahead = _direction(yaw + aside, pitch - below)
        return np.asarray(eye + distance * ahead - (0.0, 0.0, BELOW_EYES_M))

    yield from _in_air(asking, "hold_up", asking.performer, place, np.setdiff1d(asking.others, arms), lambda _: True)


def handed_over(asking: Asking) -> Iterator[Candidate]:
    """Before the target, where it reaches the thing with little effort, and then in its hand."""
    stage = asking.stage.show(asking.start)
    agents = [stage.scene.agent(name) for name in (asking.performer, asking.target)]
    taking = agents[1].arms
    shoulders = [stage.shoulder(arm) for arm in taking]
    arms = np.concatenate([arm.geoms for agent in agents for arm in agent.arms])

    def place(share: Array) -> Array:
        which = int(share[1] * 997) % len(taking)
        shoulder, length_m = shoulders[which], taking[which].profile.length_m
        yaw = math.atan2(shoulder.matrix[1, 0], shoulder.matrix[0, 0]) + (2 * share[1] - 1) * TAKING_RAD
        below = TAKING_BELOW_RAD[0] + share[2] * (TAKING_BELOW_RAD[1] - TAKING_BELOW_RAD[0])
        distance = (TAKING[0] + share[0] * (TAKING[1] - TAKING[0])) * length_m
        return np.asarray(shoulder.position + distance * _direction(yaw, -below))

    def suits(free: State) -> bool:
        reached = able(
            asking.stage, asking.target, asking.thing, "reach", max_level=LOW_LEVEL, settings=asking.settings
        )
        asking.stage.show(free)
        return reached is True

    if len(taking):
        yield from _in_air(asking, "hand_over", asking.target, place, np.setdiff1d(asking.others, arms), suits)


def _in_air(
    asking: Asking,
    means: Means,
    holder: str,
    place: Callable[[Array], Array],
    others: Indices,
    suits: Callable[[State], bool],
) -> Iterator[Candidate]:
    """Candidates in somebody's hand, where they come near nothing.

    Args:
        asking: The question.
        means: How it gets there.
        holder: In whose hand.
        place: The place of the thing's middle for three numbers from 0 to 1.
        others: What it may not come near.
        suits: Whether a state, in which nobody holds it yet, serves the purpose.
    """
    turns = [(side, heading) for heading in HEADINGS for side in range(len(asking.sides))]
    for number in range(POINTS * len(turns)):
        point, turn = number % POINTS, number // POINTS
        middle = place((asking.shift + 0.5 + point * R3) % 1.0)
        side, heading = turns[(point + turn) % len(turns)]
        wxyz = multiply(about_z(heading), asking.sides[side].wxyz)
        position = middle - matrix_from_wxyz(wxyz) @ asking.body.center
        free = asking.with_thing(position, wxyz)
        stage = asking.stage.show(free.with_holding(asking.held_by_others))
        if stage.closest(asking.own, others, limit_m=AIR_M)[0] < AIR_M or not suits(stage.state):
            continue
        hand = _nearest_hand(stage, holder, middle)
        state = asking.with_thing(position, wxyz, Hold(holder, hand, asking.thing))
        yield Candidate(means, asking.thing, np.concatenate((position, wxyz)), holder, state)


def _direction(yaw_rad: float, pitch_rad: float) -> Array:
    level = math.cos(pitch_rad)
    return np.array([level * math.cos(yaw_rad), level * math.sin(yaw_rad), math.sin(pitch_rad)])


def _nearest_hand(stage: Stage, agent: str, point: Array) -> str:
    """The side of the arm whose shoulder is nearest."""
    arms = stage.scene.agent(agent).arms
    away = [round(float(np.linalg.norm(stage.shoulder(arm).position - point)), 6) for arm in arms]
    return arms[int(np.argmin(away))].profile.side
