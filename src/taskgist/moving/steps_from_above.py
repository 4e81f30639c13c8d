"""Handling things from above, out of the way of walls: steps that take, put into, lift away and turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array
from taskgist.moving.acting import Acting
from taskgist.moving.hand_pose import UP, HandPose, around, sampled
from taskgist.moving.steps import CLOSING_S, EYES_AHEAD_S, OPEN_ASIDE_M, half_height_m, lift_m
from taskgist.world.geometry.transforms import about_z, multiply
from taskgist.world.stage import Stage

OVER_M = 0.10
"""From how high above a thing an open hand comes down to it, and to how high it rises from it."""
CORNER_M = 0.05
"""Ways keep to their corners within this distance, where walls are near."""
TURNED_UP_M = 0.03
"""How high something is lifted to be turned."""
TURNING_STEPS = 5


@dataclass(frozen=True)
class TakeFromAbove:
    """Take a thing with the fingers pointing down.

    Attributes:
        thing: The thing.
        side: The hand.
        dip_rad: How far the fingers point below the horizontal.
        aside_rad: How far they point to the left of where the arm comes from.
    """

    thing: str
    side: str
    dip_rad: float
    aside_rad: float = 0.0

    def play(self, acting: Acting) -> None:
        """Raise the hand, bring it over the thing and down beside it, close it."""
        body, state = acting.body, acting.state
        stage = Stage(acting.scene, state)
        middle = stage.body_position(acting.scene.object_body(self.thing))
        x, y = body.heading_to(state, self.side, middle)
        heading = math.atan2(y, x) + self.aside_rad
        ahead = (math.cos(heading), math.sin(heading))
        hand = around(stage, self.thing, self.side, ahead, dip_rad=self.dip_rad, tip_m=body.tip_m(self.side))
        way = sampled([body.hand(state, self.side), *body.raising(self.side), _over(hand), hand])[1:]
        acting.look(self.thing, ahead_s=EYES_AHEAD_S)
        acting.move(self.side, way, torso_rad=body.torso_for(state, self.side, hand.palm), phase="out")
        acting.wait(CLOSING_S)
        acting.take(self.thing, self.side, hand)


@dataclass(frozen=True)
class PutInto:
    """Put the thing in the hand down between walls: straight down from above.

    Attributes:
        place_m: Where the middle of its underside shall be, (3,).
    """

    place_m: tuple[float, float, float]

    def play(self, acting: Acting) -> None:
        """Carry it over what is on the way, right above its place, and down."""
        carry, body = acting.holding(), acting.body
        stage = Stage(acting.scene)
        start = body.hand(acting.state, carry.side)
        goal, rest = goal_at(acting, self.place_m)
        top = max(start.palm[2], carry.grip.palm[2] + lift_m(stage, carry.thing, start=start.palm, end=goal.palm))
        above = goal.moved((0.0, 0.0, top - goal.palm[2]))
        way = sampled(cornered([start, start.moved((0.0, 0.0, top - start.palm[2])), above, goal]))[1:]
        acting.look(carry.thing)
        acting.move(carry.side, way, torso_rad=body.torso_for(acting.state, carry.side, goal.palm), phase="over")
        acting.release(rest)
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class Turn:
    """Turn the thing in the hand about the vertical, where it stands.

    Attributes:
        angle_rad: How far, to the left.
    """

    angle_rad: float

    def play(self, acting: Acting) -> None:
        """Lift it a little, turn it, set it down."""
        carry, body = acting.holding(), acting.body
        grip, middle = carry.grip, carry.taken[:3]
        shares = np.linspace(0.0, 1.0, TURNING_STEPS)
        turned = [grip.moved(-middle).turned(share * self.angle_rad).moved(middle) for share in shares]
        lifted = [hand.moved((0.0, 0.0, TURNED_UP_M)) for hand in turned]
        acting.look(carry.thing)
        way = sampled([grip, *lifted, turned[-1]])[1:]
        acting.move(carry.side, way, torso_rad=body.posture(acting.state)[:2], phase="over")
        acting.release(np.concatenate((middle, multiply(about_z(self.angle_rad), carry.taken[3:]))))
        acting.wait(CLOSING_S)


@dataclass(frozen=True)
class LiftAway:
    """Take the empty hand up, off the thing, and back to rest.

    Attributes:
        up_m: How high it rises before it turns back.
    """

    up_m: float

    def play(self, acting: Acting) -> None:
        """Open it, raise it, take it back; look at the target agent."""
        body, side = acting.body, acting.acting_side
        hand = body.hand(acting.state, side)
        opened = hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=0.0, up_m=OPEN_ASIDE_M)
        risen = opened.moved((0.0, 0.0, self.up_m))
        way = sampled([hand, opened, risen, *reversed(body.raising(side))])[1:]
        acting.look(acting.target)
        acting.move(side, way, torso_rad=np.zeros(2), phase="back")


def goal_at(
    acting: Acting, place_m: tuple[float, float, float], heading_rad: float | None = None
) -> tuple[HandPose, Array]:
    """The hand that brings what it holds to a place, and the thing's pose (7) there; both turn about the vertical.

    Args:
        acting: The performance.
        place_m: Where the middle of the thing's underside shall be, (3,).
        heading_rad: Where the fingers shall point; None: as the arm comes.
    """
    carry, body = acting.holding(), acting.body
    middle = np.array(place_m) + half_height_m(Stage(acting.scene), carry.thing) * UP
    x, y = body.heading_to(acting.state, carry.side, middle)
    heading = math.atan2(y, x) if heading_rad is None else heading_rad
    turn = heading - carry.grip.heading_rad
    hand = carry.grip.moved(-carry.taken[:3]).turned(turn).moved(middle)
    return hand, np.concatenate((middle, multiply(about_z(turn), carry.taken[3:])))


def cornered(way: list[HandPose]) -> list[HandPose]:
    """A way whose corners are rounded within ``CORNER_M`` only."""
    corners = [way[0]]
    for before, corner, after in zip(way, way[1:], way[2:], strict=False):
        for other in (before, after):
            length = float(np.linalg.norm(other.palm - corner.palm))
            share = CORNER_M / length if length > 2 * CORNER_M else 0.5
            corners.append(corner.toward(other, share))
            if other is before:
                corners.append(corner)
    return [*corners, way[-1]]


def _over(hand: HandPose) -> HandPose:
    """From where an open hand comes down to a thing."""
    return hand.off(aside_m=OPEN_ASIDE_M / 2, back_m=OVER_M / 2, up_m=OVER_M)
