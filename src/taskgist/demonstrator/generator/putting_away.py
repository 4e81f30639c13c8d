"""Ways to put something away: to a far place on the table, on a table at the side, into a shelf."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.furniture import Thing
from taskgist.demonstrator.generator.arrangement import Arrangement
from taskgist.demonstrator.generator.aside import put_on_board, put_on_side_table, shelf_beside, side_table_beside
from taskgist.demonstrator.generator.competence import check_stands
from taskgist.demonstrator.generator.outcome import check_farther, check_seen_before, check_shown
from taskgist.demonstrator.generator.people import distance_m
from taskgist.demonstrator.generator.rooms import DINING, HIGH, ROUND, around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.sight import seen_first
from taskgist.demonstrator.generator.things import SMALL, any_of, at, radius_m
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import both, handy, nearer_to, off_the_way
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.removing import put_far_from
from taskgist.recording import Recording

Array = NDArray[np.float64]

FARTHER_M = (0.30, 0.55)
"""How much farther from the target agent something is put."""
NEARER_M = 0.05
"""How much nearer to the target agent a thing is than what it will be hidden behind or in."""
ARM_M = 0.10
"""Room for an arm beside what stands near its way."""
WATCHES = 0.5
"""How often the target agent watches the thing from the beginning on."""
REACHED_SHARE = 0.58
"""As ``zones.HANDY_SHARE``, for what one leans over the table for."""


def near_the_other(
    arrangement: Arrangement, *obstacles: Thing, distractors: int, but: frozenset[str] = frozenset()
) -> Thing:
    """A thing nearer to the target agent than to the performer, which gets to it, and others around it.

    Args:
        arrangement: The room.
        obstacles: What stands there already and shall not be in the way.
        distractors: How many others, at most.
        but: Kinds of things that will not do.
    """
    performer, target = arrangement.performer, arrangement.target
    thing = any_of(arrangement.rng, SMALL, but=but)

    def passes(place: Array) -> bool:
        """Nearer to the target agent than all obstacles, which are not in the way to it."""
        lying = at(thing, place, 0.0)
        return all(
            off_the_way(performer, lying, least_m=radius_m(each) + ARM_M)(np.array(each.position_m))
            and distance_m(target, place) + NEARER_M < distance_m(target, np.array(each.position_m))
            for each in obstacles
        )

    reached = both(handy(performer, share=REACHED_SHARE), nearer_to(target, performer), passes)
    thing = arrangement.put(thing, reached)
    arrangement.add_distractors(distractors, where=off_the_way(performer, thing))
    return thing


def busy_roles(arrangement: Arrangement, thing: Thing, side: str) -> Roles:
    """Who acts; a target agent that did not watch the thing looks back at what it was busy with once it rests."""
    roles = arrangement.roles(thing, side, watches=WATCHES)
    if roles.target_watches == thing.name:
        return roles
    return replace(roles, target_returns_to=roles.target_watches or roles.performer)


def _far(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = near_the_other(arrangement, distractors=4)
    distance = distance_m(arrangement.target, np.array(thing.position_m)) + float(rng.uniform(*FARTHER_M))
    roles = busy_roles(arrangement, thing, arrangement.hand_for(thing))
    return arrangement.setting(roles, amounts={"distance": round(distance, 3)})


def _put_far(setting: Setting) -> Means:
    return seen_first(setting.roles, put_far_from(setting.roles, distance_m=setting.amounts["distance"]))


def _with_a_side_table(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    thing = near_the_other(arrangement, distractors=4)
    side = str(rng.choice(("left", "right")))
    table = side_table_beside(arrangement, side)
    arrangement.furniture.append(table)
    roles = busy_roles(arrangement, thing, side)
    return arrangement.setting(roles, props={"table": table.name})


def _put_aside(setting: Setting) -> Means:
    return seen_first(setting.roles, put_on_side_table(setting, "put away"))


def _with_a_shelf(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    thing = near_the_other(arrangement, distractors=4)
    side = str(rng.choice(("left", "right")))
    shelf, place = shelf_beside(arrangement, side, closed=False)
    arrangement.furniture.append(shelf)
    roles = busy_roles(arrangement, thing, side)
    return arrangement.setting(roles, amounts={"front": shelf.yaw_rad}, places={"board": place})


def _put_in_shelf(setting: Setting) -> Means:
    return seen_first(setting.roles, put_on_board(setting, "put away", hidden=False))


def check_away_in_view(recording: Recording) -> None:
    """Refuse a demonstration that does not take the thing farther off, or that takes it out of view.

    Raises:
        SceneError: So it is.
    """
    check_seen_before(recording)
    check_shown(recording)
    check_farther(recording)
    check_stands(recording)


PUT_AWAY = (
    Way("put away", "far-on-table", _far, _put_far, check_away_in_view),
    Way("put away", "side-table", _with_a_side_table, _put_aside, check_away_in_view),
    Way("put away", "shelf", _with_a_shelf, _put_in_shelf, check_away_in_view),
)
