"""Where things are from a named agent's view, in one state: how far, on which side, faced, touched, carried.

"Left of me" and "left of the book, as I see it" are told apart by a reference. Without one, the agent's own chest
gives left and front. With one, the agent's place does: what is between it and the reference is in front of that, what
is farther away is behind it, and left is the agent's left. All values are frozen; None is unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.attention import check_thing
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.contacts import holding_of, wearer_of
from taskgist.world.geometry.transforms import wrapped, yaw_of
from taskgist.world.stage import Stage

DistanceClass = Literal["near", "far"]
DistanceChange = Literal["nearer", "same", "farther"]
Side = Literal["left", "right", "front", "behind"]


@dataclass(frozen=True)
class Distance:
    """How far a thing is from an agent.

    Attributes:
        value: ``near`` or ``far``.
        metres: From the agent's vertical axis, up to its eyes, to the thing's middle.
    """

    value: DistanceClass
    metres: float


@dataclass(frozen=True)
class Direction:
    """On which side of somebody, or of something, a thing is.

    Attributes:
        sides: One or two of left, right, front and behind; none above or beneath.
        bearing_rad: Angle about the vertical from the front, positive to the left, in (−π, π].
    """

    sides: tuple[Side, ...]
    bearing_rad: float


def distance(stage: Stage, agent: str, name: str, settings: Settings = DEFAULT) -> Distance | None:
    """How far an object, or another agent, is from an agent; None where either was not tracked.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    body = stage.scene.agent(agent)
    check_thing(stage.scene, name, but=agent)
    if not stage.state.known([agent, name]):
        return None
    (x, y, z), middle = middle_of(stage, name), stage.body_position(body.root_body)
    above = max(z - float(stage.eye(body).position[2]), 0.0)
    metres = math.hypot(x - middle[0], y - middle[1], above)
    return Distance("near" if metres <= settings.relations.near_m else "far", metres)


def distance_change(before: Distance, after: Distance, settings: Settings = DEFAULT) -> DistanceChange:
    """How a distance has changed from one state to a later one."""
    change_m = after.metres - before.metres
    if abs(change_m) <= settings.relations.change_m:
        return "same"
    return "nearer" if change_m < 0 else "farther"


def direction(
    stage: Stage, agent: str, name: str, *, of: str | None = None, settings: Settings = DEFAULT
) -> Direction | None:
    """On which side a thing is, from an agent's view.

    Args:
        stage: The scene in a state.
        agent: From whose view.
        name: The object or other agent whose place is told.
        of: The object or other agent that it is left of, right of, in front of or behind; the agent itself if left out.
        settings: How wide a side is.

    Returns:
        None where one of them was not tracked.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    scene, body = stage.scene, stage.scene.agent(agent)
    check_thing(scene, name, but=of or agent)
    start = stage.body_position(body.root_body)
    if of is None:
        if not stage.state.known([f"{agent}/torso", name]):
            return None
        return _direction(middle_of(stage, name) - start, _heading_rad(stage, body), settings)
    check_thing(scene, of, but=agent)
    if not stage.state.known([agent, name, of]):
        return None
    reference = middle_of(stage, of)
    away = reference - start
    if math.hypot(away[0], away[1]) <= settings.relations.overhead_m:
        return Direction((), 0.0)
    # as if the reference stood with its front towards the agent, but with the agent's left
    seen = _direction(middle_of(stage, name) - reference, math.atan2(away[1], away[0]), settings)
    swapped: dict[Side, Side] = {"front": "behind", "behind": "front"}
    sides = tuple(swapped.get(side, side) for side in seen.sides)
    return Direction(sides, wrapped(math.pi - seen.bearing_rad) if sides else 0.0)


def facing(stage: Stage, agent: str, name: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether an agent's chest is turned to an object, or to another agent; None where either was not tracked.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    found = direction(stage, agent, name, settings=settings)
    if found is None:
        return None
    return bool(found.sides) and abs(found.bearing_rad) <= settings.relations.facing_rad


def next_to(stage: Stage, one: str, other: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether two things, objects or agents, are near to each other; None where either was not tracked.

    Raises:
        UnknownNameError: There is no such thing.
    """
    return _closer(stage, one, other, settings.relations.beside_m)


def touching(stage: Stage, one: str, other: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether two of objects and agents touch; None where that hangs on what was not tracked.

    Raises:
        UnknownNameError: There is no such thing.
    """
    return _closer(stage, one, other, settings.relations.touching_m)


def carried_by(stage: Stage, name: str, settings: Settings = DEFAULT) -> tuple[str, ...] | None:
    """The agents that carry an object: in hands, on their bodies, or on or in what is carried; None is unknown.

    Raises:
        UnknownNameError: There is no such object.
    """
    stage.scene.object_body(name)
    carriers = {name}
    while True:
        holding = holding_of(stage, name, settings.contact)
        if holding is None:
            return None
        beneath = holding.container or holding.support
        if beneath is None:
            agents = tuple(dict.fromkeys(agent for agent, _ in holding.hands))
            if agents or not holding.complete:
                return agents or None
            wearer, sure = wearer_of(stage, name, settings.contact)
            return (wearer,) if wearer else () if sure else None
        if beneath not in stage.scene.objects or beneath in carriers:
            return ()
        carriers.add(beneath)
        name = beneath


def middle_of(stage: Stage, name: str) -> Array:
    """The middle of an object, or the base of an agent, metres, (3,)."""
    scene = stage.scene
    if name in scene.agents:
        return stage.body_position(scene.agent(name).root_body)
    return np.asarray(stage.geom_centers(scene.seen_geoms(name)).mean(axis=0))


def _heading_rad(stage: Stage, agent: Agent) -> float:
    """Where the chest points, about the vertical: square to the line of the shoulders, however far it leans."""
    if not agent.arms:
        return yaw_of(stage.state.qpos[agent.base][3:])
    left = np.mean([stage.shoulder(arm).matrix[:, 1] for arm in agent.arms], axis=0)
    return math.atan2(-left[0], left[1])


def _direction(offset: Array, front_rad: float, settings: Settings) -> Direction:
    limits = settings.relations
    if math.hypot(offset[0], offset[1]) <= limits.overhead_m:
        return Direction((), 0.0)
    bearing = wrapped(math.atan2(offset[1], offset[0]) - front_rad)
    middles: dict[Side, float] = {"left": math.pi / 2, "right": -math.pi / 2, "front": 0.0, "behind": math.pi}
    sides = tuple(side for side, middle in middles.items() if abs(wrapped(bearing - middle)) <= limits.direction_rad)
    return Direction(sides, bearing)


def _closer(stage: Stage, one: str, other: str, limit_m: float) -> bool | None:
    """Whether two things are closer than that to each other."""
    scene, known = stage.scene, stage.state.known
    check_thing(scene, one)
    check_thing(scene, other, but=one)
    if not known([one, other]):
        return None
    hidden = scene.untracked_geoms(stage.state.untracked)
    first, second = (np.setdiff1d(scene.solid_geoms_of(name), hidden) for name in (one, other))
    if stage.closest(first, second, limit_m=limit_m)[0] < limit_m:
        return True
    parts = [f"{name}/{part}" for name in (one, other) if name in scene.agents for part in scene.parts(name)]
    return False if known(parts) else None
