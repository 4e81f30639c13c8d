"""Steps of a script: wait, take, hold up, put down, hand over, withdraw. Each works out its part of an ``Acting``."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.acting import Acting
from taskgist.moving.body import LARGEST_ERROR_M, Body
from taskgist.moving.hand_pose import UP, HandPose, around, sampled
from taskgist.world.contacts import object_points
from taskgist.world.geometry.transforms import about_z, multiply, rotate
from taskgist.world.stage import Stage

# --- Over things: how high what is carried must be lifted to pass over what lies on its way.

POINT_SPACING_M = 0.02
CORRIDOR_M = 0.09
"""Things nearer than this to the way of a carried thing are passed over."""
PASSING_M = 0.05
"""Gap with which they are passed over, and least lift."""


def half_height_m(stage: Stage, thing: str) -> float:
    """Height of the frame of a thing over its underside."""
    frame = stage.body_position(stage.scene.object_body(thing))
    return float(frame[2] - object_points(stage, thing, POINT_SPACING_M)[:, 2].min())


def lift_m(stage: Stage, thing: str, *, start: Array, end: Array) -> float:
    """How high a thing must be lifted to pass over what lies on its way, in metres.

    Args:
        stage: The scene, with the thing where it is lifted from.
        thing: The thing.
        start: Where the way begins, (3,).
        end: Where it ends, (3,).
    """
    bottom = object_points(stage, thing, POINT_SPACING_M)[:, 2].min()
    tops = [bottom]
    for other in stage.scene.objects:
        if other != thing:
            points = object_points(stage, other, POINT_SPACING_M)
            tops += points[_distance_m(points[:, :2], start[:2], end[:2]) < CORRIDOR_M, 2].tolist()
    return float(max(tops) - bottom + PASSING_M)


def _distance_m(points: Array, start: Array, end: Array) -> Array:
    """Distances (n,) of points (n, 2) from a segment."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * along, axis=1))


# --- The steps of one performer: wait, take, hold up, put down, withdraw.

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
        looks_at: What the performer looks at then, as a subject of ``gaze``; None: the target agent.
    """

    place_m: tuple[float, float, float]
    seconds: float
    looks_at: str | None = None

    def play(self, acting: Acting) -> None:
        """Carry it there, look at somebody or something, hold still."""
        goal, _ = carried_to(acting, np.array(self.place_m))
        carry_to(acting, goal, lower=False)
        acting.look(self.looks_at or acting.target)
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
        goal, rest = carried_to(acting, middle)
        carry_to(acting, goal, lower=True)
        acting.release(rest)
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class Withdraw:
    """Take the empty hand back to rest.

    Attributes:
        side: Which hand; None: that which acted last.
    """

    side: str | None = None

    def play(self, acting: Acting) -> None:
        """Take it off the thing and back, look at the target agent."""
        body, side = acting.body, self.side or acting.acting_side
        hand = body.hand(acting.state, side)
        way = sampled([hand, _open(hand), *reversed(body.raising(side))])[1:]
        acting.look(acting.target)
        acting.move(side, way, torso_rad=np.zeros(2), phase="back")


def _open(hand: HandPose) -> HandPose:
    return hand.off(aside_m=OPEN_ASIDE_M, back_m=OPEN_BACK_M, up_m=OPEN_UP_M)


def carried_to(acting: Acting, middle: Array) -> tuple[HandPose, Array]:
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


# --- Handing over: steps in which the target agent acts, too.

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
        hand, torso = taking(Stage(acting.scene, held), taker, acting.holding().thing, self.side)
        way = sampled([taker.hand(held, self.side), *taker.raising(self.side), open_level(hand), hand])[1:]
        with acting.meanwhile(acting.now_s - SETS_OUT_BEFORE_S):
            acting.move(self.side, way, torso_rad=torso, phase="out", agent=acting.target)
        acting.wait(CLOSING_S)
        acting.hand_over(acting.target, self.side, hand)
        acting.wait(SHARED_S)


def taking(stage: Stage, taker: Body, thing: str, side: str) -> tuple[HandPose, Array]:
    """The hand that takes a thing out of another hand, and the turn and lean of the torso with which it gets there."""
    middle = stage.body_position(stage.scene.object_body(thing))
    torso, heading = taker.torso_for(stage.state, side, middle), taker.heading_to(stage.state, side, middle)
    return around(stage, thing, side, heading, dip_rad=0.0, tip_m=taker.tip_m(side)), torso


def open_level(hand: HandPose) -> HandPose:
    """From where an open hand comes to a thing that another hand holds: level, for the thing has no support."""
    return hand.off(aside_m=OPEN_ASIDE_M, back_m=OPEN_BACK_M, up_m=0.0)


# --- Holding from the beginning: somebody has a thing in the hand before anything happens.


@dataclass(frozen=True)
class Held:
    """The performer holds a thing from the beginning on. It comes before all steps that move.

    Attributes:
        thing: The thing.
        side: The hand.
        place_m: Where the thing's middle is, (3,).
    """

    thing: str
    side: str
    place_m: tuple[float, float, float]

    def play(self, acting: Acting) -> None:
        """Let everything begin so.

        Raises:
            SceneError: The hand does not get there.
        """
        column, body = acting.scene.object_slice(self.thing), acting.body
        pose = np.array(acting.at_rest.qpos[column])
        pose[:3] = self.place_m
        holding = acting.at_rest.replace(at=column, to=pose)
        heading = body.heading_to(holding, self.side, pose[:3])
        tip_m = body.tip_m(self.side)
        hand = around(Stage(acting.scene, holding), self.thing, self.side, heading, dip_rad=0.0, tip_m=tip_m)
        torso = body.posture(holding)[:2]
        state, error = body.reaching(holding, self.side, hand, torso, iterations=FIT_ITERATIONS)
        if error > LARGEST_ERROR_M:
            hint = "hold it nearer to the shoulder"
            raise SceneError("the hand does not get there", where=acting.performer, field=self.thing, hint=hint)
        acting.begin(state, returning=body)
        acting.take(self.thing, self.side, hand)
        acting.carries[-1] = replace(acting.carries[-1], from_s=0.0)
