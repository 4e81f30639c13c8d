"""Ways to show something, to make it accessible, and to give it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from taskgist.errors import SceneError
from taskgist.moving.steps import Held, HoldUp, Take
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.arrangement import (
    EDGE_M,
    WATCHES,
    Arrangement,
    Setting,
    across,
    apart,
    before_chest,
    both,
    free_place,
    handy,
    lifted,
    off_the_way,
    thing_at_hand,
    to_the_edge_m,
)
from taskgist_lab.generator.furnishing import on_top
from taskgist_lab.generator.offering_means import move_away, turn_towards
from taskgist_lab.generator.outcomes import check_before_eyes, check_comes_into_view, check_turned_to_eyes
from taskgist_lab.generator.reaching import NEARER_M, check_accessible, check_given
from taskgist_lab.generator.rooms import around_a_table
from taskgist_lab.generator.things import (
    CARTONS,
    NOWHERE,
    PEDESTALS,
    PICTURES,
    SMALL,
    TALL,
    WALL_M,
    OpenBox,
    any_colour,
    any_of,
    radius_m,
)
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.demonstration import Script, Step
from taskgist_lab.simulator.means import Means, Roles, hand_over, hold_up, lift_onto, put_on_top, put_within_reach
from taskgist_lab.simulator.places import Place
from taskgist_lab.simulator.room import Thing

# --- Ways to show something: hold it up, put it on top of something, turn it, move away what hides it.

BEFORE_FACE_M = (0.35, 0.55)
"""How far before a face things are held up."""
BEFORE_HIDDEN_M = (0.03, 0.08)
"""Gap between a thing and what hides it at first."""
LEAST_M = 0.52
"""What something stands behind is so far from the performer, at least: room for the thing before it."""
EDGE_ON_RAD = math.radians(8.0)
"""How far a picture that stands edge-on is turned from that, at most."""
ASIDE_RAD = math.radians(30.0)
"""Pictures to be turned stand before the performer."""
SHOWING_NEAR_SHARE = 0.45
"""As ``zones.HANDY_SHARE``: what hides it stands beyond it and must be handy, too."""


def _up(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    thing = arrangement.put(any_of(rng, SMALL), handy(arrangement.performer))
    arrangement.add_distractors(5)
    roles = arrangement.roles(thing, arrangement.hand_for(thing), watches=0.2)
    return arrangement.setting(roles, amounts={"distance": float(rng.uniform(*BEFORE_FACE_M))})


def _held_up(setting: Setting) -> Means:
    return hold_up(setting.roles, distance_m=setting.amounts["distance"])


def _behind_a_pedestal(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    beyond = both(handy(arrangement.performer), apart(arrangement.performer, LEAST_M))
    pedestal = arrangement.put(any_of(rng, PEDESTALS), beyond, yaw_rad=across(arrangement))
    thing = _beyond(arrangement, pedestal, any_of(rng, SMALL, but=TALL))
    arrangement.add_distractors(4, where=off_the_way(arrangement.target, thing))
    roles = arrangement.roles(thing, arrangement.hand_for(thing, pedestal), watches=0.0)
    return arrangement.setting(replace(roles, target_returns_to=thing.name), props={"pedestal": pedestal.name})


def _beyond(arrangement: Arrangement, screen: Thing, thing: Thing) -> Thing:
    """Put a thing right behind another one, as seen by the target agent.

    Raises:
        SceneError: There is no room for it on the table.
    """
    line = np.array(screen.position_m[:2]) - np.array(arrangement.target.position_m)
    radius = radius_m(thing)
    gap = radius + screen.size_m[0] / 2 + arrangement.rng.uniform(*BEFORE_HIDDEN_M)
    place = np.array(screen.position_m) + gap * np.array([*line / np.linalg.norm(line), 0.0])
    if not on_top(arrangement.table, place, radius + EDGE_M):
        raise SceneError(
            f"no place for {thing.name!r} behind {screen.name!r}",
            where="room",
            hint="try another room",
        )
    return arrangement.put_at(thing, place)


def _on_top(setting: Setting) -> Means:
    return put_on_top(setting.roles, of=setting.props["pedestal"])


def _edge_on(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    before = both(handy(arrangement.performer, aside_rad=ASIDE_RAD), apart(arrangement.performer, 0.40))
    picture = arrangement.put(any_of(rng, PICTURES), before, yaw_rad=0.0)
    x, y = np.array(arrangement.target.position_m) - np.array(picture.position_m[:2])
    edge_on = math.atan2(y, x) + math.pi / 2 + rng.uniform(-EDGE_ON_RAD, EDGE_ON_RAD)
    picture = arrangement.replaced(picture, replace(picture, yaw_rad=edge_on))
    arrangement.add_distractors(4)
    side = str(rng.choice(("left", "right")))
    roles = arrangement.roles(picture, side, watches=0.1)
    return arrangement.setting(replace(roles, target_returns_to=picture.name))


def _turned(setting: Setting) -> Means:
    return turn_towards(setting.roles)


def _behind_a_carton(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    performer = arrangement.performer
    thing = arrangement.put(any_of(rng, SMALL), handy(performer, share=SHOWING_NEAR_SHARE))
    carton = any_of(rng, CARTONS)
    line = np.array(arrangement.target.position_m) - np.array(thing.position_m[:2])
    gap = radius_m(thing) + carton.size_m[0] / 2 + rng.uniform(*BEFORE_HIDDEN_M)
    place = np.array(thing.position_m) + gap * np.array([*line / np.linalg.norm(line), 0.0])
    carton = arrangement.put_at(carton, place, yaw_rad=across(arrangement))
    arrangement.add_distractors(2, where=off_the_way(arrangement.target, thing))
    roles = arrangement.roles(thing, arrangement.hand_for(carton), watches=0.0)
    return arrangement.setting(replace(roles, target_returns_to=thing.name), props={"occluder": carton.name})


def _moved_away(setting: Setting) -> Means:
    return move_away(setting.roles, occluder=setting.props["occluder"])


SHOW = (
    Way("show", "hold-up", _up, _held_up, check_before_eyes),
    Way("show", "on-top", _behind_a_pedestal, _on_top, check_comes_into_view),
    Way("show", "turn", _edge_on, _turned, check_turned_to_eyes),
    Way("show", "move-occluder", _behind_a_carton, _moved_away, check_comes_into_view),
)

FAR_SHARE, MAKING_ACCESSIBLE_NEAR_SHARE = 0.60, 0.32
"""From how far from the pelvis on one leans, or gets up, to reach things on a table, and up to where arms alone reach
them, as shares of the stature: arms are 0.40 of it, and shoulders are above tables (ours)."""
ACCESSIBLE_EDGE_M = 0.14
"""How far inside the edge of the table something is put before somebody, at least."""
BETWEEN_M, BETWEEN_SHARE = (0.45, 0.80), 0.43
"""What is only uncovered is so far from the other; and, as ``zones.HANDY_SHARE``, from the performer."""
# --- Ways to make something accessible: put it near, lift it onto something, move away or take off what blocks.

STRETCHED_SHARE = 0.62
"""As ``zones.HANDY_SHARE``: one stretches to put something near to the other."""
COVER_GAP_M = (0.012, 0.03)
"""Room between a thing and the walls, and the top, of what covers it."""
MAKING_ACCESSIBLE_BEFORE_M = (0.03, 0.06)
"""Gap between a thing and what stands before it."""
PEDESTAL_M = 0.20
"""Depth of the strip of the table before the other on which a pedestal stands, at least."""


def _out_of_reach(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    target = arrangement.target
    nearest = to_the_edge_m(target, arrangement.table) + ACCESSIBLE_EDGE_M
    distance = float(rng.uniform(nearest, max(nearest, MAKING_ACCESSIBLE_NEAR_SHARE * target.stature_m)))
    roles = _far_thing(arrangement, distance + NEARER_M)
    arrangement.add_distractors(5, where=off_the_way(arrangement.performer, arrangement.things[-1]))
    return arrangement.setting(roles, amounts={"distance": distance})


def _put_near(setting: Setting) -> Means:
    return put_within_reach(setting.roles, distance_m=round(setting.amounts["distance"], 2))


def _with_a_pedestal(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    target, performer = arrangement.target, arrangement.performer
    nearest = to_the_edge_m(target, arrangement.table) + ACCESSIBLE_EDGE_M
    most = max(nearest + PEDESTAL_M, MAKING_ACCESSIBLE_NEAR_SHARE * target.stature_m)
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
    cover = OpenBox("cover", _around(thing, gap), NOWHERE, rgba=any_colour(rng), upside_down=True)
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
    gap = radius_m(thing) + carton.size_m[0] / 2 + rng.uniform(*MAKING_ACCESSIBLE_BEFORE_M)
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
    Way("make accessible", "put-near", _out_of_reach, _put_near, check_accessible),
    Way("make accessible", "lift-onto", _with_a_pedestal, _lifted_onto, check_accessible),
    Way("make accessible", "take-off-cover", _covered, _cleared, check_accessible),
    Way("make accessible", "move-blocker", _behind_something, _cleared, check_accessible),
)


# --- Ways to give something: taken from the table, or held already, to the left or the right hand.

DISTANCES_M = (0.42, 0.60)
"""How far from the taker's shoulder something is held out."""
GIVING_BEFORE_M, BELOW_M = (0.26, 0.36), (0.02, 0.14)
"""How far before the shoulders, and below them, the giver holds something at first."""
RESTS_SHARE = 0.25
"""How often the taking hand lies on the table before."""
HAND_M, LAID_SHARE = 0.04, 0.33
"""Radius of the free place on which a hand lies, and how far it is from the pelvis, at most, as a share of stature."""


def _room(rng: np.random.Generator, *, taking: str) -> Setting:
    """A room in which something is given with the hand of the same name: so the palms face each other."""
    arrangement = around_a_table(rng, robots=False)  # which take nothing
    roles = replace(thing_at_hand(arrangement).roles, side=taking)
    limits = {"distance": DISTANCES_M, "before": GIVING_BEFORE_M, "below": BELOW_M}
    amounts = {name: float(rng.uniform(*both)) for name, both in limits.items()}
    places: dict[str, Place] = {}
    if rng.random() < RESTS_SHARE:
        x, y, z = free_place(arrangement, handy(arrangement.target, share=LAID_SHARE), radius_m=HAND_M)
        places["rests"] = (float(x), float(y), float(z))
    return arrangement.setting(roles, amounts=amounts, places=places)


def _handed_over(setting: Setting, *, taking: str) -> Means:
    rests = setting.places.get("rests")
    return handed_over(setting.roles, taking=taking, distance_m=setting.amounts["distance"], rests_m=rests)


def handed_over(roles: Roles, *, taking: str, distance_m: float, rests_m: Place | None = None) -> Means:
    """Take it from the table and hand it over, well above the table; arguments as in ``hand_over``."""
    plain = hand_over(roles, taking=taking, distance_m=distance_m, rests_m=rests_m)

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
    Way(
        "give",
        f"{start}to-the-{taking}-hand",
        partial(_room, taking=taking),
        partial(means, taking=taking),
        check_given,
    )
    for start, means in (("", _handed_over), ("from-the-hand-", _from_the_hand))
    for taking in ("left", "right")
)
