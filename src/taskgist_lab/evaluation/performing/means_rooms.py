"""Rooms for means besides moving the thing: it is to be covered, the view to it cleared, or help is needed.

Each is random as ``rooms`` are, and made so that the means makes sense; whether a robot's hand, arm and way allow it is
not asked::

    cover   a small thing before the target agent, and elsewhere on the table a dome with a knob that has room for it
    clear   a thing before the target agent, and between both an upright carton that a hand takes at its narrow side
    relay   a counter that nobody gets around; the performer and the thing on this side, and on the other the target
            agent, a shelf with a screen on it, and another robot
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from taskgist.planning.plan import Purpose
from taskgist.world.scene import Scene
from taskgist_lab.evaluation.performing.rooms import HEIGHT_M, ROBOT, TARGET, THING
from taskgist_lab.generator.furnishing import any_place
from taskgist_lab.generator.things import COVERABLE, OpenBox, any_colour, any_of, at, cover_for, radius_m
from taskgist_lab.simulator.room import Furniture, Person, Room, Table, Thing, add_box

HELPER = "R2"
"""Name of the robot that helps."""
TASK_OF: Mapping[Purpose, str] = {"cover": "hide", "clear": "show", "relay": "hide"}
"""Which task each means is measured with."""
KNOB_M = (0.03, 0.03, 0.05)
DEEP_M, TALL_M = (0.65, 0.90), (0.68, 0.76)
CARTON_M = ((0.03, 0.20, 0.20), (0.06, 0.30, 0.28))
COUNTER_M, LONG_M = (0.6, 0.8), 19.0
"""Depth of a counter, and its length: nobody gets around it, nor beneath it, for it is closed."""


@dataclass(frozen=True)
class Dome(OpenBox):
    """A cover, open below, with a knob on top that a hand takes; its size is that without the knob."""

    def add_shapes(self, body: mujoco.MjsBody) -> None:
        """Give its body its shapes."""
        super().add_shapes(body)
        add_box(body, KNOB_M, (0.0, 0.0, (self.height_m + KNOB_M[2]) / 2), self.rgba)


def room_for(means: Purpose, robot: str, seed: int, number: int) -> Scene:
    """A room for a means, with robots of a profile.

    Args:
        means: Cover, clear or relay.
        robot: Profile of the performer, and of who helps.
        seed: Seed of all rooms.
        number: Which of them.
    """
    rng = np.random.default_rng((seed, number, list(TASK_OF).index(means)))
    people, things, furniture = {"cover": _cover, "clear": _clear, "relay": _relay}[means](rng, robot)
    table, *others = furniture
    assert isinstance(table, Table)
    return Room(f"{means}-{seed}-{number:04d}", people, things, table, tuple(others)).scene()


Parts = tuple[tuple[Person, ...], tuple[Thing, ...], tuple[Furniture, ...]]


def _at_table(rng: np.random.Generator, robot: str) -> tuple[tuple[Person, ...], Table]:
    """A table, somebody who sits or stands at it, and a robot on another side."""
    deep, tall = float(rng.uniform(*DEEP_M)), float(rng.uniform(*TALL_M))
    table = Table("table", size_m=(round(deep, 3), round(float(rng.uniform(1.2, 1.8)), 3), round(tall, 3)))
    sits = bool(rng.random() < 0.7)
    away = deep / 2 + float(rng.uniform(0.28, 0.4))
    target = Person(TARGET, 1.7, (round(away, 3), round(float(rng.uniform(-0.2, 0.2)), 3)), math.pi)
    target = replace(target, posture="sitting" if sits else "standing")
    place = (-round(deep / 2 + float(rng.uniform(0.9, 1.6)), 3), round(float(rng.uniform(-0.8, 0.8)), 3))
    performer = Person(ROBOT, HEIGHT_M, place, round(float(rng.uniform(-0.5, 0.5)), 3), "standing", profile=robot)
    return (performer, target), table


def _cover(rng: np.random.Generator, robot: str) -> Parts:
    people, table = _at_table(rng, robot)
    thing = replace(any_of(rng, COVERABLE), name=THING)
    dome = cover_for(rng, thing)
    dome = Dome("dome", dome.size_m, dome.position_m, rgba=dome.rgba, upside_down=True)
    x, y = float(rng.uniform(-0.1, 0.1)), float(rng.uniform(-0.25, 0.25))
    spot, yaw = np.array([x, y, table.height_m]), float(rng.uniform(-math.pi, math.pi))
    apart = radius_m(thing) + 2 * radius_m(dome) + 0.03
    while True:
        other = any_place(table, rng, radius_m(dome) + 0.02)
        if np.linalg.norm(other[:2] - spot[:2]) > apart:
            return people, (at(thing, spot, yaw), at(dome, other, float(rng.uniform(-math.pi, math.pi)))), (table,)


def _clear(rng: np.random.Generator, robot: str) -> Parts:
    people, table = _at_table(rng, robot)
    thing = replace(any_of(rng, COVERABLE), name=THING)
    size = tuple(round(float(each), 3) for each in rng.uniform(*CARTON_M))
    carton = Thing("carton", size, (0.0, 0.0, 0.0), rgba=any_colour(rng))
    spot = np.array([float(rng.uniform(-0.15, 0.0)), float(rng.uniform(-0.15, 0.15)), table.height_m])
    toward = np.array(people[1].position_m) - spot[:2]
    toward /= np.linalg.norm(toward)
    gap = radius_m(thing) + size[0] / 2 + float(rng.uniform(0.02, 0.05))
    between = np.array([*(spot[:2] + gap * toward), table.height_m])
    facing = math.atan2(toward[1], toward[0])
    return people, (at(thing, spot, float(rng.uniform(-math.pi, math.pi))), at(carton, between, facing)), (table,)


def _relay(rng: np.random.Generator, robot: str) -> Parts:
    deep, tall = round(float(rng.uniform(*COUNTER_M)), 3), round(float(rng.uniform(*TALL_M)), 3)
    counter, half = Table("counter", size_m=(deep, LONG_M, tall), board_m=round(tall - 0.05, 3)), deep / 2
    y = round(float(rng.uniform(0.6, 1.4)), 3)
    shelf = Table("shelf", (round(half + float(rng.uniform(1.5, 1.9)), 3), y), (0.45, 1.0, tall))
    thing = replace(any_of(rng, COVERABLE), name=THING)
    spot = np.array([-half + float(rng.uniform(0.12, 0.25)), float(rng.uniform(-0.4, 0.4)), tall])
    screen = Thing("screen", (0.3, 0.06, 0.3), (shelf.centre_m[0], y + round(float(rng.uniform(-0.1, 0.1)), 3), tall))
    performer = Person(
        ROBOT, HEIGHT_M, (-half - 1.0, 0.0), round(float(rng.uniform(-0.5, 0.5)), 3), "standing", profile=robot
    )
    helper = Person(HELPER, HEIGHT_M, (half + 0.8, y - 0.3), math.pi, "standing", profile=robot)
    target = Person(TARGET, 1.7, (half + 0.4, round(y - 1.7, 3)), math.pi, "standing")
    return (performer, helper, target), (at(thing, spot, 0.0), screen), (counter, shelf)
