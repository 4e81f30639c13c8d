"""Lines of sight and attention in one state: what is in sight whatever the gaze, who looks at what, who at whom.

A line of sight asks nothing of the gaze: it goes from the eye to all of a thing that would be seen if the head were
turned to it. The own body hides nothing then, for it turns along; what the hands hold does. Attention asks where the
head points: of what is in sight near there, the nearest is looked at. All values are frozen; None is unknown.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import Literal

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.errors import UnknownNameError
from taskgist.perspective.gaze import off_gaze
from taskgist.perspective.queries import both
from taskgist.perspective.target import SQUARE_ARCMIN_SR, box_corners
from taskgist.settings import DEFAULT, Settings
from taskgist.world.bodies.agent import Agent
from taskgist.world.geometry.transforms import normalized
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

SightClass = Literal["free", "partly", "blocked"]

FIRST_RAYS, LEAST_RAYS, MOST_RAYS = 1024, 256, 65536
"""Rays into the cone around a thing: more and more until so many meet it, but no more than that."""
GOLDEN_RAD = math.pi * (3.0 - math.sqrt(5.0))


@dataclass(frozen=True)
class LineOfSight:
    """How much of a thing is in sight of an agent, whatever its gaze.

    Attributes:
        value: ``free`` (all but what nobody speaks of), ``partly`` or ``blocked`` (nothing of it).
        share: Share of the thing's solid angle that is in sight, 0 to 1.
        blockers: What stands before it, and the share that it hides, most first.
    """

    value: SightClass
    share: float
    blockers: tuple[tuple[str, float], ...]


@dataclass(frozen=True)
class Gaze:
    """What an agent looks at.

    Attributes:
        target: An object, or another agent (its head); None: nothing that is known.
        off_rad: Angle between the gaze and the nearest of it that is in sight; None without a target.
    """

    target: str | None
    off_rad: float | None = None


def sight(stage: Stage, agent: str, name: str, settings: Settings = DEFAULT) -> LineOfSight | None:
    """The line of sight from an agent's eye to an object, or to another agent, whatever the gaze.

    Args:
        stage: The scene in a state.
        agent: Whose eye.
        name: The object or the other agent.
        settings: What counts as free, and what is looked through.

    Returns:
        None where the agent's head or the thing was not tracked.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    body = stage.scene.agent(agent)
    check_thing(stage.scene, name, but=agent)
    if not stage.state.known([f"{agent}/head", name]):
        return None
    view = _look(stage, body, stage.scene.seen_geoms(name), settings)
    value: SightClass = "partly"
    if view.share >= settings.relations.free_share:
        value = "free"
    elif view.share == 0.0:
        value = "blocked"
    return LineOfSight(value, view.share, view.blockers)


def gaze(stage: Stage, agent: str, settings: Settings = DEFAULT) -> Gaze | None:
    """What an agent looks at: of the objects and the heads of others that are in sight, the one nearest to its gaze.

    Args:
        stage: The scene in a state.
        agent: Who looks.
        settings: How far beside the head's direction it may be.

    Returns:
        None where the agent's head was not tracked, or it looks at nothing that is known and something is not.

    Raises:
        UnknownNameError: There is no such agent.
    """
    stage.scene.agent(agent)
    if not stage.state.known([f"{agent}/head"]):
        return None
    found = _gaze(stage, agent, settings)
    return None if found.target is None and _anything_untracked(stage, agent) else found


def looks_at(stage: Stage, agent: str, name: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether an agent looks at an object, or at another agent; None where head or thing was not tracked.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    stage.scene.agent(agent)
    check_thing(stage.scene, name, but=agent)
    if not stage.state.known([f"{agent}/head", f"{name}/head" if name in stage.scene.agents else name]):
        return None
    return _gaze(stage, agent, settings).target == name


def mutual_gaze(stage: Stage, one: str, other: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether two agents look at each other; None is unknown.

    Raises:
        UnknownNameError: There is no such agent.
    """
    stage.scene.agent(other)
    return both(looks_at(stage, one, other, settings), looks_at(stage, other, one, settings))


def joint_attention(stage: Stage, one: str, other: str, name: str, settings: Settings = DEFAULT) -> bool | None:
    """Whether two agents look at the same thing; whether they know that of each other no geometry tells.

    Raises:
        UnknownNameError: There is no such agent or thing.
    """
    return both(looks_at(stage, one, name, settings), looks_at(stage, other, name, settings))


def check_thing(scene: Scene, name: str, *, but: str | None = None) -> None:
    """Refuse what is neither an object nor an agent, or the one that is asked about others.

    Raises:
        UnknownNameError: It is so.
    """
    others = {*scene.objects, *scene.agents} - {but}
    if name not in others:
        raise UnknownNameError("other object or agent" if but else "object or agent", name, others)


def _gaze(stage: Stage, agent: str, settings: Settings) -> Gaze:
    """What an agent looks at, among what was tracked."""
    body = stage.scene.agent(agent)
    eye, found = stage.eye_row(body), Gaze(None)
    for name, shapes in _gazed(stage, agent):
        radii_m = stage.scene.model.geom_rbound[shapes]
        off = min(map(off_gaze, (eye,) * len(shapes), stage.geom_centers(shapes), radii_m), default=math.inf)
        nearest = settings.relations.gaze_rad if found.off_rad is None else found.off_rad
        if off > nearest:
            continue
        view = _look(stage, body, shapes, settings)
        if view.makes_out and view.off_rad < nearest:
            found = Gaze(name, view.off_rad)
    return found


def _gazed(stage: Stage, agent: str) -> list[tuple[str, Indices]]:
    """What an agent might look at: tracked objects, and the heads of other agents; each with its shapes."""
    scene, known = stage.scene, stage.state.known
    found = [(name, scene.seen_geoms(name)) for name in scene.objects if known([name])]
    for other in scene.agents:
        if other != agent and known([f"{other}/head"]):
            own = scene.seen_geoms(other)
            head = scene.model.geom_bodyid[own] == scene.agent(other).eye_exclude_body
            found.append((other, own[head]))
    return found


def _anything_untracked(stage: Stage, agent: str) -> bool:
    return len(_gazed(stage, agent)) < len(stage.scene.objects) + len(stage.scene.agents) - 1


# --- Rays from an eye into the narrowest cone that holds all of a thing, each for the same part of the sphere.


@dataclass(frozen=True)
class _Look:
    """What of a thing is in sight: its share, what hides the rest, how near to the gaze, and whether it is enough."""

    share: float
    blockers: tuple[tuple[str, float], ...]
    off_rad: float
    makes_out: bool


def _look(stage: Stage, agent: Agent, shapes: Indices, settings: Settings) -> _Look:
    eye = stage.eye(agent)
    forward = eye.matrix[:, 0]
    centers, radii_m = stage.geom_centers(shapes), stage.scene.model.geom_rbound[shapes]
    count, alone = FIRST_RAYS, np.zeros(0, dtype=np.intp)
    while len(alone) < LEAST_RAYS and count <= MOST_RAYS:
        directions, ray_sr = _cone(eye.position, centers.mean(axis=0), box_corners(stage, shapes), count)
        own, own_m = stage.cast_at(shapes, eye.position, directions)
        alone, count = np.flatnonzero(own >= 0), 4 * count
    directions, own_m = directions[alone], own_m[alone]
    others = np.intersect1d(stage.between(eye.position, centers, radii_m), _hiding(stage, agent, shapes, settings))
    other, other_m = stage.cast_at(others, eye.position, directions)
    visible = own_m <= other_m
    # the gaze itself may meet the thing between two rays
    ahead, ahead_m = stage.cast_at(shapes, eye.position, forward[None])
    _, before_m = stage.cast_at(others, eye.position, forward[None])
    off_rad = 0.0 if ahead[0] >= 0 and ahead_m[0] <= before_m[0] else _nearest_rad(directions[visible], forward)
    hidden = Counter(stage.scene.owners[geom] for geom in other[~visible].tolist())
    most_first = sorted(hidden.items(), key=lambda each: (-each[1], each[0]))
    seen = int(np.count_nonzero(visible))
    return _Look(
        seen / max(len(alone), 1),
        tuple((owner, number / len(alone)) for owner, number in most_first),
        off_rad,
        seen * ray_sr >= settings.vision.least_visible_arcmin2 * SQUARE_ARCMIN_SR,
    )


def _nearest_rad(directions: Array, forward: Array) -> float:
    return float(np.arccos(np.clip(directions @ forward, -1.0, 1.0)).min(initial=math.pi))


def _hiding(stage: Stage, agent: Agent, shapes: Indices, settings: Settings) -> Indices:
    """Seen shapes that are not looked through, but the thing's and those of the agent who looks."""
    hides: Mask = stage.seen & stage.scene.hiding(settings.vision.transparent_alpha)
    hides[shapes] = False
    hides[agent.geoms] = False
    return np.flatnonzero(hides)


def _cone(eye: Array, middle: Array, corners: Array, count: int) -> tuple[Array, float]:
    """Directions that are spread evenly over the cone around a thing, (count, 3), and the steradians of each.

    Where the thing takes more than half of what is around the eye, over the whole sphere.
    """
    axis = normalized(middle - eye)
    least = float((normalized(corners - eye) @ axis).min())
    least = least if least > 0.0 else -1.0
    side = np.cross((0.0, 0.0, 1.0), axis)
    side = normalized(side) if np.linalg.norm(side) > 1e-9 else np.array((0.0, 1.0, 0.0))
    numbers = np.arange(count)
    along = 1.0 - (1.0 - least) * (numbers + 0.5) / count
    around, across = GOLDEN_RAD * numbers, np.sqrt(1.0 - along**2)
    local = np.stack((along, across * np.cos(around), across * np.sin(around)), axis=1)
    return local @ np.stack((axis, side, np.cross(axis, side))), 2 * math.pi * (1.0 - least) / count
