"""Ways to dump something: into a bin on the floor beside oneself, or into one on the table."""

from __future__ import annotations

import numpy as np

from taskgist.demonstrator.generator.rooms import DINING, HIGH, ROUND, around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import beside, thing_at_hand
from taskgist.demonstrator.generator.things import COLOURS, NOWHERE, SMALL, OpenBox, any_of
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.zones import apart, both, handy
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.steps import HoldUp, Withdraw
from taskgist.demonstrator.supports import POINT_SPACING_M
from taskgist.demonstrator.throwing import LetFall
from taskgist.errors import SceneError
from taskgist.recording import Recording
from taskgist.world import Stage, object_points

BIN = "bin"
FLOOR_BIN_M = ((0.24, 0.24, 0.30), (0.32, 0.32, 0.42))
TABLE_BIN_M, RIM_M = ((0.17, 0.17, 0.12), (0.22, 0.22, 0.19)), 0.05
"""Least and largest sizes of bins; and how far the rim is above the middle of what stands in one on the table."""
ASIDE_M, AHEAD_M = (0.42, 0.52), (-0.02, 0.08)
"""How far to the hand's side of the pelvis, and before it, a bin stands on the floor."""
HELD_SHARE = {"sitting": (0.48, 0.56), "standing": (0.56, 0.66)}
"""How high above the floor the thing is held over a bin there, as shares of the stature."""
ABOVE_M = (0.05, 0.12)
"""How high above the rim of a bin on the table its underside is when the hand opens."""
APART_M = 0.40
"""How far a bin on the table is from the performer, at least."""
HELD_S = 0.2


def a_bin(rng: np.random.Generator, low: tuple[float, ...], high: tuple[float, ...]) -> OpenBox:
    """A bin between two sizes."""
    size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
    return OpenBox(BIN, size, NOWHERE, rgba=str(rng.choice(COLOURS)))


def _beside_a_bin(rng: np.random.Generator) -> Setting:
    arrangement = around_a_table(rng, tables=(DINING, ROUND, HIGH))  # beside a sofa there is no room for it
    roles, person = thing_at_hand(arrangement).roles, arrangement.performer
    x, y = beside(person, roles.side, aside_m=rng.uniform(*ASIDE_M), ahead_m=rng.uniform(*AHEAD_M))
    into = arrangement.put_at(a_bin(rng, *FLOOR_BIN_M), np.array([x, y, 0.0]), yaw_rad=person.yaw_rad)
    height = person.stature_m * float(rng.uniform(*HELD_SHARE[person.posture]))
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
    steps = (HoldUp(setting.places["held"], HELD_S), LetFall(dropped=False), Withdraw())
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
    points = object_points(stage, BIN, POINT_SPACING_M)
    low, high = points.min(axis=0), points.max(axis=0)
    if not np.all((low < middle) & (middle < high)):
        hint = "hold it lower, or over the middle"
        raise SceneError(f"{label.target_object!r} missed the bin", where=recording.name, hint=hint)


DUMP = (
    Way("dump", "into-a-bin-on-the-floor", _beside_a_bin, _dumped, check_dumped),
    Way("dump", "into-a-bin-on-the-table", _at_a_bin, _dumped, check_dumped),
)
