"""Ways to hide something away: far and behind something, far and inside something, in a cupboard."""

from __future__ import annotations

import numpy as np

from taskgist.demonstrator.generator.arrangement import across
from taskgist.demonstrator.generator.aside import put_on_board, shelf_beside
from taskgist.demonstrator.generator.hiding import check_put_out_of_view
from taskgist.demonstrator.generator.hiding_places import put_inside
from taskgist.demonstrator.generator.outcome import check_farther
from taskgist.demonstrator.generator.putting_away import REACHED_SHARE, near_the_other
from taskgist.demonstrator.generator.rooms import DINING, HIGH, LOW, ROUND, around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.sight import seen_first
from taskgist.demonstrator.generator.things import OCCLUDERS, TALL, any_of, bin_of
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import apart, both, handy, nearer_to
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.removing import put_behind_far
from taskgist.recording import Recording

LEAST_M = 0.52
"""What something is hidden behind is so far from the performer, at least."""


def _with_an_occluder(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    performer = arrangement.performer
    beyond = both(handy(performer), apart(performer, LEAST_M), nearer_to(performer, arrangement.target, by_m=-0.1))
    occluder = arrangement.put(any_of(rng, OCCLUDERS), beyond, yaw_rad=across(arrangement))
    thing = near_the_other(arrangement, occluder, distractors=3, but=TALL)
    roles = arrangement.roles(thing, arrangement.hand_past(occluder, thing), watches=0.5)
    return arrangement.setting(roles, props={"occluder": occluder.name})


def _behind(setting: Setting) -> Means:
    return seen_first(setting.roles, put_behind_far(setting.roles, occluder=setting.props["occluder"]))


def _with_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, LOW), target=("sitting",))  # who stands looks into it
    performer = arrangement.performer
    near = both(handy(performer, share=REACHED_SHARE), nearer_to(performer, arrangement.target))
    container = arrangement.put(bin_of(rng), near)
    thing = near_the_other(arrangement, container, distractors=3, but=TALL)
    roles = arrangement.roles(thing, arrangement.hand_for(thing, container), watches=0.5)
    return arrangement.setting(roles, props={"container": container.name})


def _inside(setting: Setting) -> Means:
    return seen_first(setting.roles, put_inside(setting.roles, "hide away", container=setting.props["container"]))


def _with_a_cupboard(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), performer=("standing",))
    thing = near_the_other(arrangement, distractors=4)
    side = str(rng.choice(("left", "right")))
    cupboard, place = shelf_beside(arrangement, side, closed=True)
    arrangement.furniture.append(cupboard)
    roles = arrangement.roles(thing, side, watches=0.5)
    return arrangement.setting(roles, amounts={"front": cupboard.yaw_rad}, places={"board": place})


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
    Way("hide away", "far-behind", _with_an_occluder, _behind, check_away_and_hidden),
    Way("hide away", "far-inside", _with_a_bin, _inside, check_away_and_hidden),
    Way("hide away", "cupboard", _with_a_cupboard, _in_cupboard, check_away_and_hidden),
)
