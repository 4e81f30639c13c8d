"""Shelving: steps that put the thing in the hand onto a board between others, from the front."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.generator.handling import cornered, goal_at
from taskgist.demonstrator.hand import sampled
from taskgist.demonstrator.places import PASSING_M, lift_m
from taskgist.demonstrator.steps import CLOSING_S, OPEN_ASIDE_M
from taskgist.world import Stage

Array = NDArray[np.float64]

BEFORE_M = 0.22
"""How far before its place a thing is brought to its height."""
FAR_TURN_S = 0.7
"""How long heads turn that turn from one side to the other."""
OVER_BOARD_M = 0.03
"""How high above the board it is moved in."""


@dataclass(frozen=True)
class PutOnBoard:
    """Put the thing in the hand on a board of a shelf.

    Attributes:
        place_m: Where the middle of its underside shall be, (3,).
        front_rad: Where the shelf's open front faces.
    """

    place_m: tuple[float, float, float]
    front_rad: float

    def play(self, acting: Acting) -> None:
        """Carry it before the shelf, move it in, set it down."""
        carry, body = acting.holding(), acting.body
        start = body.hand(acting.state, carry.side)
        x, y = np.array(self.place_m[:2]) - body.shoulder(acting.state, carry.side)[:2]
        goal, rest = goal_at(acting, self.place_m, heading_rad=math.atan2(y, x))
        outwards = BEFORE_M * np.array([math.cos(self.front_rad), math.sin(self.front_rad), 0.0])
        inside = goal.moved((0.0, 0.0, OVER_BOARD_M))
        before = inside.moved(outwards)
        lift = lift_m(Stage(acting.scene), carry.thing, start=start.palm, end=start.palm) + PASSING_M
        raised = start.moved((0.0, 0.0, max(lift, before.palm[2] - start.palm[2])))
        acting.look(carry.thing)
        torso = body.torso_for(acting.state, carry.side, goal.palm)
        over = before.moved((0.0, 0.0, max(0.0, raised.palm[2] - before.palm[2])))
        way = sampled(cornered([start, raised, over, before, inside, goal]))[1:]
        acting.move(carry.side, way, torso_rad=torso, phase="over")
        acting.release(rest)
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class DrawBack:
    """Take the empty hand straight back out, then to rest."""

    def play(self, acting: Acting) -> None:
        """Open it, draw it back, take it home; look at the target agent."""
        body, side = acting.body, acting.acting_side
        hand = body.hand(acting.state, side)
        opened = hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=OPEN_ASIDE_M, up_m=OVER_BOARD_M / 2)
        out = hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=BEFORE_M, up_m=OVER_BOARD_M)
        way = sampled([hand, opened, out, *reversed(body.raising(side))])[1:]
        acting.look(acting.target, turn_s=FAR_TURN_S)
        acting.move(side, way, torso_rad=np.zeros(2), phase="back")
