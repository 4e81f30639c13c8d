"""Ways to make something accessible: put it near, lift it onto something, move away or take off what blocks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from taskgist.demonstrator.furniture import Thing
from taskgist.demonstrator.generator.arrangement import Arrangement, across
from taskgist.demonstrator.generator.clearing import move_away
from taskgist.demonstrator.generator.outcome import check_shown
from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import WATCHES, to_the_edge_m
from taskgist.demonstrator.generator.things import (
    CARTONS,
    COLOURS,
    NOWHERE,
    PEDESTALS,
    SMALL,
    TALL,
    WALL_M,
    OpenBox,
    any_of,
    radius_m,
)
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import apart, both, handy, off_the_way
from taskgist.demonstrator.means import Means, Roles
from taskgist.demonstrator.offering import lift_onto, put_within_reach
from taskgist.demonstrator.script import Script
from taskgist.world import Scene

FAR_SHARE, NEAR_SHARE = 0.60, 0.32
"""From how far from the pelvis on one leans, or gets up, to reach things on a table, and up to where arms alone reach
them, as shares of the stature: arms are 0.40 of it, and shoulders are above tables (ours)."""
EDGE_M, NEARER_M = 0.14, 0.30
"""How far inside the edge of the table something is put before somebody, at least; and how much nearer to it than
before, if it does not come within the reach of its arms."""
BETWEEN_M, BETWEEN_SHARE = (0.45, 0.90), 0.43
"""What is only uncovered is so far from the other; and, as ``zones.HANDY_SHARE``, from the performer."""
STRETCHED_SHARE = 0.62
"""As ``zones.HANDY_SHARE``: one stretches to put something near to the other."""
COVER_GAP_M = (0.012, 0.03)
"""Room between a thing and the walls, and the top, of what covers it."""
BEFORE_M = (0.03, 0.06)
"""Gap between a thing and what stands before it."""
PEDESTAL_M = 0.20
"""Depth of the strip of the table before the other on which a pedestal stands, at least."""


def _out_of_reach(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    target = arrangement.target
    nearest = to_the_edge_m(target, arrangement.table) + EDGE_M
    distance = float(rng.uniform(nearest, max(nearest, NEAR_SHARE * target.stature_m)))
    roles = _far_thing(arrangement, distance + NEARER_M)
    arrangement.add_distractors(5, where=off_the_way(arrangement.performer, arrangement.things[-1]))
    return arrangement.setting(roles, amounts={"distance": distance})


def _put_near(setting: Setting) -> Means:
    return put_within_reach(setting.roles, distance_m=round(setting.amounts["distance"], 2))


def _with_a_pedestal(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    target, performer = arrangement.target, arrangement.performer
    nearest = to_the_edge_m(target, arrangement.table) + EDGE_M
    most = max(nearest + PEDESTAL_M, NEAR_SHARE * target.stature_m)
    pedestal = arrangement.put(
        any_of(rng, PEDESTALS), both(apart(target, nearest, most), handy(performer, share=STRETCHED_SHARE))
    )
    roles = _far_thing(arrangement, most + NEARER_M)
    arrangement.add_distractors(4, where=off_the_way(arrangement.performer, *arrangement.things))
    return arrangement.setting(roles, props={"pedestal": pedestal.name})


def _lifted_onto(setting: Setting) -> Means:
    return lift_onto(setting.roles, of=setting.props["pedestal"])


def _far_thing(arrangement: Arrangement, least_m: float) -> Roles:
    """Put a thing near the performer, out of the other's reach and so far from it, at least."""
    target = arrangement.target
    far = apart(target, max(FAR_SHARE * target.stature_m, least_m))
    thing = arrangement.put(any_of(arrangement.rng, SMALL), both(handy(arrangement.performer), far))
    return arrangement.roles(thing, arrangement.hand_for(thing), watches=WATCHES)


def _covered(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = _near_thing(arrangement)
    gap = float(rng.uniform(*COVER_GAP_M))
    cover = OpenBox("cover", _around(thing, gap), NOWHERE, rgba=str(rng.choice(COLOURS)), upside_down=True)
    over = arrangement.put_at(cover, np.array(thing.position_m), yaw_rad=thing.yaw_rad)
    return _blocked(arrangement, thing, over)


def _around(thing: Thing, gap_m: float) -> tuple[float, float, float]:
    """Outer size of what covers a thing."""
    deep, wide = (thing.size_m[0], thing.size_m[1] if len(thing.size_m) == 3 else thing.size_m[0])
    room = 2 * (gap_m + WALL_M)
    return round(deep + room, 3), round(wide + room, 3), round(thing.height_m + gap_m + WALL_M, 3)


def _behind_something(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = _near_thing(arrangement)
    carton = any_of(rng, CARTONS)
    line = np.array(arrangement.target.position_m) - np.array(thing.position_m[:2])
    gap = radius_m(thing) + carton.size_m[0] / 2 + rng.uniform(*BEFORE_M)
    place = np.array(thing.position_m) + gap * np.array([*line / np.linalg.norm(line), 0.0])
    return _blocked(arrangement, thing, arrangement.put_at(carton, place, yaw_rad=across(arrangement)))


def _near_thing(arrangement: Arrangement) -> Thing:
    """Put a thing between the two people, near to both."""
    near = both(apart(arrangement.target, *BETWEEN_M), handy(arrangement.performer, share=BETWEEN_SHARE))
    return arrangement.put(any_of(arrangement.rng, SMALL, but=TALL), near)


def _blocked(arrangement: Arrangement, thing: Thing, by: Thing) -> Setting:
    arrangement.add_distractors(
        2, where=both(off_the_way(arrangement.target, thing), off_the_way(arrangement.performer, by))
    )
    roles = arrangement.roles(thing, arrangement.hand_for(by), watches=0.0)
    return arrangement.setting(replace(roles, target_returns_to=thing.name), props={"blocking": by.name})


def _cleared(setting: Setting) -> Means:
    """Take off, or move away, what blocks; the thing itself is not touched."""
    blocking = setting.props["blocking"]
    away = move_away(setting.roles, occluder=blocking)

    def script(scene: Scene) -> Script:
        return replace(away(scene), task="make accessible", means=f"{blocking} moved out of the way")

    return script


MAKE_ACCESSIBLE = (
    Way("make accessible", "put-near", _out_of_reach, _put_near, check_shown),
    Way("make accessible", "lift-onto", _with_a_pedestal, _lifted_onto, check_shown),
    Way("make accessible", "take-off-cover", _covered, _cleared, check_shown),
    Way("make accessible", "move-blocker", _behind_something, _cleared, check_shown),
)
