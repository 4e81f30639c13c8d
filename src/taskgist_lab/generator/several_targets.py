"""Ways to hide something from two, to show it to two, and to give two things (9.6, 9.7).

Two who are told or shown something sit or stand beside each other, each in view of the performer. What is done is what
is done for one; the performer sees to it that it comes out for both. Two things are given one after the other, with
one hand after the other: nobody has both in one hand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.recording.recording import Recording
from taskgist.world.bodies.profile import Posture
from taskgist.world.scene import Scene
from taskgist_lab.generator.arrangement import (
    Arrangement,
    Setting,
    across,
    apart,
    both,
    handy,
    off_the_way,
)
from taskgist_lab.generator.furnishing import RoundTable, any_seat, bearing_of, distance_m, person_at, seat_at
from taskgist_lab.generator.hiding_means import put_inside, put_under
from taskgist_lab.generator.outcomes import check_before_eyes, seen_first
from taskgist_lab.generator.rooms import DINING, EITHER, HIGH, ROUND, around_a_table
from taskgist_lab.generator.tasks_that_offer import BEFORE_FACE_M, DISTANCES_M, handed_over
from taskgist_lab.generator.tasks_that_remove import (
    HIDING_LEAST_M,
    OFF_M,
    check_from_view_to_hidden,
    check_put_out_of_view,
)
from taskgist_lab.generator.things import COVERABLE, OCCLUDERS, SMALL, TALL, any_of, bin_of, cover_for
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.demonstration import Script
from taskgist_lab.simulator.means import Means, Roles, hold_up, put_behind
from taskgist_lab.simulator.room import Person

# --- A second one beside the target agent.

NEIGHBOUR_TRIES = 60
ELBOWS_M, BESIDE_M = 0.62, 1.10
"""How far two who sit or stand beside each other are apart, pelvis to pelvis: room for elbows, and still together."""
FROM_PERFORMER_M = 0.95
"""How far both are from the performer."""
ROUND_RAD = (math.radians(40.0), math.radians(75.0))
"""How far round a round table the neighbour is."""


def two_watching(
    rng: np.random.Generator, *, tables: Sequence[str] = (DINING, ROUND, HIGH), target: Sequence[Posture] = EITHER
) -> tuple[Arrangement, Person]:
    """A room with somebody beside the target agent for whom the same is done.

    Args:
        rng: Source of everything that is chosen.
        tables: Kinds of tables that will do.
        target: Postures of the target agents that will do.

    Raises:
        SceneError: There is no room for a second one.
    """
    arrangement = around_a_table(rng, tables=tables, target=target, robots=False)
    table, first = arrangement.table, arrangement.target
    people = (first, arrangement.performer, *arrangement.others)
    name = next(f"P{n}" for n in range(1, 9) if f"P{n}" not in {person.name for person in people})
    for _ in range(NEIGHBOUR_TRIES):
        seat = any_seat(rng, table)
        if isinstance(table, RoundTable):
            bearing = first.yaw_rad + math.pi + rng.choice((-1, 1)) * rng.uniform(*ROUND_RAD)
            seat = seat_at(table, bearing)
        person = person_at(rng, name, seat, table, first.posture, back=False)
        place = np.array(person.position_m)
        beside = ELBOWS_M <= distance_m(first, place) <= BESIDE_M
        clear = all(distance_m(other, place) >= ELBOWS_M for other in people)
        if beside and clear and distance_m(arrangement.performer, place) >= FROM_PERFORMER_M:
            arrangement.others.append(person)
            return arrangement, person
    raise SceneError(f"no room for {name!r} beside {first.name!r}", where="room", hint="try another room")


def _for_both(roles: Roles, other: Person) -> Roles:
    return replace(roles, also_for=(other.name,))


# --- Hiding from both.


def _hiding_with_an_occluder(rng: np.random.Generator) -> Setting:
    arrangement, other = two_watching(rng)
    acting = arrangement.performer
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), handy(acting))
    off = (off_the_way(person, thing, least_m=OFF_M) for person in (acting, arrangement.target, other))
    beyond = both(handy(acting), apart(acting, HIDING_LEAST_M), *off)
    occluder = arrangement.put(any_of(rng, OCCLUDERS), beyond, yaw_rad=_across(arrangement, other))
    arrangement.add_distractors(3, where=off_the_way(acting, thing, occluder))
    roles = _for_both(arrangement.roles(thing, arrangement.hand_past(occluder, thing), watches=0.5), other)
    return arrangement.setting(roles, props={"occluder": occluder.name})


def _across(arrangement: Arrangement, other: Person) -> float:
    """A heading in which what is wide stands across the line to the middle between the two."""
    x, y = (np.array(arrangement.target.position_m) + np.array(other.position_m)) / 2
    middle = replace(arrangement.target, position_m=(float(x), float(y)))
    return across(replace(arrangement, target=middle))


def _behind(setting: Setting) -> Means:
    return seen_first(setting.roles, put_behind(setting.roles, occluder=setting.props["occluder"]))


def _hiding_with_a_bin(rng: np.random.Generator) -> Setting:
    arrangement, other = two_watching(rng, tables=(DINING, ROUND), target=("sitting",))  # who stands looks into it
    near = handy(arrangement.performer)
    container = arrangement.put(bin_of(rng), near)
    thing = arrangement.put(any_of(rng, SMALL, but=TALL), near)
    arrangement.add_distractors(3)
    roles = _for_both(arrangement.roles(thing, arrangement.hand_for(thing, container), watches=0.5), other)
    return arrangement.setting(roles, props={"container": container.name})


def _inside(setting: Setting) -> Means:
    return seen_first(setting.roles, put_inside(setting.roles, "hide", container=setting.props["container"]))


def _hiding_with_a_cover(rng: np.random.Generator) -> Setting:
    arrangement, other = two_watching(rng)
    thing = arrangement.put(any_of(rng, COVERABLE), handy(arrangement.performer))
    cover = arrangement.put(cover_for(rng, thing), handy(arrangement.performer))
    arrangement.add_distractors(3)
    roles = _for_both(arrangement.roles(thing, arrangement.hand_for(thing, cover), watches=0.5), other)
    return arrangement.setting(roles, props={"cover": cover.name})


def _under(setting: Setting) -> Means:
    return seen_first(setting.roles, put_under(setting.roles, cover=setting.props["cover"]))


# --- Showing to both.


def _in_hand(rng: np.random.Generator) -> Setting:
    arrangement, other = two_watching(rng)
    thing = arrangement.put(any_of(rng, SMALL), handy(arrangement.performer))
    arrangement.add_distractors(4)
    roles = _for_both(arrangement.roles(thing, arrangement.hand_for(thing), watches=0.2), other)
    return arrangement.setting(roles, amounts={"distance": float(rng.uniform(*BEFORE_FACE_M))})


def _held_up(setting: Setting) -> Means:
    return hold_up(setting.roles, distance_m=setting.amounts["distance"])


# --- Giving two things, one after the other.

APART_RAD = math.radians(20.0)
"""How far the two lie apart, as the performer sees them: each hand takes the one on its side."""
HANDS = ("right", "left")
"""Which hand gives, and takes, first."""


def _two_things(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH), robots=False)
    performer = arrangement.performer
    first = arrangement.put(any_of(rng, SMALL, but=TALL), handy(performer))
    other = any_of(rng, SMALL, but=TALL)

    def left_of_it(place: Array) -> bool:
        return bearing_of(performer, place) - bearing_of(performer, np.array(first.position_m)) >= APART_RAD

    second = arrangement.put(other, both(handy(performer), off_the_way(performer, first), left_of_it))
    arrangement.add_distractors(2, where=off_the_way(performer, first, second))
    roles = arrangement.roles(first, HANDS[0], watches=0.3)
    amounts = {name: float(rng.uniform(*DISTANCES_M)) for name in HANDS}
    return arrangement.setting(roles, props={"second": second.name}, amounts=amounts)


def _one_after_the_other(setting: Setting) -> Means:
    """Take the first and hand it over, then the second."""
    things = (setting.roles.thing, setting.props["second"])

    def script(scene: Scene) -> Script:
        given = [
            handed_over(replace(setting.roles, thing=thing, side=hand), taking=hand, distance_m=setting.amounts[hand])(
                scene
            )
            for thing, hand in zip(things, HANDS, strict=True)
        ]
        return replace(
            given[0],
            steps=(*given[0].steps, *given[1].steps),
            also_with=things[1:],
            means=f"{things[0]} handed over to the right hand, {things[1]} to the left",
        )

    return script


def check_apart(recording: Recording) -> None:
    """Refuse a demonstration in which the two things that were given end in each other.

    Raises:
        SceneError: They do.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    qpos = recording.at(label.end_s).qpos
    one, other = (qpos[scene.object_slice(name)][:3] for name in label.target_objects)
    if float(np.linalg.norm(one - other)) < HANDS_APART_M:
        raise SceneError("the two things end in each other", where=recording.name, hint="try another room")


HANDS_APART_M = 0.15
"""How far what is held in one hand is from what is held in the other."""

HIDE_FROM_BOTH = (
    Way("hide", "behind-from-both", _hiding_with_an_occluder, _behind, check_put_out_of_view),
    Way("hide", "inside-from-both", _hiding_with_a_bin, _inside, check_from_view_to_hidden),
    Way("hide", "under-cover-from-both", _hiding_with_a_cover, _under, check_from_view_to_hidden),
)
SHOW_TO_BOTH = (Way("show", "hold-up-to-both", _in_hand, _held_up, check_before_eyes),)
GIVE_BOTH = (Way("give", "one-after-the-other", _two_things, _one_after_the_other, check_apart),)
