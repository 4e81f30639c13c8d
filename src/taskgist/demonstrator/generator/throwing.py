"""Ways to throw something: into free space, or to the other's side."""

from __future__ import annotations

import math

import numpy as np

from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.rooms import DINING, ROUND, around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import beside, thing_at_hand
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.steps import Withdraw
from taskgist.demonstrator.throwing import Throw

AWAY_M, OUTWARD_RAD = (1.6, 2.6), (math.radians(25.0), math.radians(60.0))
"""How far things are thrown into free space, and how far outward from straight ahead."""
ASIDE_M, AHEAD_M = (0.50, 0.75), (0.0, 0.30)
"""How far to the side of somebody, and before it, what is thrown to it comes down."""
FLIGHT_S = (0.55, 0.80)


def _setting(arrangement: Arrangement, goal: tuple[float, float], setting: Setting) -> Setting:
    flight = {"flight": float(arrangement.rng.uniform(*FLIGHT_S))}
    return arrangement.setting(setting.roles, amounts=flight, places={"goal": (*goal, 0.0)})


def _with_free_space(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND), performer=("standing",))
    setting, person = thing_at_hand(arrangement), arrangement.performer
    away, outward = rng.uniform(*AWAY_M), rng.uniform(*OUTWARD_RAD)
    aside, ahead = float(away * math.sin(outward)), float(away * math.cos(outward))
    return _setting(arrangement, beside(person, setting.roles.side, aside_m=aside, ahead_m=ahead), setting)


def _with_room_beside_the_other(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND), performer=("standing",))
    setting, person = thing_at_hand(arrangement), arrangement.target
    facing = "left" if setting.roles.side == "right" else "right"  # the side that is across from the hand
    aside, ahead = float(rng.uniform(*ASIDE_M)), float(rng.uniform(*AHEAD_M))
    return _setting(arrangement, beside(person, facing, aside_m=aside, ahead_m=ahead), setting)


def _thrown(setting: Setting) -> Means:
    throw = Throw(setting.places["goal"], setting.amounts["flight"])
    return lambda _scene: setting.roles.script("throw", "thrown underarm", throw, Withdraw())


THROW = (
    Way("throw", "into-free-space", _with_free_space, _thrown),
    Way("throw", "to-the-other", _with_room_beside_the_other, _thrown),
)
