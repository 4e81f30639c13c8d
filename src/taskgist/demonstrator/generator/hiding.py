"""Ways to hide something: behind something, inside something, under a cover, behind the own back."""

from __future__ import annotations

import numpy as np

from taskgist.demonstrator.generator.arrangement import across
from taskgist.demonstrator.generator.behind_back import hold_behind_back
from taskgist.demonstrator.generator.competence import check_stands
from taskgist.demonstrator.generator.hiding_places import put_inside, put_under
from taskgist.demonstrator.generator.outcome import check_hidden, check_seen_before
from taskgist.demonstrator.generator.rooms import DINING, HIGH, LOW, ROUND, around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.sight import seen_first
from taskgist.demonstrator.generator.things import COVERABLE, OCCLUDERS, SMALL, TALL, any_of, bin_of, cover_for
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import apart, both, handy, off_the_way
from taskgist.demonstrator.means import Means, put_behind
from taskgist.recording import Recording

OFF_M = 0.26
"""How far it is from the ways of arms and of sight to where the thing is before."""
LEAST_M = 0.55
"""What something is hidden behind is so far from the performer, at least: room for the thing and a hand before it."""


def _with_an_occluder(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    acting, watching = arrangement.performer, arrangement.target
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), handy(acting))
    off = (off_the_way(person, thing, least_m=OFF_M) for person in (acting, watching))
    beyond = both(handy(acting), apart(acting, LEAST_M), *off)
    occluder = arrangement.put(any_of(rng, OCCLUDERS), beyond, yaw_rad=across(arrangement))
    arrangement.add_distractors(4, where=off_the_way(acting, thing, occluder))
    roles = arrangement.roles(thing, arrangement.hand_past(occluder, thing), watches=0.5)
    return arrangement.setting(roles, props={"occluder": occluder.name})


def _behind(setting: Setting) -> Means:
    return seen_first(setting.roles, put_behind(setting.roles, occluder=setting.props["occluder"]))


def _with_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, LOW), target=("sitting",))  # who stands looks into it
    near = handy(arrangement.performer)
    container = arrangement.put(bin_of(rng), near)
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), near)
    arrangement.add_distractors(3)
    roles = arrangement.roles(thing, arrangement.hand_for(thing, container), watches=0.5)
    return arrangement.setting(roles, props={"container": container.name})


def _inside(setting: Setting) -> Means:
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


def check_put_out_of_view(recording: Recording) -> None:
    """As ``check_from_view_to_hidden``, of what has been put down.

    Raises:
        SceneError: So it is, or the thing would fall.
    """
    check_from_view_to_hidden(recording)
    check_stands(recording)


HIDE = (
    Way("hide", "behind", _with_an_occluder, _behind, check_put_out_of_view),
    Way("hide", "inside", _with_a_bin, _inside, check_from_view_to_hidden),
    Way("hide", "under-cover", _with_a_cover, _under, check_from_view_to_hidden),
    Way("hide", "behind-back", _standing, _behind_the_back, check_from_view_to_hidden),
)
