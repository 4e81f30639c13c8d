"""Ways to give something: taken from the table, or held already, to the left or the right hand."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import before_chest, free_place, lifted, thing_at_hand
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import handy
from taskgist.demonstrator.holding import Held
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.offering import hand_over
from taskgist.demonstrator.putting import Place
from taskgist.demonstrator.script import Script, Step
from taskgist.demonstrator.steps import HoldUp, Take
from taskgist.world import Scene, Stage

DISTANCES_M = (0.42, 0.60)
"""How far from the taker's shoulder something is held out."""
BEFORE_M, BELOW_M = (0.26, 0.36), (0.02, 0.14)
"""How far before the shoulders, and below them, the giver holds something at first."""
RESTS_SHARE = 0.25
"""How often the taking hand lies on the table before."""
HAND_M, LAID_SHARE = 0.04, 0.33
"""Radius of the free place on which a hand lies, and how far it is from the pelvis, at most, as a share of stature."""


def _room(rng: np.random.Generator, *, taking: str) -> Setting:
    """A room in which something is given with the hand of the same name: so the palms face each other."""
    arrangement = around_a_table(rng, robots=False)  # which take nothing
    roles = replace(thing_at_hand(arrangement).roles, side=taking)
    limits = {"distance": DISTANCES_M, "before": BEFORE_M, "below": BELOW_M}
    amounts = {name: float(rng.uniform(*both)) for name, both in limits.items()}
    places: dict[str, Place] = {}
    if rng.random() < RESTS_SHARE:
        x, y, z = free_place(arrangement, handy(arrangement.target, share=LAID_SHARE), radius_m=HAND_M)
        places["rests"] = (float(x), float(y), float(z))
    return arrangement.setting(roles, amounts=amounts, places=places)


def _handed_over(setting: Setting, *, taking: str) -> Means:
    """Take it from the table and hand it over, well above the table."""
    roles, rests = setting.roles, setting.places.get("rests")
    plain = hand_over(roles, taking=taking, distance_m=setting.amounts["distance"], rests_m=rests)

    def script(scene: Scene) -> Script:
        stage, found = Stage(scene), plain(scene)
        return replace(found, steps=tuple(_raised(stage, roles.thing, step) for step in found.steps))

    return script


def _raised(stage: Stage, thing: str, step: Step) -> Step:
    """The step, but the thing is held out clear of the table and of what stands on it."""
    return replace(step, place_m=lifted(stage, thing, step.place_m)) if isinstance(step, HoldUp) else step


def _from_the_hand(setting: Setting, *, taking: str) -> Means:
    """Hand over what is held already."""
    roles, amounts = setting.roles, setting.amounts

    def script(scene: Scene) -> Script:
        place = before_chest(scene, roles, before_m=amounts["before"], below_m=amounts["below"])
        taken = _handed_over(setting, taking=taking)(scene)
        held = Held(roles.thing, roles.side, place)
        steps = tuple(held if isinstance(step, Take) else step for step in taken.steps)
        return replace(taken, steps=steps, means=f"held already, {taken.means}")

    return script


GIVE = tuple(
    Way("give", f"{start}to-the-{taking}-hand", partial(_room, taking=taking), partial(means, taking=taking))
    for start, means in (("", _handed_over), ("from-the-hand-", _from_the_hand))
    for taking in ("left", "right")
)
