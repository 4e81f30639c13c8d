"""Offering: means of making something accessible, and of giving it."""

from __future__ import annotations

from dataclasses import replace

from taskgist.demonstrator.handing import HandOver, LayHand
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.nearness import held_out, near
from taskgist.demonstrator.places import on_top
from taskgist.demonstrator.putting import Place
from taskgist.demonstrator.script import Script
from taskgist.demonstrator.steps import HoldUp, Withdraw
from taskgist.world import Scene, Stage


def put_within_reach(roles: Roles, *, distance_m: float) -> Means:
    """Make accessible by putting near the target agent, at a horizontal distance from its shoulders."""

    def place(scene: Scene) -> Place:
        return near(scene, roles.thing, roles.performer, roles.target, distance_m)

    return roles.putting("make accessible", f"put {distance_m:g} m before the shoulders", place)


def lift_onto(roles: Roles, *, of: str) -> Means:
    """Make accessible by putting on top of something that stands near the target agent, where hands are."""
    return roles.putting("make accessible", f"lifted onto {of}", lambda scene: on_top(Stage(scene), of))


def hand_over(
    roles: Roles, *, taking: str, distance_m: float, rests_m: tuple[float, float, float] | None = None
) -> Means:
    """Give by holding out, for the target agent to take it.

    Args:
        roles: Who does it.
        taking: The taking hand.
        distance_m: Distance from the taker's shoulder at which it is held out.
        rests_m: Where the taking hand lies on a table before, (3,); None: it is at rest like the other one.
    """

    def script(scene: Scene) -> Script:
        place = held_out(scene, roles, taking, distance_m)
        steps = (HoldUp(place, 0.0), HandOver(taking), Withdraw())
        plain = roles.script("give", f"handed over to the {taking} hand", *steps)
        if rests_m is None:
            return plain
        return replace(plain, steps=(LayHand(roles.target, taking, rests_m), *plain.steps))

    return script
