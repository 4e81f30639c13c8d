"""Steps of a script: wait, take, hold up, put down, withdraw. Each works out its part of an ``Acting``."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.hand import UP, HandPose, around, sampled
from taskgist.demonstrator.places import half_height_m, lift_m
from taskgist.world import Stage
from taskgist.world.geometry.rotations import about_z, multiply

Array = NDArray[np.float64]

EYES_AHEAD_S = 0.3
"""How long the eyes are at a thing before the hand sets out for it [Land & Hayhoe 2001: about half a second]."""
CLOSING_S = 0.25
"""Time in which a hand closes or opens."""
OPEN_ASIDE_M, OPEN_BACK_M, OPEN_UP_M = 0.05, 0.10, 0.05
"""From where an open hand comes to a thing, and to where it leaves it."""
SET_DOWN_M = 0.08
"""From how high a thing is lowered onto its place."""


@dataclass(frozen=True)
class Wait:
    """Do nothing for a while."""

    seconds: float

    def play(self, acting: Acting) -> None:
        """Let time pass."""
        acting.wait(self.seconds)


@dataclass(frozen=True)
class Take:
    """Reach out for a thing and close the hand around it."""

    thing: str
    side: str

    def play(self, acting: Acting) -> None:
        """Raise the hand, bring it beside the thing, close it."""
        body, state = acting.body, acting.state
        stage = Stage(acting.scene, state)
        middle = stage.body_position(acting.scene.object_body(self.thing))
        torso = body.torso_for(state, self.side, middle)
        heading, dip = body.heading_to(state, self.side, middle), body.dip_to(state, self.side, middle, torso)
        hand = around(stage, self.thing, self.side, heading, dip_rad=dip, tip_m=body.tip_m(self.side))
        way = sampled([body.hand(state, self.side), *body.raising(self.side), _open(hand), hand])[1:]
        acting.look(self.thing, ahead_s=EYES_AHEAD_S)
        acting.move(self.side, way, torso_rad=torso, phase="out")
        acting.wait(CLOSING_S)
        acting.take(self.thing, self.side, hand)


@dataclass(frozen=True)
class HoldUp:
    """Bring the thing in the hand to a place in the air and hold it there.

    Attributes:
        place_m: Where its middle shall be, (3,).
        seconds: How long it is held.
    """

    place_m: tuple[float, float, float]
    seconds: float

    def play(self, acting: Acting) -> None:
        """Carry it there, look at the target agent, hold still."""
        goal, _ = _carried_to(acting, np.array(self.place_m))
        carry_to(acting, goal, lower=False)
        acting.look(acting.target)
        acting.wait(self.seconds)


@dataclass(frozen=True)
class PutDown:
    """Put the thing in the hand down.

    Attributes:
        place_m: Where the middle of its underside shall be, on a support, (3,).
    """

    place_m: tuple[float, float, float]

    def play(self, acting: Acting) -> None:
        """Carry it over the place, lower it, open the hand."""
        half_m = half_height_m(Stage(acting.scene), acting.holding().thing)
        middle = np.array(self.place_m) + half_m * UP
        goal, rest = _carried_to(acting, middle)
        carry_to(acting, goal, lower=True)
        acting.release(rest)
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class Withdraw:
    """Take the empty hand back to rest."""

    def play(self, acting: Acting) -> None:
        """Take it off the thing and back, look at the target agent."""
        body, side = acting.body, acting.acting_side
        hand = body.hand(acting.state, side)
        way = sampled([hand, _open(hand), *reversed(body.raising(side))])[1:]
        acting.look(acting.target)
        acting.move(side, way, torso_rad=np.zeros(2), phase="back")


def _open(hand: HandPose) -> HandPose:
    return hand.off(aside_m=OPEN_ASIDE_M, back_m=OPEN_BACK_M, up_m=OPEN_UP_M)


def _carried_to(acting: Acting, middle: Array) -> tuple[HandPose, Array]:
    """The hand that brings what it holds to a place, and the thing's pose (7) there; both turn about the vertical."""
    carry, body = acting.holding(), acting.body
    ahead = body.heading_to(acting.state, carry.side, middle)
    turn = math.atan2(ahead[1], ahead[0]) - carry.grip.heading_rad
    hand = carry.grip.moved(-carry.taken[:3]).turned(turn).moved(middle)
    return hand, np.concatenate((middle, multiply(about_z(turn), carry.taken[3:])))


def carry_to(acting: Acting, goal: HandPose, *, lower: bool) -> None:
    """Carry what is held to where the hand is ``goal``: up, over what lies on the way, and down if it is lowered."""
    carry, body = acting.holding(), acting.body
    start = body.hand(acting.state, carry.side)
    over = lift_m(Stage(acting.scene, acting.state), carry.thing, start=start.palm, end=goal.palm)  # from where it lay
    top = max(carry.grip.palm[2] + over, start.palm[2], goal.palm[2] + (SET_DOWN_M if lower else 0.0))
    raised = [start, start.moved((0.0, 0.0, top - start.palm[2]))]
    lowered = [goal.moved((0.0, 0.0, top - goal.palm[2])), goal] if lower else [goal]
    acting.look(carry.thing)
    torso = body.torso_for(acting.state, carry.side, goal.palm)
    acting.move(carry.side, sampled([*raised, *lowered])[1:], torso_rad=torso, phase="over")
