"""Ways to show something: hold it up, put it on top of something, turn it, move away what hides it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from taskgist.demonstrator.furniture import Thing
from taskgist.demonstrator.generator.arrangement import EDGE_M, Arrangement, across
from taskgist.demonstrator.generator.clearing import move_away
from taskgist.demonstrator.generator.furnishing import on_top
from taskgist.demonstrator.generator.outcome import check_before_eyes, check_comes_into_view, check_shown
from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.things import CARTONS, PEDESTALS, PICTURES, SMALL, TALL, any_of, radius_m
from taskgist.demonstrator.generator.turning import turn_towards
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import apart, both, handy, off_the_way
from taskgist.demonstrator.means import Means, hold_up, put_on_top
from taskgist.errors import SceneError

BEFORE_FACE_M = (0.35, 0.55)
"""How far before a face things are held up."""
BEFORE_HIDDEN_M = (0.03, 0.08)
"""Gap between a thing and what hides it at first."""
LEAST_M = 0.52
"""What something stands behind is so far from the performer, at least: room for the thing before it."""
EDGE_ON_RAD = math.radians(8.0)
"""How far a picture that stands edge-on is turned from that, at most."""
ASIDE_RAD = math.radians(30.0)
"""Pictures to be turned stand before the performer."""
NEAR_SHARE = 0.45
"""As ``zones.HANDY_SHARE``: what hides it stands beyond it and must be handy, too."""


def _up(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = arrangement.put(any_of(rng, SMALL), handy(arrangement.performer))
    arrangement.add_distractors(5)
    roles = arrangement.roles(thing, arrangement.hand_for(thing), watches=0.2)
    return arrangement.setting(roles, amounts={"distance": float(rng.uniform(*BEFORE_FACE_M))})


def _held_up(setting: Setting) -> Means:
    return hold_up(setting.roles, distance_m=setting.amounts["distance"])


def _behind_a_pedestal(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    beyond = both(handy(arrangement.performer), apart(arrangement.performer, LEAST_M))
    pedestal = arrangement.put(any_of(rng, PEDESTALS), beyond, yaw_rad=across(arrangement))
    thing = _beyond(arrangement, pedestal, any_of(rng, SMALL, but=TALL))
    arrangement.add_distractors(4, where=off_the_way(arrangement.target, thing))
    roles = arrangement.roles(thing, arrangement.hand_for(thing, pedestal), watches=0.0)
    return arrangement.setting(replace(roles, target_returns_to=thing.name), props={"pedestal": pedestal.name})


def _beyond(arrangement: Arrangement, screen: Thing, thing: Thing) -> Thing:
    """Put a thing right behind another one, as seen by the target agent.

    Raises:
        SceneError: There is no room for it on the table.
    """
    line = np.array(screen.position_m[:2]) - np.array(arrangement.target.position_m)
    radius = radius_m(thing)
    gap = radius + screen.size_m[0] / 2 + arrangement.rng.uniform(*BEFORE_HIDDEN_M)
    place = np.array(screen.position_m) + gap * np.array([*line / np.linalg.norm(line), 0.0])
    if not on_top(arrangement.table, place, radius + EDGE_M):
        raise SceneError(f"no place for {thing.name!r} behind {screen.name!r}", where="room", hint="draw another room")
    return arrangement.put_at(thing, place)


def _on_top(setting: Setting) -> Means:
    return put_on_top(setting.roles, of=setting.props["pedestal"])


def _edge_on(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    before = both(handy(arrangement.performer, aside_rad=ASIDE_RAD), apart(arrangement.performer, 0.40))
    picture = arrangement.put(any_of(rng, PICTURES), before, yaw_rad=0.0)
    x, y = np.array(arrangement.target.position_m) - np.array(picture.position_m[:2])
    edge_on = math.atan2(y, x) + math.pi / 2 + rng.uniform(-EDGE_ON_RAD, EDGE_ON_RAD)
    picture = arrangement.replaced(picture, replace(picture, yaw_rad=edge_on))
    arrangement.add_distractors(4)
    side = str(rng.choice(("left", "right")))
    roles = arrangement.roles(picture, side, watches=0.1)
    return arrangement.setting(replace(roles, target_returns_to=picture.name))


def _turned(setting: Setting) -> Means:
    return turn_towards(setting.roles)


def _behind_a_carton(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    performer = arrangement.performer
    thing = arrangement.put(any_of(rng, SMALL), handy(performer, share=NEAR_SHARE))
    carton = any_of(rng, CARTONS)
    line = np.array(arrangement.target.position_m) - np.array(thing.position_m[:2])
    gap = radius_m(thing) + carton.size_m[0] / 2 + rng.uniform(*BEFORE_HIDDEN_M)
    place = np.array(thing.position_m) + gap * np.array([*line / np.linalg.norm(line), 0.0])
    carton = arrangement.put_at(carton, place, yaw_rad=across(arrangement))
    arrangement.add_distractors(2, where=off_the_way(arrangement.target, thing))
    roles = arrangement.roles(thing, arrangement.hand_for(carton), watches=0.0)
    return arrangement.setting(replace(roles, target_returns_to=thing.name), props={"occluder": carton.name})


def _moved_away(setting: Setting) -> Means:
    return move_away(setting.roles, occluder=setting.props["occluder"])


SHOW = (
    Way("show", "hold-up", _up, _held_up, check_before_eyes),
    Way("show", "on-top", _behind_a_pedestal, _on_top, check_comes_into_view),
    Way("show", "turn", _edge_on, _turned, check_shown),
    Way("show", "move-occluder", _behind_a_carton, _moved_away, check_comes_into_view),
)
