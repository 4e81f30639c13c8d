"""Ways to tap something: a ball, which rolls on, or something smooth, which slides on."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from taskgist.demonstrator.furniture import Thing, placed, text
from taskgist.demonstrator.generator.rooms import around_a_table
from taskgist.demonstrator.generator.setting import Setting
from taskgist.demonstrator.generator.spots import thing_at_hand
from taskgist.demonstrator.generator.things import COLOURS, NOWHERE
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.means import Means
from taskgist.demonstrator.steps import Withdraw
from taskgist.demonstrator.tapping import Tap

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

    def mjcf(self) -> str:
        """A free body whose frame is in its middle."""
        x, y, z = self.position_m
        kind = "sphere" if self.ball else "box" if len(self.size_m) == 3 else "cylinder"
        size = [self.size_m[0] / 2] if self.ball else [each / 2 for each in self.size_m]
        rubs = f'friction="{text(self.friction)}" condim="6" priority="1"'
        shape = f'<geom name="{self.name}" type="{kind}" size="{text(size)}" rgba="{self.rgba}" {rubs}/>'
        place = placed((x, y, z + self.height_m / 2), self.yaw_rad)
        return f'<body name="{self.name}" {place}><freejoint/>{shape}</body>'


def a_ball(rng: np.random.Generator) -> Sliding:
    """A ball of any size."""
    diameter = round(float(rng.uniform(*DIAMETERS_M)), 3)
    rolls = (GRIP, ROLLING_M, ROLLING_M)
    return Sliding("ball", (diameter, diameter), NOWHERE, rgba=str(rng.choice(COLOURS)), friction=rolls, ball=True)


def something_low(rng: np.random.Generator) -> Sliding:
    """Something low and smooth, round or square."""
    low, high = LOW_M[int(rng.integers(len(LOW_M)))]
    size = tuple(round(float(each), 3) for each in rng.uniform(low, high))
    slides = (round(float(rng.uniform(*SMOOTH)), 3), ROLLING_M, ROLLING_M)
    return Sliding("tub" if len(size) == 2 else "case", size, NOWHERE, rgba=str(rng.choice(COLOURS)), friction=slides)


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
