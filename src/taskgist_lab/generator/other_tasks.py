"""Ways to drop, dump, lift, tap and throw something: tasks that are none of the paper's."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from taskgist.errors import SceneError
from taskgist.moving.steps import HoldUp, Withdraw
from taskgist.recording.recording import Recording
from taskgist.world.contacts import object_points
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist_lab.generator.arrangement import (
    Arrangement,
    Setting,
    apart,
    before_chest,
    beside,
    both,
    free_place,
    handy,
    thing_at_hand,
)
from taskgist_lab.generator.rooms import DINING, HIGH, ROUND, around_a_table
from taskgist_lab.generator.things import NOWHERE, SMALL, OpenBox, any_colour, any_of
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.demonstration import Script
from taskgist_lab.simulator.means import HELD_S, Means
from taskgist_lab.simulator.places import SUPPORT_SPACING_M
from taskgist_lab.simulator.room import Thing
from taskgist_lab.simulator.throwing import LetFall, Tap, Throw

# --- Ways to drop something: onto the table, or beside oneself to the floor.

DROPPING_ASIDE_M, DROPPING_AHEAD_M = (0.40, 0.52), (0.05, 0.20)
"""How far to the hand's side of the pelvis, and before it, something falls to the floor."""
DROPPING_HELD_SHARE = {"sitting": (0.50, 0.62), "standing": (0.60, 0.76)}
"""How high it is held above the floor, as shares of the stature."""
ABOVE_TABLE_M = (0.55, 0.75)
"""How high it is held above the table that it falls onto."""
NEAR_SHARE = 0.38
"""How far from the pelvis it is dropped onto the table, at most, as a share of the stature."""
ROOM_M = 0.08
"""Radius of the free circle onto which it falls."""
DROPPING_HELD_S = 0.3
"""How long it is held still before it falls."""


def _over_the_floor(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles, person = thing_at_hand(arrangement).roles, arrangement.performer
    x, y = beside(person, roles.side, aside_m=rng.uniform(*DROPPING_ASIDE_M), ahead_m=rng.uniform(*DROPPING_AHEAD_M))
    height = person.stature_m * float(rng.uniform(*DROPPING_HELD_SHARE[person.posture]))
    return arrangement.setting(roles, places={"held": (x, y, height)})


def _over_the_table(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, performer=("standing",))
    roles = thing_at_hand(arrangement).roles
    near = handy(arrangement.performer, share=NEAR_SHARE)
    x, y, z = (float(value) for value in free_place(arrangement, near, radius_m=ROOM_M))
    return arrangement.setting(roles, places={"held": (x, y, z + float(rng.uniform(*ABOVE_TABLE_M)))})


def _dropped(setting: Setting) -> Means:
    steps = (HoldUp(setting.places["held"], DROPPING_HELD_S), LetFall(dropped=True), Withdraw())
    return lambda _scene: setting.roles.script("drop", "held up and dropped", *steps)


DROP = (
    Way("drop", "to-the-floor", _over_the_floor, _dropped),
    Way("drop", "onto-the-table", _over_the_table, _dropped),
)

# --- Ways to dump something: into a bin on the floor beside oneself, or into one on the table.

BIN = "bin"
FLOOR_BIN_M = ((0.24, 0.24, 0.30), (0.32, 0.32, 0.42))
TABLE_BIN_M, RIM_M = ((0.17, 0.17, 0.12), (0.22, 0.22, 0.19)), 0.05
"""Least and largest sizes of bins; and how far the rim is above the middle of what stands in one on the table."""
DUMPING_ASIDE_M, DUMPING_AHEAD_M = (0.42, 0.52), (-0.02, 0.08)
"""How far to the hand's side of the pelvis, and before it, a bin stands on the floor."""
DUMPING_HELD_SHARE = {"sitting": (0.48, 0.56), "standing": (0.56, 0.66)}
"""How high above the floor the thing is held over a bin there, as shares of the stature."""
ABOVE_M = (0.05, 0.12)
"""How high above the rim of a bin on the table its underside is when the hand opens."""
APART_M = 0.40
"""How far a bin on the table is from the performer, at least."""
DUMPING_HELD_S = 0.2


def a_bin(rng: np.random.Generator, low: tuple[float, ...], high: tuple[float, ...]) -> OpenBox:
    """A bin between two sizes."""
    size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
    return OpenBox(BIN, size, NOWHERE, rgba=any_colour(rng))


def _beside_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH))  # beside a sofa there is no room for it
    roles, person = thing_at_hand(arrangement).roles, arrangement.performer
    x, y = beside(person, roles.side, aside_m=rng.uniform(*DUMPING_ASIDE_M), ahead_m=rng.uniform(*DUMPING_AHEAD_M))
    into = arrangement.put_at(a_bin(rng, *FLOOR_BIN_M), np.array([x, y, 0.0]), yaw_rad=person.yaw_rad)
    height = person.stature_m * float(rng.uniform(*DUMPING_HELD_SHARE[person.posture]))
    return arrangement.setting(roles, props={"container": into.name}, places={"held": (x, y, height)})


def _at_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    person, thing = arrangement.performer, any_of(rng, SMALL)
    low, high = TABLE_BIN_M
    deep = (*low[:2], max(low[2], min(high[2], thing.height_m / 2 + RIM_M)))
    into = arrangement.put(a_bin(rng, deep, high), both(handy(person), apart(person, APART_M)))
    roles = thing_at_hand(arrangement, thing, distractors=4).roles
    x, y, z = into.position_m
    height = z + into.height_m + thing.height_m / 2 + float(rng.uniform(*ABOVE_M))
    return arrangement.setting(roles, props={"container": into.name}, places={"held": (x, y, height)})


def _dumped(setting: Setting) -> Means:
    steps = (HoldUp(setting.places["held"], DUMPING_HELD_S), LetFall(dropped=False), Withdraw())
    means = f"dropped into {setting.props['container']}"
    return lambda _scene: setting.roles.script("dump", means, *steps)


def check_dumped(recording: Recording) -> None:
    """Refuse a demonstration at whose end the thing is not in the bin.

    Raises:
        SceneError: It fell beside it, or sticks out of it.
    """
    label = recording.label
    assert label is not None
    stage = Stage(recording.scene, recording.at(label.end_s))
    middle = stage.body_position(recording.scene.object_body(label.target_object))
    points = object_points(stage, BIN, SUPPORT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    if not np.all((low < middle) & (middle < high)):
        hint = "hold it lower, or over the middle"
        raise SceneError(f"{label.target_object!r} missed the bin", where=recording.name, hint=hint)


DUMP = (
    Way("dump", "into-a-bin-on-the-floor", _beside_a_bin, _dumped, check_dumped),
    Way("dump", "into-a-bin-on-the-table", _at_a_bin, _dumped, check_dumped),
)


# --- Ways to lift something: up from where it stands, or to before the chest.

HEIGHTS_M = (0.18, 0.40)
"""How high things are lifted above where they stand."""
BEFORE_M, BELOW_M = (0.30, 0.42), (0.02, 0.18)
"""How far before the shoulders, and below them, something is held before the chest."""


def _up_from_the_table(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles = thing_at_hand(arrangement).roles
    return arrangement.setting(roles, amounts={"height": float(rng.uniform(*HEIGHTS_M))})


def _before_the_chest(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng)
    roles = thing_at_hand(arrangement).roles
    amounts = {"before": float(rng.uniform(*BEFORE_M)), "below": float(rng.uniform(*BELOW_M))}
    return arrangement.setting(roles, amounts=amounts)


def _lifted(setting: Setting) -> Means:
    roles = setting.roles

    def script(scene: Scene) -> Script:
        x, y, z = Stage(scene).body_position(scene.object_body(roles.thing))
        place = (float(x), float(y), float(z) + setting.amounts["height"])
        return roles.script("lift", "lifted straight up", HoldUp(place, HELD_S))

    return script


def _drawn_near(setting: Setting) -> Means:
    roles, amounts = setting.roles, setting.amounts

    def script(scene: Scene) -> Script:
        place = before_chest(scene, roles, before_m=amounts["before"], below_m=amounts["below"])
        return roles.script("lift", "lifted to before the chest", HoldUp(place, HELD_S))

    return script


LIFT = (
    Way("lift", "straight-up", _up_from_the_table, _lifted),
    Way("lift", "to-the-chest", _before_the_chest, _drawn_near),
)


# --- Ways to tap something: a ball, which rolls on, or something smooth, which slides on.

DIAMETERS_M = (0.06, 0.11)
ROLLING_M = 3e-4
"""Resistance of a ball to rolling: torque over load (ours: of a rubber ball on wood)."""
GRIP = 0.5
"""Friction of a ball, so that it soon rolls."""
SMOOTH = (0.12, 0.20)
"""Friction of smooth things on a table (ours: of polished plastics on polished wood)."""
LOW_M = (((0.07, 0.05), (0.11, 0.075)), ((0.07, 0.09, 0.05), (0.10, 0.14, 0.075)))
"""Least and largest sizes of round and square low things."""
SPEEDS_M_S = {"ball": (0.6, 1.3), "low": (1.1, 1.6)}
"""Greatest speed of the hand."""


@dataclass(frozen=True)
class Sliding(Thing):
    """A thing with a friction of its own.

    Attributes:
        friction: Friction with whatever it stands on: sliding, turning (metres) and rolling (metres).
        ball: Whether it is a ball of its diameter.
    """

    friction: tuple[float, float, float] = (1.0, 0.005, 0.0001)
    ball: bool = False

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        """Give its body its shape."""
        super().add_shapes(body)
        shape = body.first_geom()
        if self.ball:
            shape.type, shape.size = mujoco.mjtGeom.mjGEOM_SPHERE, (self.size_m[0] / 2, 0.0, 0.0)
        shape.friction, shape.condim, shape.priority = self.friction, 6, 1


def a_ball(rng: np.random.Generator) -> Sliding:
    """A ball of any size."""
    diameter = round(float(rng.uniform(*DIAMETERS_M)), 3)
    rolls = (GRIP, ROLLING_M, ROLLING_M)
    return Sliding("ball", (diameter, diameter), NOWHERE, rgba=any_colour(rng), friction=rolls, ball=True)


def something_low(rng: np.random.Generator) -> Sliding:
    """Something low and smooth, round or square."""
    low, high = LOW_M[int(rng.integers(len(LOW_M)))]
    size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
    slides = (round(float(rng.uniform(*SMOOTH)), 3), ROLLING_M, ROLLING_M)
    return Sliding("tub" if len(size) == 2 else "case", size, NOWHERE, rgba=any_colour(rng), friction=slides)


def _with_a_ball(rng: np.random.Generator) -> Setting:
    return _with(rng, a_ball(rng), "ball")


def _with_something_low(rng: np.random.Generator) -> Setting:
    return _with(rng, something_low(rng), "low")


def _with(rng: np.random.Generator, thing: Sliding, kind: str) -> Setting:
    arrangement = around_a_table(rng)
    setting = thing_at_hand(arrangement, thing, distractors=3)
    return arrangement.setting(setting.roles, amounts={"speed": float(rng.uniform(*SPEEDS_M_S[kind]))})


def _tapped(setting: Setting) -> Means:
    roles = setting.roles
    steps = (Tap(roles.thing, roles.side, setting.amounts["speed"]), Withdraw())
    return lambda _scene: replace(roles.script("tap", "pushed with the palm"), steps=steps)


TAP = (Way("tap", "roll", _with_a_ball, _tapped), Way("tap", "slide", _with_something_low, _tapped))


# --- Ways to throw something: into free space, or to the other's side.

AWAY_M, OUTWARD_RAD = (1.6, 2.6), (math.radians(25.0), math.radians(60.0))
"""How far things are thrown into free space, and how far outward from straight ahead."""
THROWING_ASIDE_M, THROWING_AHEAD_M = (0.50, 0.75), (0.0, 0.30)
"""How far to the side of somebody, and before it, what is thrown to it comes down."""
FLIGHT_S = (0.55, 0.80)


def _setting(arrangement: Arrangement, goal: tuple[float, float], setting: Setting) -> Setting:
    flight = {"flight": float(arrangement.rng.uniform(*FLIGHT_S))}
    return arrangement.setting(setting.roles, amounts=flight, places={"goal": (*goal, 0.0)})


def _with_free_space(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND), performer=("standing",))
    setting, person = thing_at_hand(arrangement), arrangement.performer
    away, outward = rng.uniform(*AWAY_M), rng.uniform(*OUTWARD_RAD)
    aside, ahead = float(away * math.sin(outward)), float(away * math.cos(outward))
    return _setting(arrangement, beside(person, setting.roles.side, aside_m=aside, ahead_m=ahead), setting)


def _with_room_beside_the_other(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND), performer=("standing",))
    setting, person = thing_at_hand(arrangement), arrangement.target
    facing = "left" if setting.roles.side == "right" else "right"  # the side that is across from the hand
    aside, ahead = float(rng.uniform(*THROWING_ASIDE_M)), float(rng.uniform(*THROWING_AHEAD_M))
    return _setting(arrangement, beside(person, facing, aside_m=aside, ahead_m=ahead), setting)


def _thrown(setting: Setting) -> Means:
    throw = Throw(setting.places["goal"], setting.amounts["flight"])
    return lambda _scene: setting.roles.script("throw", "thrown underarm", throw, Withdraw())


THROW = (
    Way("throw", "into-free-space", _with_free_space, _thrown),
    Way("throw", "to-the-other", _with_room_beside_the_other, _thrown),
)
