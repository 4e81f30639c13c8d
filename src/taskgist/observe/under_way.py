"""What is under way while a task is being performed: cues of one moment, before there is any effect.

A task is known by its effects, and half way there are none yet: the cup still stands where it stood. What tells then
is what is being done. ``cues_at`` looks at the frames up to a moment, never beyond, and says

- what *stage* the handling has come to: nothing is touched, the thing is grasped, carried, let go, or taken;
- whether it is the thing itself that is handled, or another one that comes nearer to it or leaves it;
- how the thing's way compares with where the target agent is: nearer or farther than at the start, whether it moves
  there now, up or down, and whether it goes to where the target agent would no longer see it;
- what the target agent's hands and both agents' eyes do.

All are numbers or words of geometry; none is about any task. What usually follows from such moments is another matter:
see ``recognition.completion``.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from taskgist.common.arrays import Array
from taskgist.observe.attention import gaze
from taskgist.settings import DEFAULT, Settings
from taskgist.world.contacts import hand_gap_m, hand_known
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

Progression = Literal["untouched", "grasped", "carried", "let go", "taken"]
Regard = Literal["thing", "other agent", "other thing", "nothing"]

FARTHEST_M = 0.5
"""Beyond this, gaps between hands and things are not measured."""
LOOK_BACK_S = 0.4
"""Speeds are measured over so long."""
LEAST_S = 1e-3
"""No two frames are nearer to each other."""
AHEAD_S = 0.7
"""Where a thing goes is asked so far ahead."""
AHEAD_M = (0.1, 0.2, 0.35, 0.5, 0.7)
"""How far ahead of a thing it is looked where it may come to."""
GOES_M_S = 0.1
"""What is slower along the floor goes nowhere."""
AT_HAND_M = 0.05
"""A hand that is so near to a thing may hold it."""
DISPLACED_M = 0.03
"""So far from where it was, a thing has been moved."""


@dataclass(frozen=True)
class Cues:
    """What is under way at one moment.

    Attributes:
        stage: What the handling has come to.
        handled: Whether the thing itself is handled, or (False) another one, or (None) nothing yet.
        other_gap_m: Distance of that other thing to the thing now, metres; 0 where there is none.
        other_nearing_m: By how much it has come nearer to the thing since the start; negative: it has left it.
        reach_m: From the performing agent's nearest hand to the thing, metres, up to ``FARTHEST_M``.
        reach_m_s: How fast that gap grows, metres per second.
        distance_m: From the target agent's eyes to the thing, along the floor.
        nearing_m: By how much the thing has come nearer to the target agent since the start.
        nearing_m_s: How fast it does so now.
        own_nearing_m: By how much it has come nearer to the performing agent since the start.
        own_nearing_m_s: How fast it does so now.
        rise_m: By how much it is higher than at the start.
        rise_m_s: How fast it rises now.
        target_hand_m: From the target agent's nearest hand to the thing, up to ``FARTHEST_M``.
        target_hand_m_s: How fast that gap grows.
        blocked: Whether something stands between the target agent's eyes and the thing's middle.
        blocked_ahead: Whether something will, if the thing goes on as it goes.
        hidden_ahead: Of the places where the thing may come to, as high as it was at the start, the share that is
            hidden from the target agent: those ahead of it; all around it, while it does not move along the floor.
        performer_regards: What the performing agent looks at.
        target_regards: What the target agent looks at.
    """

    stage: Progression
    handled: bool | None
    other_gap_m: float
    other_nearing_m: float
    reach_m: float
    reach_m_s: float
    distance_m: float
    nearing_m: float
    nearing_m_s: float
    own_nearing_m: float
    own_nearing_m_s: float
    rise_m: float
    rise_m_s: float
    target_hand_m: float
    target_hand_m_s: float
    blocked: bool
    blocked_ahead: bool
    hidden_ahead: float
    performer_regards: Regard
    target_regards: Regard

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)


@dataclass(frozen=True)
class _Look:
    """Geometry of one frame."""

    places: dict[str, Array]
    performer: Array
    target: Array
    own_gap_m: float
    target_gap_m: float


def cues_at(
    scene: Scene,
    first: State,
    before: State,
    now: State,
    *,
    performing_agent: str,
    target_agent: str,
    thing: str,
    settings: Settings = DEFAULT,
) -> Cues | None:
    """What is under way at a moment, from the frames up to it.

    Args:
        scene: The scene.
        first: The state in which what is done begins.
        before: The state ``LOOK_BACK_S`` before the moment, or the first one.
        now: The state at the moment.
        performing_agent: Who does it.
        target_agent: For whom it may be.
        thing: With what.
        settings: What is looked through, and what is looked at.

    Returns:
        None where one of them is not tracked at the start or now.
    """
    stage, looks = Stage(scene), list[_Look]()
    for state in (first, before, now):
        stage.show(state)
        if not stage.state.known([thing, f"{performing_agent}/head", f"{target_agent}/head"]):
            return None
        looks.append(_look(stage, performing_agent, target_agent, thing))
    return _cues(
        stage, looks, max(now.time_s - before.time_s, LEAST_S), performing_agent, target_agent, thing, settings
    )


def nearest_hand_m(stage: Stage, agent: str, name: str) -> float | None:
    """From an agent's nearest hand to an object, metres; None if no hand, or not the object, was tracked."""
    body = stage.scene.agent(agent)
    if not stage.state.known([name]):
        return None
    gaps = [hand_gap_m(stage, arm, name, limit_m=FARTHEST_M) for arm in body.arms if hand_known(stage, body, arm)]
    return max(min(gaps), 0.0) if gaps else None


def _cues(
    stage: Stage,
    looks: list[_Look],
    since_s: float,
    performing_agent: str,
    target_agent: str,
    thing: str,
    settings: Settings,
) -> Cues:
    """The cues of the last of three frames, which the stage shows."""
    first, before, now = looks
    other = _other_moved(stage, first, now, thing, performing_agent)
    what = _stage_of(first, now, thing, other)
    here, there = now.places[thing], before.places[thing]
    velocity = (here - there) / since_s
    other_gap, other_nearing = 0.0, 0.0
    if other is not None and what[1] is False:
        other_gap = _apart(now.places[other], here)
        other_nearing = _apart(first.places[other], first.places[thing]) - other_gap
    ahead = _places_ahead(here, velocity, float(first.places[thing][2]))
    blocked = _blocked(stage, target_agent, thing, np.vstack((here, here + AHEAD_S * velocity, ahead)), settings)
    eyes = {agent: _regards(stage, agent, thing, settings) for agent in (performing_agent, target_agent)}
    return Cues(
        stage=what[0],
        handled=what[1],
        other_gap_m=other_gap,
        other_nearing_m=other_nearing,
        reach_m=now.own_gap_m,
        reach_m_s=(now.own_gap_m - before.own_gap_m) / since_s,
        distance_m=_apart(now.target, here),
        nearing_m=_apart(first.target, first.places[thing]) - _apart(now.target, here),
        nearing_m_s=(_apart(before.target, there) - _apart(now.target, here)) / since_s,
        own_nearing_m=_apart(first.performer, first.places[thing]) - _apart(now.performer, here),
        own_nearing_m_s=(_apart(before.performer, there) - _apart(now.performer, here)) / since_s,
        rise_m=float(here[2] - first.places[thing][2]),
        rise_m_s=float(velocity[2]),
        target_hand_m=now.target_gap_m,
        target_hand_m_s=(now.target_gap_m - before.target_gap_m) / since_s,
        blocked=blocked[0],
        blocked_ahead=blocked[1],
        hidden_ahead=float(np.mean(blocked[2:])),
        performer_regards=eyes[performing_agent],
        target_regards=eyes[target_agent],
    )


def _look(stage: Stage, performer: str, target: str, thing: str) -> _Look:
    scene = stage.scene
    places = {
        name: np.array(stage.geom_centers(scene.seen_geoms(name)).mean(axis=0))
        for name in scene.objects
        if stage.state.known([name])
    }
    gaps = (nearest_hand_m(stage, agent, thing) for agent in (performer, target))
    own, others = (FARTHEST_M if gap is None else min(gap, FARTHEST_M) for gap in gaps)
    own_eye, other_eye = (np.array(stage.eye(scene.agent(agent)).position) for agent in (performer, target))
    return _Look(places, own_eye, other_eye, own, others)


def _stage_of(first: _Look, now: _Look, thing: str, other: str | None) -> tuple[Progression, bool | None]:
    """What the handling has come to, and whether it is the thing itself that is handled."""
    displaced = float(np.linalg.norm(now.places[thing] - first.places[thing])) > DISPLACED_M
    if now.target_gap_m < AT_HAND_M and (displaced or now.own_gap_m < AT_HAND_M):
        return "taken", True
    if now.own_gap_m < AT_HAND_M:
        return ("carried" if displaced else "grasped"), True
    if displaced:
        return "let go", True
    if other is not None:
        return "carried", False
    return "untouched", None


def _other_moved(stage: Stage, first: _Look, now: _Look, thing: str, performer: str) -> str | None:
    """The other thing that has been moved farthest; else the one that the performing agent has a hand at."""
    moved = {
        name: float(np.linalg.norm(place - first.places[name]))
        for name, place in now.places.items()
        if name != thing and name in first.places
    }
    farthest = max(moved, key=lambda name: moved[name], default=None)
    if farthest is not None and moved[farthest] > DISPLACED_M:
        return farthest
    gaps = {name: nearest_hand_m(stage, performer, name) for name in moved}
    near = {name: gap for name, gap in gaps.items() if gap is not None and gap < AT_HAND_M}
    return min(near, key=lambda name: near[name], default=None)


def _apart(one: Array, other: Array) -> float:
    """Distance along the floor, metres."""
    return math.hypot(*(one - other)[:2].tolist())


def _places_ahead(here: Array, velocity: Array, height_m: float) -> Array:
    """Places where a thing may come to, metres, (n, 3): ahead of it, or all around it where it goes nowhere."""
    goes = math.hypot(*velocity[:2].tolist()) > GOES_M_S
    towards = math.atan2(velocity[1], velocity[0]) if goes else 0.0
    turns = np.radians((-30.0, 0.0, 30.0)) if goes else np.radians(np.arange(0.0, 360.0, 30.0))
    ways = np.array(AHEAD_M if goes else AHEAD_M[:3])
    along, turn = (each.ravel() for each in np.meshgrid(ways, towards + turns))
    return np.stack(
        (here[0] + along * np.cos(turn), here[1] + along * np.sin(turn), np.full(len(along), height_m)), axis=1
    )


def _blocked(stage: Stage, agent: str, thing: str, places: Array, settings: Settings) -> list[bool]:
    """Whether something stands between an agent's eyes and each place, but for agents and the thing itself."""
    scene = stage.scene
    body = scene.agent(agent)
    eye = np.array(stage.eye(body).position)
    ways = places - eye
    lengths_m = np.linalg.norm(ways, axis=1)
    hides = stage.seen & scene.hiding(settings.vision.transparent_alpha)
    hides[scene.seen_geoms(thing)] = False
    for each in scene.agents:
        hides[scene.agent(each).geoms] = False
    _, hit_m = stage.cast_at(np.flatnonzero(hides), eye, ways / np.maximum(lengths_m, 1e-9)[:, None])
    return [bool(hit < length) for hit, length in zip(hit_m, lengths_m, strict=True)]


def _regards(stage: Stage, agent: str, thing: str, settings: Settings) -> Regard:
    found = gaze(stage, agent, settings)
    if found is None or found.target is None:
        return "nothing"
    if found.target == thing:
        return "thing"
    return "other agent" if found.target in stage.scene.agents else "other thing"
