"""Handing over: steps in which the target agent acts, too."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.body import Body
from taskgist.demonstrator.hand import UP, HandPose, around, sampled
from taskgist.demonstrator.steps import CLOSING_S, OPEN_ASIDE_M, OPEN_BACK_M
from taskgist.world import Stage
from taskgist.world.geometry.rotations import rotate

Array = NDArray[np.float64]

SETS_OUT_BEFORE_S = 0.4
"""How long before the thing has come the taker's hand sets out: takers do not wait for the giver's hand to stop."""
SHARED_S = 0.35
"""How long both hold it: the giver lets go when the other's grip is felt."""
LYING_M = 0.004
"""Gap between the thumb of a hand that lies on something, and what it lies on."""
FIT_ITERATIONS = 60
"""Most steps of the fit that lays a hand down."""


@dataclass(frozen=True)
class LayHand:
    """A hand lies on a table, palm down, from the beginning on. It comes before all other steps.

    Attributes:
        agent: Whose.
        side: Which hand.
        place_m: The point of the table beneath it, (3,).
    """

    agent: str
    side: str
    place_m: tuple[float, float, float]

    def play(self, acting: Acting) -> None:
        """Let everything begin so."""
        body = acting.body_of(self.agent)
        ahead = rotate(acting.at_rest.qpos[body.agent.base][3:], (1.0, 0.0, 0.0))
        hand = HandPose(np.array(self.place_m) + LYING_M * UP, ahead, -UP)
        torso = body.posture(acting.at_rest)[:2]
        state, _ = body.reaching(acting.at_rest, self.side, hand, torso, iterations=FIT_ITERATIONS)
        acting.begin(state)


@dataclass(frozen=True)
class HandOver:
    """The target agent takes the thing out of the performer's hand, which then lets go.

    Attributes:
        side: The taking hand.
    """

    side: str

    def play(self, acting: Acting) -> None:
        """Let the other hand come, close around the thing, and hold it."""
        pose = acting.held_pose()
        held = acting.state.replace(at=acting.scene.object_slice(acting.holding().thing), to=pose)
        taker = acting.body_of(acting.target)
        hand, torso = _taking(Stage(acting.scene, held), taker, acting.holding().thing, self.side)
        way = sampled([taker.hand(held, self.side), *taker.raising(self.side), _open(hand), hand])[1:]
        with acting.meanwhile(acting.now_s - SETS_OUT_BEFORE_S):
            acting.move(self.side, way, torso_rad=torso, phase="out", agent=acting.target)
        acting.wait(CLOSING_S)
        acting.hand_over(acting.target, self.side, hand)
        acting.wait(SHARED_S)


def _taking(stage: Stage, taker: Body, thing: str, side: str) -> tuple[HandPose, Array]:
    """The hand that takes a thing out of another hand, and the turn and lean of the torso with which it gets there."""
    middle = stage.body_position(stage.scene.object_body(thing))
    torso, heading = taker.torso_for(stage.state, side, middle), taker.heading_to(stage.state, side, middle)
    return around(stage, thing, side, heading, dip_rad=0.0, tip_m=taker.tip_m(side)), torso


def _open(hand: HandPose) -> HandPose:
    """From where an open hand comes to a thing that another hand holds: level, for the thing has no support."""
    return hand.off(aside_m=OPEN_ASIDE_M, back_m=OPEN_BACK_M, up_m=0.0)
