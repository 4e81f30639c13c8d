"""Ways to turn, stack, pour, inspect and tidy things: what people do with their hands for nobody in particular.

Nothing flows where something is poured: a vessel is tilted over another one and set down again. Each way looks at its
own outcome, as those of the tasks do, so that none is called what it did not become.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.body import Body
from taskgist.moving.hand_pose import SIGNS, UP
from taskgist.moving.steps import HoldUp, PutDown, Take, Withdraw, half_height_m
from taskgist.moving.steps_from_above import LiftAway, TakeFromAbove, Turn
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT
from taskgist.world.contacts import object_points, support_of
from taskgist.world.geometry.transforms import normalized, rotate, yaw_of
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.arrangement import (
    EDGE_M,
    WATCHES,
    Arrangement,
    Setting,
    both,
    handy,
    off_the_way,
    thing_at_hand,
)
from taskgist_lab.generator.furnishing import bearing_of
from taskgist_lab.generator.furnishing import on_top as on_table
from taskgist_lab.generator.outcomes import LOOK_EVERY, check_stands
from taskgist_lab.generator.rooms import around_a_table
from taskgist_lab.generator.things import (
    LARGE,
    NOWHERE,
    SMALL,
    Kind,
    any_colour,
    any_of,
    radius_m,
)
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.demonstration import Script
from taskgist_lab.simulator.handling import Roll
from taskgist_lab.simulator.means import Means
from taskgist_lab.simulator.places import SUPPORT_SPACING_M, Place, on_top
from taskgist_lab.simulator.room import Person, Thing

SAME_PLACE_M = 0.03
"""What is set down again where it stood is no farther from there."""


def _outcome(recording: Recording, problem: str, value: float) -> SceneError:
    assert recording.label is not None
    thing = recording.label.target_object
    return SceneError(f"{thing!r} {problem}", where=recording.name, value=round(value, 3), hint="try another room")


def _poses(recording: Recording, name: str) -> Array:
    """Positions and wxyz of a thing from the beginning of the labelled task to its end, (n, 7)."""
    label = recording.label
    assert label is not None
    within = (recording.times_s >= label.start_s) & (recording.times_s <= label.end_s)
    return np.asarray(recording.qpos[within][:, recording.scene.object_slice(name)])


def _check_same_place(recording: Recording) -> None:
    assert recording.label is not None
    poses = _poses(recording, recording.label.target_object)
    away = float(np.linalg.norm(poses[-1, :3] - poses[0, :3]))
    if away > SAME_PLACE_M:
        raise _outcome(recording, "does not stand where it stood", away)


# --- Ways to turn something where it stands: from above, or at its side.

TURNED_RAD = (0.6, 1.3)
"""How far things are turned."""
LEAST_TURNED_RAD = 0.5
FROM_ABOVE_RAD = 0.87
"""How far the fingers point down that take something from above."""
RISES_M = 0.10
"""How high a hand rises above the thing's height from what it has turned."""


def _to_be_turned(rng: np.random.Generator) -> Setting:
    setting = thing_at_hand(around_a_table(rng))
    angle = SIGNS[setting.roles.side] * float(rng.uniform(*TURNED_RAD))
    return replace(setting, amounts={"angle": angle})


def _turned_from_above(setting: Setting) -> Means:
    roles, angle = setting.roles, setting.amounts["angle"]

    def script(scene: Scene) -> Script:
        take = TakeFromAbove(roles.thing, roles.side, FROM_ABOVE_RAD, aside_rad=-angle / 3)
        away = LiftAway(2 * half_height_m(Stage(scene), roles.thing) + RISES_M)
        return replace(roles.script("turn", "turned from above"), steps=(take, Turn(angle), away))

    return script


def _turned_at_its_side(setting: Setting) -> Means:
    turn = Turn(setting.amounts["angle"])
    return lambda _scene: setting.roles.script("turn", "turned at its side", turn, Withdraw())


def check_turned(recording: Recording) -> None:
    """Refuse a demonstration whose thing is not turned where it stands.

    Raises:
        SceneError: It is hardly turned, stands elsewhere, or would fall.
    """
    assert recording.label is not None
    poses = _poses(recording, recording.label.target_object)
    turned = abs((yaw_of(poses[-1, 3:]) - yaw_of(poses[0, 3:]) + np.pi) % (2 * np.pi) - np.pi)
    if turned < LEAST_TURNED_RAD:
        raise _outcome(recording, "is hardly turned", turned)
    _check_same_place(recording)
    check_stands(recording)


TURN = (
    Way("turn", "from-above", _to_be_turned, _turned_from_above, check_turned),
    Way("turn", "at-its-side", _to_be_turned, _turned_at_its_side, check_turned),
)

# --- Ways to stack something: onto something flat, or onto one of its kind.

FLAT: Mapping[str, Kind] = {name: LARGE[name] for name in ("book", "box")}
STACKED: Mapping[str, Kind] = {name: SMALL[name] for name in ("cube", "tin", "tape")}
"""What stands on one of its kind."""


def _beside_something_flat(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    base = arrangement.put(any_of(rng, FLAT), handy(arrangement.performer))
    return arrangement.setting(thing_at_hand(arrangement).roles, props={"base": base.name})


def _beside_its_like(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    kind = str(rng.choice(list(STACKED)))
    one, other = sorted((STACKED[kind](rng) for _ in range(2)), key=radius_m)
    base = arrangement.put(other, handy(arrangement.performer))
    return arrangement.setting(thing_at_hand(arrangement, one).roles, props={"base": base.name})


def _stacked(setting: Setting) -> Means:
    base = setting.props["base"]
    return setting.roles.putting("stack", f"stacked onto {base}", lambda scene: on_top(Stage(scene), base))


def check_stacked(recording: Recording) -> None:
    """Refuse a demonstration whose thing does not come to stand on another one.

    Raises:
        SceneError: It stands on no other thing in the end, stood on it before, or would fall.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    stages = [Stage(scene, recording.at(time_s)) for time_s in (label.start_s, label.end_s)]
    before, after = (support_of(stage, label.target_object, DEFAULT.contact) for stage in stages)
    if after not in scene.objects or after == before:
        raise _outcome(recording, "does not come to stand on another thing", 0.0)
    check_stands(recording)


STACK = (
    Way("stack", "onto-something-flat", _beside_something_flat, _stacked, check_stacked),
    Way("stack", "onto-its-like", _beside_its_like, _stacked, check_stacked),
)

# --- Ways to pour: what is held is tilted over a bowl, or over a mug, and set down again.

POURED: Mapping[str, Kind] = {name: SMALL[name] for name in ("packet", "tin", "bottle", "carafe")}
INTO: Mapping[str, Mapping[str, Kind]] = {"bowl": {"bowl": LARGE["bowl"]}, "mug": {"mug": SMALL["mug"]}}
TILT_RAD, LEAST_TILT_RAD = (1.15, 1.40), 1.0
"""How far it is tilted, and how far at least."""
OVER_RIM_M, POURING_S = (0.03, 0.08), (0.4, 1.2)
"""How high its side is over the rim of what it is poured into, and for how long."""
LIP_M = 0.02
"""How far beyond the rim of what it is poured into the mouth may be, on the floor plan."""


def _beside_a_vessel(rng: np.random.Generator, *, vessel: str) -> Setting:
    arrangement = around_a_table(rng)
    into = arrangement.put(any_of(rng, INTO[vessel]), handy(arrangement.performer))
    roles = thing_at_hand(arrangement, any_of(rng, POURED), distractors=3).roles
    ranges = {"tilt": TILT_RAD, "over": OVER_RIM_M, "seconds": POURING_S}
    amounts = {name: float(rng.uniform(*limits)) for name, limits in ranges.items()}
    return arrangement.setting(roles, props={"into": into.name}, amounts=amounts)


def _poured(setting: Setting) -> Means:
    roles, into, amounts = setting.roles, setting.props["into"], setting.amounts

    def script(scene: Scene) -> Script:
        stage, body, tilt = Stage(scene), Body(scene, roles.performer), amounts["tilt"]
        half_m, middle = half_height_m(stage, roles.thing), np.array(on_top(stage, into))
        ahead = normalized((*body.heading_to(scene.initial, roles.side, middle), 0.0))
        facing = SIGNS[roles.side] * np.cross(UP, ahead)
        points = object_points(stage, roles.thing, SUPPORT_SPACING_M)
        breadth_m = float(np.ptp(points[:, :2], axis=0).max()) / 2
        lifted = breadth_m * np.sin(tilt) - half_m * np.cos(tilt) + amounts["over"]
        x, y, z = middle - half_m * np.sin(tilt) * facing + max(lifted, amounts["over"]) * UP
        hold = HoldUp((float(x), float(y), float(z)), 0.0, looks_at=into)
        pour = Roll("fingers", tilt, amounts["seconds"])
        return roles.script(
            "pour", f"poured into {into}", hold, pour, PutDown(_underside(stage, roles.thing)), Withdraw()
        )

    return script


def _underside(stage: Stage, thing: str) -> tuple[float, float, float]:
    """The middle of a thing's underside where it stands, (3,)."""
    x, y, z = stage.body_position(stage.scene.object_body(thing))
    return float(x), float(y), float(z) - half_height_m(stage, thing)


def check_poured(recording: Recording) -> None:
    """Refuse a demonstration whose thing is not tilted with its mouth over another thing and set down again.

    Raises:
        SceneError: It is not tilted enough, its mouth is beside all other things then, or it does not stand where it
            stood in the end.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    stage = Stage(scene)
    half_m = half_height_m(stage, label.target_object)
    poses = _poses(recording, label.target_object)
    ups = np.array([rotate(pose[3:], UP) for pose in poses])
    most = int(np.argmin(ups[:, 2]))
    tilt = float(np.arccos(np.clip(ups[most, 2], -1.0, 1.0)))
    if tilt < LEAST_TILT_RAD:
        raise _outcome(recording, "is hardly tilted", tilt)
    mouth = poses[most, :3] + half_m * ups[most]
    if not any(_is_over(stage, name, mouth) for name in scene.objects if name != label.target_object):
        raise _outcome(recording, "is tilted over nothing", tilt)
    _check_same_place(recording)
    check_stands(recording)


def _is_over(stage: Stage, thing: str, place: Array) -> bool:
    """Whether a place is above what a thing takes up on the floor plan."""
    points = object_points(stage, thing, SUPPORT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    return bool(np.all(low[:2] - LIP_M < place[:2]) and np.all(place[:2] < high[:2] + LIP_M) and place[2] > high[2])


POUR = (
    Way("pour", "into-a-bowl", partial(_beside_a_vessel, vessel="bowl"), _poured, check_poured),
    Way("pour", "into-a-mug", partial(_beside_a_vessel, vessel="mug"), _poured, check_poured),
)

# --- Ways to inspect something: it is held before the own eyes, turned or tilted there, and set down again.

BEFORE_EYES_M, BELOW_EYES_M = (0.28, 0.38), (0.10, 0.18)
"""How far before the own eyes something is inspected, and how far below them."""
NEAR_EYES_M = 0.45
"""From so near, at most, a thing is inspected."""
LOOKED_RAD, LEAST_LOOKED_RAD, LOOKED_S = (0.6, 1.0), 0.45, (0.4, 1.0)
"""How far it is turned or tilted before the eyes, how far at least, and how long it is looked at so."""


def _to_be_inspected(rng: np.random.Generator) -> Setting:
    setting = thing_at_hand(around_a_table(rng))
    ranges = {"before": BEFORE_EYES_M, "below": BELOW_EYES_M, "angle": LOOKED_RAD, "seconds": LOOKED_S}
    return replace(setting, amounts={name: float(rng.uniform(*limits)) for name, limits in ranges.items()})


def _inspected(setting: Setting, *, tilted: bool) -> Means:
    roles, amounts = setting.roles, setting.amounts

    def script(scene: Scene) -> Script:
        stage, agent = Stage(scene), scene.agent(roles.performer)
        ahead = stage.shoulder(agent.arm(roles.side)).matrix[:, 0]
        x, y, z = stage.eye(agent).position + amounts["before"] * ahead - amounts["below"] * UP
        hold = HoldUp((float(x), float(y), float(z)), amounts["seconds"], looks_at=roles.thing)
        roll = Roll("fingers" if tilted else "upright", amounts["angle"], amounts["seconds"])
        means = f"{'tilted' if tilted else 'turned'} before the own eyes"
        return roles.script("inspect", means, hold, roll, PutDown(_underside(stage, roles.thing)), Withdraw())

    return script


def check_inspected(recording: Recording) -> None:
    """Refuse a demonstration whose thing is not turned before the performer's eyes and set down again.

    Raises:
        SceneError: It stays too far from the eyes, is hardly turned there, or does not stand where it stood in the end.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    stage, turns = Stage(scene), []
    inside = np.flatnonzero((recording.times_s >= label.start_s) & (recording.times_s <= label.end_s))[::LOOK_EVERY]
    for index in inside:
        stage.show(recording.state(int(index)))
        pose = recording.qpos[index, scene.object_slice(label.target_object)]
        if np.linalg.norm(stage.eye(scene.agent(label.performing_agent)).position - pose[:3]) <= NEAR_EYES_M:
            turns.append(pose[3:])
    if not turns:
        raise _outcome(recording, "is not held before the own eyes", 0.0)
    cosines = np.abs(np.array(turns) @ np.array(turns).T).min()  # of half the angle between two of them
    turned = 2.0 * float(np.arccos(np.clip(cosines, -1.0, 1.0)))
    if turned < LEAST_LOOKED_RAD:
        raise _outcome(recording, "is hardly turned before the own eyes", turned)
    _check_same_place(recording)
    check_stands(recording)


INSPECT = (
    Way("inspect", "turned", _to_be_inspected, partial(_inspected, tilted=False), check_inspected),
    Way("inspect", "tilted", _to_be_inspected, partial(_inspected, tilted=True), check_inspected),
)

# --- Ways to tidy: two things that lie about are put beside a third one, or onto a tray, one after the other.

SIDE_BY_SIDE_M, TIDY_M, ASTRAY_M = (0.015, 0.04), 0.06, 0.12
"""Gap that is left between them; they are together up to which gap, and lie about from which on."""
TRAY_M = ((0.22, 0.32, 0.012), (0.28, 0.40, 0.020))
"""Least and largest size of a tray."""
MOVED_M = 0.05
"""What is tidied away is so far from where it lay, at least."""


def _lying_about(rng: np.random.Generator) -> Setting:
    """A thing, and two others that have room beside it, on the side of the hand that will put them there."""
    arrangement = around_a_table(rng)
    performer = arrangement.performer
    first = arrangement.put(any_of(rng, SMALL), handy(performer))
    side, aside = _to_its_side(performer, first)
    things, goals = [any_of(rng, SMALL) for _ in range(2)], []
    place, radius = np.array(first.position_m), radius_m(first)
    for thing in things:
        place = place + (radius + radius_m(thing) + float(rng.uniform(*SIDE_BY_SIDE_M))) * aside
        radius = radius_m(thing)
        if not on_table(arrangement.table, place, radius + EDGE_M):
            raise SceneError("no room beside it", where="room", field=first.name, hint="try another room")
        goals.append(place)
    return _tidying(arrangement, things, goals, side)


def _beside_a_tray(rng: np.random.Generator) -> Setting:
    """A tray, and two things that have room on it."""
    arrangement = around_a_table(rng)
    performer = arrangement.performer
    size = tuple(round(float(each), 3) for each in rng.uniform(*TRAY_M))
    tray = arrangement.put(
        Thing("tray", size, NOWHERE, rgba=any_colour(rng)), handy(performer), yaw_rad=performer.yaw_rad
    )
    side, aside = _to_its_side(performer, tray)
    middle = np.array(tray.position_m) + size[2] * UP
    goals = [middle + share * size[1] / 4 * aside for share in (-1.0, 1.0)]
    return _tidying(arrangement, [any_of(rng, SMALL) for _ in goals], goals, side)


def _to_its_side(person: Person, thing: Thing) -> tuple[str, Array]:
    """Somebody's hand on the side of a thing, and the unit direction (3,) to that side."""
    side = "left" if bearing_of(person, np.array(thing.position_m)) > 0 else "right"
    yaw = person.yaw_rad
    return side, SIGNS[side] * np.array([np.sin(yaw), -np.cos(yaw), 0.0])


def _tidying(arrangement: Arrangement, things: Sequence[Thing], goals: Sequence[Array], side: str) -> Setting:
    """Let things lie about, off the places where they will be put, which are kept free."""
    performer, there = arrangement.performer, list(arrangement.things)
    kept = [arrangement.put_at(thing, goal) for thing, goal in zip(things, goals, strict=True)]
    near = [radius_m(each) + max(map(radius_m, things)) + ASTRAY_M for each in (*there, *kept)]

    def astray(place: Array) -> bool:
        gaps = [np.linalg.norm(place[:2] - each.position_m[:2]) for each in (*there, *kept)]
        return all(gap > least for gap, least in zip(gaps, near, strict=True))

    laid = [arrangement.put(thing, both(handy(performer), astray)) for thing in things]
    arrangement.add_distractors(2, where=off_the_way(performer, *there, *kept, *laid))
    for each in kept:
        arrangement.things.remove(each)
    second, third = laid
    places = {name: _place(goal) for name, goal in zip(("second", "third"), goals, strict=True)}
    return arrangement.setting(
        arrangement.roles(third, side, watches=WATCHES), props={"second": second.name}, places=places
    )


def _place(place: Array) -> Place:
    x, y, z = (float(value) for value in place)
    return x, y, z


def _tidied(setting: Setting, *, words: str) -> Means:
    roles, places = setting.roles, setting.places
    steps = (
        *(Take(setting.props["second"], roles.side), PutDown(places["second"]), Withdraw()),
        *(Take(roles.thing, roles.side), PutDown(places["third"]), Withdraw()),
    )
    return lambda _scene: replace(roles.script("tidy", words), steps=steps)


def check_tidied(recording: Recording) -> None:
    """Refuse a demonstration in which fewer than two things that lay about come to others, or onto one and the same.

    Raises:
        SceneError: So it is, or the last one would fall.
    """
    label, scene = recording.label, recording.scene
    assert label is not None
    before, after = (Stage(scene, recording.at(time_s)) for time_s in (label.start_s, label.end_s))
    tidy = []
    for name in scene.objects:
        ways = _poses(recording, name)
        if np.linalg.norm(ways[-1, :3] - ways[0, :3]) > MOVED_M:
            others = [other for other in scene.objects if other != name]
            beside = any(_gap_m(after, name, o) <= TIDY_M and _gap_m(before, name, o) >= ASTRAY_M for o in others)
            stands = [support_of(stage, name, DEFAULT.contact) for stage in (before, after)]
            onto = stands[1] in scene.objects and stands[0] != stands[1]
            tidy += [name] if beside or onto else []
    if label.target_object not in tidy or len(tidy) < 2:
        raise _outcome(recording, "is not tidied up", len(tidy))
    check_stands(recording)


def _gap_m(stage: Stage, one: str, other: str) -> float:
    """Gap between the circles around two things, on the floor plan, in metres."""
    points = [object_points(stage, name, SUPPORT_SPACING_M)[:, :2] for name in (one, other)]
    middles = [(each.min(axis=0) + each.max(axis=0)) / 2 for each in points]
    radii = [float(np.linalg.norm(each - middle, axis=1).max()) for each, middle in zip(points, middles, strict=True)]
    return float(np.linalg.norm(middles[0] - middles[1])) - sum(radii)


TIDY = (
    Way("tidy", "side-by-side", _lying_about, partial(_tidied, words="put side by side"), check_tidied),
    Way("tidy", "onto-a-tray", _beside_a_tray, partial(_tidied, words="put onto a tray"), check_tidied),
)
