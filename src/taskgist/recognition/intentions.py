"""Intentions: which agent is after which thing at a moment of a recording, seen from what came before.

- **reaching**: an empty hand goes towards a thing, faster than hands drift, as seen from its own shoulder: who walks
  past reaches for nothing. It is the thing that lies on the hand's way; of several there, the nearest.
- **walking**: an agent with an empty hand approaches a thing, as relations over time have it, and looks at it.

Whoever looks for a thing turns the head and looks at nothing known: which thing it is, no movement tells. That is to
be asked, or known otherwise. Only the frames up to the moment are looked at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.attention import gaze
from taskgist.observe.observer import Observer, held_in
from taskgist.observe.relations import middle_of
from taskgist.observe.relations_over_time import RelationsOverTime
from taskgist.perspective.effort import Ability
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import hand_known
from taskgist.world.stage import Stage
from taskgist.world.state import State

LOOK_BACK_S = 0.4
"""Over so long it is looked where a hand goes."""
REACHES_M_S = 0.2
"""A hand that is slower reaches for nothing (ours: reaches peak at 0.5 to 1.5 m/s, hands that hang sway below 0.1)."""
OFF_WAY_RAD = math.radians(25.0)
"""Farther off a hand's way lies nothing that it goes to (ours: reaches are curved, and hands come from above)."""
ALIKE_RAD = math.radians(20.0)
"""Of things that lie no farther off the way than the least one and this, the nearest is meant (ours: hands go around
what stands in front)."""

Behaviour = Literal["reaching", "walking"]
WANTED: dict[Behaviour, Ability] = {"reaching": "reach", "walking": "reach"}
"""What is wanted by what is done."""


@dataclass(frozen=True)
class Intention:
    """An agent is after a thing.

    Attributes:
        agent: Who.
        thing: What it is after.
        behaviour: What it does that tells.
    """

    agent: str
    thing: str
    behaviour: Behaviour

    @property
    def ability(self) -> Ability:
        """What it wants of the thing."""
        return WANTED[self.behaviour]


def intentions_at_the_end(so_far: Recording, *, settings: Settings = DEFAULT) -> tuple[Intention, ...]:
    """Who is after which thing in the last frame, as far as hands and ways tell; each agent after one at most.

    Args:
        so_far: What has come of a recording by then.
        settings: Distances, angles and speeds.
    """
    now = so_far.state(len(so_far) - 1)
    before = so_far.at(max(now.time_s - LOOK_BACK_S, float(so_far.times_s[0])))
    stage = Stage(so_far.scene)
    relations = RelationsOverTime(Observer(so_far.scene, so_far, settings), so_far, settings)
    found = list[Intention]()
    for agent in so_far.scene.agents:
        if name := _reached_for(stage, before, now, agent, settings):
            found.append(Intention(agent, name, "reaching"))
        elif name := _walked_to(stage, now, agent, relations, settings):
            found.append(Intention(agent, name, "walking"))
    return tuple(found)


def _reached_for(stage: Stage, before: State, now: State, agent: str, settings: Settings) -> str | None:
    """The thing that lies on the way of an agent's empty hand; None if no hand goes anywhere."""
    body, since_s = stage.scene.agent(agent), now.time_s - before.time_s
    if since_s <= 0.0:
        return None
    first = _from_shoulders(stage.show(before), body)
    last = _from_shoulders(stage.show(now), body)
    empty = [side for side in first if side in last and held_in(stage, agent, side, settings.contact) is None]
    chosen: list[tuple[float, str]] = []
    for side in empty:
        way = last[side] - first[side]
        speed_m_s = float(np.linalg.norm(way)) / since_s
        if speed_m_s < REACHES_M_S:
            continue
        palm = stage.site(body.arm(side).palm_site).position
        ways = {name: middle_of(stage, name) - palm for name in stage.scene.objects if stage.state.known([name])}
        off_rad = {name: _angle_rad(way, towards) for name, towards in ways.items()}
        least_rad = min(off_rad.values(), default=math.pi)
        if least_rad < OFF_WAY_RAD:
            there = [name for name, each in off_rad.items() if each <= least_rad + ALIKE_RAD]
            chosen.append(min((float(np.linalg.norm(ways[name])), name) for name in there))
    return min(chosen)[1] if chosen else None


def _from_shoulders(stage: Stage, agent: Agent) -> dict[str, Array]:
    """Where the palms that are tracked are, seen from their shoulders, in the world's directions, metres."""
    return {
        side: stage.site(agent.arm(side).palm_site).position - stage.shoulder(agent.arm(side)).position
        for side in agent.sides
        if hand_known(stage, agent, agent.arm(side))
    }


def _angle_rad(one: Array, other: Array) -> float:
    lengths = float(np.linalg.norm(one) * np.linalg.norm(other))
    return math.acos(min(max(float(one @ other) / lengths, -1.0), 1.0)) if lengths > 0.0 else math.pi


def _walked_to(stage: Stage, now: State, agent: str, relations: RelationsOverTime, settings: Settings) -> str | None:
    """The thing that an agent with an empty hand approaches and looks at; None if there is none."""
    stage.show(now)
    look = gaze(stage, agent, settings)
    if look is None or look.target not in stage.scene.objects:
        return None
    if all(held_in(stage, agent, side, settings.contact) for side in stage.scene.agent(agent).sides):
        return None
    return look.target if relations.at(agent, look.target, now.time_s)["approaching"] else None
