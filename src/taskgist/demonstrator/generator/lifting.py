"""Ways to lift something: up from where it stands, or to before the chest."""

from __future__ import annotations

import numpy as np

from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import before_chest, thing_at_hand
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.means import HELD_S, Means
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import HoldUp
from taskgist.world import Scene, Stage

HEIGHTS_M = (0.18, 0.40)
"""How high things are lifted above where they stand."""
BEFORE_M, BELOW_M = (0.30, 0.42), (0.02, 0.18)
"""How far before the shoulders, and below them, something is held before the chest."""


def _up_from_the_table(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles = thing_at_hand(arrangement).roles
    return arrangement.setting(roles, amounts={"height": float(rng.uniform(*HEIGHTS_M))})


def _before_the_chest(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles = thing_at_hand(arrangement).roles
    amounts = {"before": float(rng.uniform(*BEFORE_M)), "below": float(rng.uniform(*BELOW_M))}
    return arrangement.setting(roles, amounts=amounts)


def _lifted(setting: Setting) -> Means:
    roles = setting.roles

    def script(scene: Scene) -> Script:
        x, y, z = Stage(scene).body_position(scene.object_body(roles.thing))
        place = (float(x), float(y), float(z) + setting.amounts["height"])
        return roles.script("lift", "lifted straight up", HoldUp(place, HELD_S))

    return script


def _drawn_near(setting: Setting) -> Means:
    roles, amounts = setting.roles, setting.amounts

    def script(scene: Scene) -> Script:
        place = before_chest(scene, roles, before_m=amounts["before"], below_m=amounts["below"])
        return roles.script("lift", "lifted to before the chest", HoldUp(place, HELD_S))

    return script


LIFT = (
    Way("lift", "straight-up", _up_from_the_table, _lifted),
    Way("lift", "to-the-chest", _before_the_chest, _drawn_near),
)
