"""Postures: what the whole body does before torso, head and arms (effort level 3; Fig. 6).

People stand up and sit down (Eq. 5), bend at the hips and crouch; whoever sits at a table pushes the seat back first.
Robots do what their legs, or a torso that is lifted, allow. A posture is a candidate from which the torso turns and
leans. Postures come from the least to the greatest: whoever need not lower the hips does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.perspective.candidates import Candidate
from taskgist.perspective.effort import BEND, CROUCH, LIFT, PUSH, SIDLE, STAND, Amount
from taskgist.perspective.floor import moved
from taskgist.settings import Efforts
from taskgist.world.bending import bent, legs_of
from taskgist.world.bodies.agent import Agent
from taskgist.world.stage import Stage, seat_position, with_posture
from taskgist.world.state import State

STILL_M = 1e-6
"""Lifts below this are rounding."""
LEVEL_M = 0.05
"""A seat goes on beside somebody where it is equally high, but for cushions (ours)."""


def bends(
    stage: Stage, agent: Agent, start: Candidate, settings: Efforts, actions: frozenset[str]
) -> Iterator[Candidate]:
    """What the legs, or the lift of a torso, do to an agent that stands, the least first.

    Args:
        stage: The scene; it shows other states afterwards.
        agent: The agent.
        start: Standing.
        settings: Which bends, and steps of lifts.
        actions: Virtual actions that may be used.
    """
    if agent.profile.legs.hips:
        legs = legs_of(stage.show(start.state), agent)
        for share, pitch_rad in settings.bends:
            used = tuple(action for action, part in ((CROUCH, share), (BEND, pitch_rad)) if part)
            if actions.issuperset(used):
                lowered_m = share * agent.stature_m
                state = bent(stage, agent, start.state, legs, lowered_m=lowered_m, pitch_rad=pitch_rad)
                if state is not None:
                    amount = replace(start.amount, lowered_m=lowered_m, bent_rad=pitch_rad)
                    yield replace(start, state=state, actions=(*start.actions, *used), amount=amount)
    if LIFT in actions:
        yield from sorted(_lifts(stage, agent, start, settings), key=lambda each: each.amount.key)


def _lifts(stage: Stage, agent: Agent, start: Candidate, settings: Efforts) -> Iterator[Candidate]:
    """The torso at other heights, both ends of the lift among them."""
    for name in agent.lifts:
        joint, index = stage.scene.model.joint(f"{agent.name}/{name}"), agent.joints[name]
        now = float(start.state.qpos[index])
        low, high = (float(limit) for limit in joint.range) if joint.limited[0] else (now, now)
        count = max(1, round((high - low) / settings.lift_step_m))
        for height in np.linspace(low, high, count + 1).tolist():
            if abs(height - now) > STILL_M:
                amount = replace(start.amount, lowered_m=abs(height - now))
                state = start.state.replace({index: height})
                yield replace(start, state=state, actions=(*start.actions, LIFT), amount=amount)


# --- Seats.

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
    geom, height_m = _seat(stage, seat_position(stage, agent), settings)
    return height_m if geom >= 0 and height_m >= settings.seat_height_m[0] else None


def _seat(stage: Stage, at: Array, settings: Efforts) -> tuple[int, float]:
    """The shape beneath a place, (2,), that is no higher than a seat, −1 for none; and how high it is, metres."""
    highest = settings.seat_height_m[1]
    geoms, distances = stage.cast((*at, highest + HEADROOM_M), [DOWN], only=stage.scene.things_geoms)
    height_m = highest + HEADROOM_M - float(distances[0])
    return (int(geoms[0]), height_m) if height_m <= highest else (-1, height_m)


def leaving_seat(stage: Stage, agent: Agent, settings: Efforts, actions: frozenset[str]) -> Iterator[Candidate]:
    """An agent that sits, after standing up elsewhere: with its seat pushed back, or beside it along a long seat.

    Args:
        stage: The scene in the agent's state; it shows other states afterwards.
        agent: The agent.
        settings: Heights and sizes of seats, and how far they are pushed.
        actions: Virtual actions that may be used.

    Yields:
        Candidates by increasing way; they may collide.
    """
    start = stage.state
    geom, height_m = _seat(stage, start.qpos[agent.base][:2], settings)
    if geom < 0 or height_m < settings.seat_height_m[0]:
        return
    heading = stage.body_axis(agent.root_body, 0)[:2]
    heading = heading / np.linalg.norm(heading)
    seat = _Seat(stage, agent, geom, heading, settings)
    count = round(settings.leaving_seat_m / settings.leaving_step_m)
    for way_m in (settings.leaving_step_m * np.arange(1, count + 1)).tolist():
        if PUSH in actions and seat.goes_back(way_m):
            yield _stood_up(stage, agent, start, -way_m * heading, (PUSH, STAND), {seat.owner})
        for side in (1.0, -1.0):
            aside = side * way_m * np.array([-heading[1], heading[0]])
            if SIDLE in actions and seat.goes_on(aside, height_m, settings):
                yield _stood_up(stage, agent, start, aside, (SIDLE, STAND), set())


def _stood_up(
    stage: Stage, agent: Agent, start: State, offset_m: Array, actions: tuple[str, ...], aside: Set[str]
) -> Candidate:
    there = moved(start, agent, (float(offset_m[0]), float(offset_m[1])))
    state = with_posture(stage.show(there), agent, "standing")
    return Candidate(state, actions, Amount(moved_m=float(np.hypot(*offset_m))), frozenset(aside))


class _Seat:
    """What an agent sits on: it slides back if it is small, and has room; along a long one the agent can move."""

    def __init__(self, stage: Stage, agent: Agent, geom: int, heading: Array, settings: Efforts) -> None:
        self._stage, self._state, self._heading = stage, stage.state, heading
        self.owner = stage.scene.owners[geom]
        self._geoms = stage.scene.solid_geoms_of(self.owner)
        low, high = stage.bounds(self._geoms)
        in_building = int(stage.scene.model.geom_bodyid[geom]) == 0
        self._slides = not in_building and float((high - low)[:2].max()) <= settings.sliding_seat_m
        others = stage.solid_geoms()
        self._others = others[~np.isin(others, (*stage.scene.geoms_of(self.owner), *agent.geoms))]
        self._tolerance_m = settings.collision_m
        self._usual = set(self._met(0.0))
        self._base = np.array(stage.state.qpos[agent.base][:2])

    def goes_back(self, way_m: float) -> bool:
        """Whether it can be pushed back so far; once it cannot, it goes no farther."""
        if self._slides and not set(self._met(way_m)) <= self._usual:
            self._slides = False
        return self._slides

    def _met(self, back_m: float) -> list[tuple[int, int]]:
        """What it would push into."""
        positions, matrices = self._stage.show(self._state).geoms(self._geoms)
        self._stage.place(self._geoms, positions - (*(back_m * self._heading), 0.0), matrices)
        found = self._stage.overlaps(self._geoms, self._others, deeper_than_m=self._tolerance_m)
        return [(geom, other) for geom, other, _ in found]

    def goes_on(self, offset_m: Array, height_m: float, settings: Efforts) -> bool:
        """Whether it is there, equally high, beside where the agent sits."""
        geom, there_m = _seat(self._stage.show(self._state), self._base + offset_m, settings)
        same = geom >= 0 and self._stage.scene.owners[geom] == self.owner
        return same and abs(there_m - height_m) <= LEVEL_M
