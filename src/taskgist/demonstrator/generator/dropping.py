"""Ways to drop something: onto the table, or beside oneself to the floor."""

from __future__ import annotations

import numpy as np

from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import beside, free_place, thing_at_hand
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import handy
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.steps import HoldUp, Withdraw
from taskgist.demonstrator.throwing import LetFall

ASIDE_M, AHEAD_M = (0.40, 0.52), (0.05, 0.20)
"""How far to the hand's side of the pelvis, and before it, something falls to the floor."""
HELD_SHARE = {"sitting": (0.50, 0.62), "standing": (0.60, 0.76)}
"""How high it is held above the floor, as shares of the stature."""
ABOVE_TABLE_M = (0.55, 0.75)
"""How high it is held above the table that it falls onto."""
NEAR_SHARE = 0.38
"""How far from the pelvis it is dropped onto the table, at most, as a share of the stature."""
ROOM_M = 0.08
"""Radius of the free circle onto which it falls."""
HELD_S = 0.3
"""How long it is held still before it falls."""


def _over_the_floor(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles, person = thing_at_hand(arrangement).roles, arrangement.performer
    x, y = beside(person, roles.side, aside_m=rng.uniform(*ASIDE_M), ahead_m=rng.uniform(*AHEAD_M))
    height = person.stature_m * float(rng.uniform(*HELD_SHARE[person.posture]))
    return arrangement.setting(roles, places={"held": (x, y, height)})


def _over_the_table(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, performer=("standing",))
    roles = thing_at_hand(arrangement).roles
    near = handy(arrangement.performer, share=NEAR_SHARE)
    x, y, z = (float(value) for value in free_place(arrangement, near, radius_m=ROOM_M))
    return arrangement.setting(roles, places={"held": (x, y, z + float(rng.uniform(*ABOVE_TABLE_M)))})


def _dropped(setting: Setting) -> Means:
    steps = (HoldUp(setting.places["held"], HELD_S), LetFall(dropped=True), Withdraw())
    return lambda _scene: setting.roles.script("drop", "held up and dropped", *steps)


DROP = (
    Way("drop", "to-the-floor", _over_the_floor, _dropped),
    Way("drop", "onto-the-table", _over_the_table, _dropped),
)
