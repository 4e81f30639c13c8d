"""Ways to move something for nobody: to elsewhere on the table, closer to oneself, or onto something that stands there.

Most of what people do with their hands is of this kind. What is meant for another stands out against it.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from taskgist.world.stage import Stage
from taskgist_lab.generator.arrangement import Setting, apart, both, free_place, handy, thing_at_hand
from taskgist_lab.generator.furnishing import distance_m
from taskgist_lab.generator.outcomes import check_stands
from taskgist_lab.generator.rooms import around_a_table
from taskgist_lab.generator.things import PEDESTALS, SMALL, any_of, radius_m
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.means import Means
from taskgist_lab.simulator.places import on_top

CLOSER_M = 0.08
"""How much closer to the performer's pelvis something is drawn, at least."""


def _with_a_free_place(rng: np.random.Generator, *, closer: bool) -> Setting:
    arrangement = around_a_table(rng)
    thing, performer = any_of(rng, SMALL), arrangement.performer
    roles = thing_at_hand(arrangement, thing).roles
    (lies,) = (np.array(each.position_m) for each in arrangement.things if each.name == roles.thing)
    where = handy(performer)
    if closer:
        where = both(where, apart(performer, 0.0, distance_m(performer, lies) - CLOSER_M))
    x, y, z = (float(value) for value in free_place(arrangement, where, radius_m=radius_m(thing)))
    return arrangement.setting(roles, places={"goal": (x, y, z)})


def _put_there(setting: Setting, *, words: str) -> Means:
    return setting.roles.putting("move", words, lambda _scene: setting.places["goal"])


def _beside_a_pedestal(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    pedestal = arrangement.put(any_of(rng, PEDESTALS), handy(arrangement.performer))
    return arrangement.setting(thing_at_hand(arrangement).roles, props={"pedestal": pedestal.name})


def _put_onto(setting: Setting) -> Means:
    pedestal = setting.props["pedestal"]
    return setting.roles.putting("move", f"put onto {pedestal}", lambda scene: on_top(Stage(scene), pedestal))


MOVE = (
    Way(
        "move",
        "elsewhere",
        partial(_with_a_free_place, closer=False),
        partial(_put_there, words="put elsewhere"),
        check_stands,
    ),
    Way(
        "move",
        "closer",
        partial(_with_a_free_place, closer=True),
        partial(_put_there, words="drawn closer"),
        check_stands,
    ),
    Way("move", "onto", _beside_a_pedestal, _put_onto, check_stands),
)
