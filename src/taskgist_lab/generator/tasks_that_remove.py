"""Ways to hide something, to put it away, and to hide it away."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.recording.recording import Recording
from taskgist_lab.generator.arrangement import Arrangement, Setting, across, apart, both, handy, nearer_to, off_the_way
from taskgist_lab.generator.furnishing import distance_m
from taskgist_lab.generator.hiding_means import (
    hold_behind_back,
    put_inside,
    put_on_board,
    put_on_side_table,
    put_under,
    shelf_beside,
    side_table_beside,
)
from taskgist_lab.generator.outcomes import (
    check_farther,
    check_hidden,
    check_keeps_distance,
    check_seen_before,
    check_shown,
    check_stands,
    seen_first,
)
from taskgist_lab.generator.rooms import DINING, HIGH, LOW, ROUND, around_a_table
from taskgist_lab.generator.things import COVERABLE, OCCLUDERS, SMALL, TALL, any_of, at, bin_of, cover_for, radius_m
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.means import Means, Roles, put_behind, put_behind_far, put_far_from
from taskgist_lab.simulator.room import Thing

# --- Ways to hide something: behind something, inside something, under a cover, behind the own back.

OFF_M = 0.26
"""How far it is from the ways of arms and of sight to where the thing is before."""
HIDING_LEAST_M = 0.55
"""What something is hidden behind is so far from the performer, at least: room for the thing and a hand before it."""


BEFORE_IT_M = (0.10, 0.40)
"""How much nearer to the target agent than the thing it stands: so the thing behind it is hardly farther off."""


def _hiding_with_an_occluder(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    acting, watching = arrangement.performer, arrangement.target
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), handy(acting))
    off = (off_the_way(person, thing, least_m=OFF_M) for person in (acting, watching))
    reached = distance_m(watching, np.array(thing.position_m))
    same = apart(watching, reached - BEFORE_IT_M[1], reached - BEFORE_IT_M[0])
    beyond = both(handy(acting), apart(acting, HIDING_LEAST_M), same, *off)
    occluder = arrangement.put(any_of(rng, OCCLUDERS), beyond, yaw_rad=across(arrangement))
    arrangement.add_distractors(4, where=off_the_way(acting, thing, occluder))
    roles = arrangement.roles(thing, arrangement.hand_past(occluder, thing), watches=0.5)
    return arrangement.setting(roles, props={"occluder": occluder.name})


def _hiding_behind(setting: Setting) -> Means:
    return seen_first(setting.roles, put_behind(setting.roles, occluder=setting.props["occluder"]))


def _hiding_with_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, LOW), target=("sitting",))  # who stands looks into it
    near = handy(arrangement.performer)
    container = arrangement.put(bin_of(rng), near)
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), near)
    arrangement.add_distractors(3)
    roles = arrangement.roles(thing, arrangement.hand_for(thing, container), watches=0.5)
    return arrangement.setting(roles, props={"container": container.name})


def _hiding_inside(setting: Setting) -> Means:
    return seen_first(setting.roles, put_inside(setting.roles, "hide", container=setting.props["container"]))


def _with_a_cover(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = arrangement.put(any_of(rng, COVERABLE), handy(arrangement.performer))
    cover = arrangement.put(cover_for(rng, thing), handy(arrangement.performer))
    arrangement.add_distractors(4)
    roles = arrangement.roles(thing, arrangement.hand_for(thing, cover), watches=0.5)
    return arrangement.setting(roles, props={"cover": cover.name})


def _under(setting: Setting) -> Means:
    return seen_first(setting.roles, put_under(setting.roles, cover=setting.props["cover"]))


def _standing(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), handy(arrangement.performer))
    arrangement.add_distractors(5)
    return arrangement.setting(arrangement.roles(thing, arrangement.hand_for(thing), watches=0.5))


def _behind_the_back(setting: Setting) -> Means:
    return seen_first(setting.roles, hold_behind_back(setting.roles))


def check_from_view_to_hidden(recording: Recording) -> None:
    """Refuse a demonstration in which the thing was not in view before, or is so in the end.

    Raises:
        SceneError: So it is.
    """
    check_seen_before(recording)
    check_hidden(recording)


def check_hidden_at_hand(recording: Recording) -> None:
    """As ``check_from_view_to_hidden``, of what keeps its distance from the target agent.

    Raises:
        SceneError: It is farther off in the end, or what that check finds.
    """
    check_from_view_to_hidden(recording)
    check_keeps_distance(recording)


def check_put_out_of_view(recording: Recording) -> None:
    """As ``check_from_view_to_hidden``, of what has been put down.

    Raises:
        SceneError: So it is, or the thing would fall.
    """
    check_from_view_to_hidden(recording)
    check_stands(recording)


def check_put_behind(recording: Recording) -> None:
    """As ``check_hidden_at_hand``, of what has been put down.

    Raises:
        SceneError: So it is, or the thing would fall.
    """
    check_hidden_at_hand(recording)
    check_stands(recording)


HIDE = (
    Way("hide", "behind", _hiding_with_an_occluder, _hiding_behind, check_put_behind),
    Way("hide", "inside", _hiding_with_a_bin, _hiding_inside, check_hidden_at_hand),
    Way("hide", "under-cover", _with_a_cover, _under, check_from_view_to_hidden),
    Way("hide", "behind-back", _standing, _behind_the_back, check_from_view_to_hidden),
)

# --- Ways to put something away: to a far place on the table, on a table at the side, into a shelf.

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


def _with_boards(rng: np.random.Generator, *, closed: bool) -> Setting:
    """A shelf beside the performer, or a cupboard if it is closed; the other is busy where the thing stays in view."""
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    thing = near_the_other(arrangement, distractors=4)
    side = str(rng.choice(("left", "right")))
    boards, place = shelf_beside(arrangement, side, closed=closed)
    arrangement.furniture.append(boards)
    roles = arrangement.roles(thing, side, watches=0.5) if closed else busy_roles(arrangement, thing, side)
    return arrangement.setting(roles, amounts={"front": boards.yaw_rad}, places={"board": place})


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
    Way("put away", "shelf", partial(_with_boards, closed=False), _put_in_shelf, check_away_in_view),
)


# --- Ways to hide something away: far and behind something, far and inside something, in a cupboard.

HIDING_AWAY_LEAST_M = 0.52
"""What something is hidden behind is so far from the performer, at least."""


def _hiding_away_with_an_occluder(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    performer = arrangement.performer
    beyond = both(
        handy(performer), apart(performer, HIDING_AWAY_LEAST_M), nearer_to(performer, arrangement.target, by_m=-0.1)
    )
    occluder = arrangement.put(any_of(rng, OCCLUDERS), beyond, yaw_rad=across(arrangement))
    thing = near_the_other(arrangement, occluder, distractors=3, but=TALL)
    roles = arrangement.roles(thing, arrangement.hand_past(occluder, thing), watches=0.5)
    return arrangement.setting(roles, props={"occluder": occluder.name})


def _hiding_away_behind(setting: Setting) -> Means:
    return seen_first(setting.roles, put_behind_far(setting.roles, occluder=setting.props["occluder"]))


def _hiding_away_with_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, LOW), target=("sitting",))  # who stands looks into it
    performer = arrangement.performer
    near = both(handy(performer, share=REACHED_SHARE), nearer_to(performer, arrangement.target))
    container = arrangement.put(bin_of(rng), near)
    thing = near_the_other(arrangement, container, distractors=3, but=TALL)
    roles = arrangement.roles(thing, arrangement.hand_for(thing, container), watches=0.5)
    return arrangement.setting(roles, props={"container": container.name})


def _hiding_away_inside(setting: Setting) -> Means:
    return seen_first(setting.roles, put_inside(setting.roles, "hide away", container=setting.props["container"]))


def _in_cupboard(setting: Setting) -> Means:
    return seen_first(setting.roles, put_on_board(setting, "hide away", hidden=True))


def check_away_and_hidden(recording: Recording) -> None:
    """Refuse a demonstration that does not take the thing farther off and out of view.

    Raises:
        SceneError: So it is.
    """
    check_put_out_of_view(recording)
    check_farther(recording)


HIDE_AWAY = (
    Way("hide away", "far-behind", _hiding_away_with_an_occluder, _hiding_away_behind, check_away_and_hidden),
    Way("hide away", "far-inside", _hiding_away_with_a_bin, _hiding_away_inside, check_away_and_hidden),
    Way("hide away", "cupboard", partial(_with_boards, closed=True), _in_cupboard, check_away_and_hidden),
)
