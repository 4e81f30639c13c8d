"""Dropping, throwing and tapping: steps that end with a thing on its own way."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from taskgist.common.arrays import Array
from taskgist.errors import SceneError
from taskgist.moving.acting import Acting, Flight
from taskgist.moving.hand_pose import SIGNS, UP, HandPose, around, sampled
from taskgist.moving.steps import EYES_AHEAD_S, carry_to
from taskgist.world.contacts import hand_gap_m
from taskgist.world.dynamics import GRAVITY_M_S2, FreeMotion, free_motion
from taskgist.world.geometry.transforms import conjugate, multiply, normalized
from taskgist.world.stage import Stage
from taskgist.world.state import State

# --- Releasing: a hand lets go of what it holds, or pushes what lies, and physics moves it on.

DIFFERENCE_S = 0.004
"""Half the time over which a hand's velocity is measured."""
LEAST_IN_AIR_S = 0.30
"""What is dropped or thrown is in the air for so long, at least: less is a putting down."""
IN_AIR_SHARE = 0.65
"""A demonstration that ends in the air ends after this share of the time there."""


def let_go(acting: Acting, at_s: float) -> FreeMotion:
    """Let what the performer holds move by physics from some time on, with the velocity that the hand has then.

    Args:
        acting: The performance.
        at_s: When the hand lets go; within its last motion, or after it.

    Returns:
        The motion, which has become a flight of the performance.
    """
    carry = acting.holding()
    times = at_s + DIFFERENCE_S * np.array([-1.0, 0.0, 1.0])
    before, pose, after = (carry.pose(hand_at(acting, carry.side, time)) for time in times)
    acting.carries[-1] = replace(carry, until_s=at_s)
    return set_going(acting, carry.thing, at_s, pose, velocities(before, after, 2 * DIFFERENCE_S))


def set_going(acting: Acting, thing: str, at_s: float, pose: Array, velocity: tuple[Array, Array]) -> FreeMotion:
    """Let a thing move by physics from a time, a pose (7) and velocities on; the acting arm is not in its way."""
    state = state_at(acting, at_s).replace(at=acting.scene.object_slice(thing), to=pose)
    arm = f"{acting.performer}/{acting.acting_side}_arm"
    linear, angular = velocity
    motion = free_motion(acting.scene, state, thing, linear_m_s=linear, angular_rad_s=angular, passing=[arm])
    acting.flights.append(Flight(thing, at_s, motion))
    acting.state = acting.state.replace(at=acting.scene.object_slice(thing), to=motion.end)
    return motion


def ends_in_air(acting: Acting, since_s: float, motion: FreeMotion) -> None:
    """Say that the demonstration is over while a thing that was let go is in the air.

    Raises:
        SceneError: It meets something too soon.
    """
    if motion.touches_s < LEAST_IN_AIR_S:
        raise SceneError(
            f"it is in the air for less than {LEAST_IN_AIR_S:g} s",
            where=acting.performer,
            field=acting.last_carry().thing,
            value=round(motion.touches_s, 3),
            hint="let it go from higher up, or clear its way",
        )
    acting.over_s = since_s + IN_AIR_SHARE * min(motion.touches_s, motion.duration_s)


def watch(acting: Acting, until_s: float) -> None:
    """Let time pass until a thing that was let go has come to rest."""
    acting.now_s = max(acting.now_s, until_s)


def state_at(acting: Acting, at_s: float) -> State:
    """The performance at a time of its last motion, or after it; but things are where they are now."""
    body, motion = acting.body, acting.motions[-1].motion
    posture = np.clip(motion.at(np.array([at_s]))[0], *body.ranges_rad.T)
    return body.with_posture(acting.state, posture)


def hand_at(acting: Acting, side: str, at_s: float) -> HandPose:
    """Where the performer's hand is at a time of its last motion, or after it."""
    return acting.body.hand(state_at(acting, at_s), side)


def velocities(before: Array, after: Array, seconds: float) -> tuple[Array, Array]:
    """Linear (3,) and angular (3,) velocity in m/s and rad/s between two poses (7), in the world."""
    turn = multiply(after[3:], conjugate(before[3:]))
    sine = float(np.linalg.norm(turn[1:]))
    angle = 2.0 * math.atan2(sine, abs(float(turn[0])))
    axis = turn[1:] / max(sine, np.finfo(float).tiny) * math.copysign(1.0, turn[0])
    return (after[:3] - before[:3]) / seconds, angle / seconds * axis


# --- The swing of a throwing arm: how fast and how steeply a hand must go for a thing to come down at a goal.

WRIST_RAD = math.radians(40.0)
"""How far the fingers point above the line of the arm."""
AIMING_ROUNDS = 4
"""How often the aim is corrected: where a hand lets go depends on how steeply it throws, and the reverse."""


@dataclass(frozen=True, eq=False)
class Swing:
    """An underarm swing about the shoulder.

    Attributes:
        shoulder: About which the arm swings, metres, (3,).
        radius_m: Distance of the palm from there.
        ahead: Horizontal unit direction in which it throws, (3,).
        side: Which hand.
        rise_rad: How steeply upwards it throws.
        speed_m_s: How fast the thing is when the hand lets go.
    """

    shoulder: Array
    radius_m: float
    ahead: Array
    side: str
    rise_rad: float = 0.0
    speed_m_s: float = 1.0

    @classmethod
    def to(cls, goal: Array, *, flight_s: float, shoulder: Array, radius_m: float, side: str) -> Swing:
        """The swing that sends a thing to a goal, metres, (3,), in some time."""
        ahead = normalized((goal - shoulder) * (1.0, 1.0, 0.0))
        swing = cls(shoulder, radius_m, ahead, side)
        for _ in range(AIMING_ROUNDS):
            velocity = velocity_to(swing.hand(0.0).palm, goal, flight_s)
            rise = math.atan2(velocity[2], float(velocity @ ahead))
            swing = cls(shoulder, radius_m, ahead, side, rise, float(np.linalg.norm(velocity)))
        return swing

    def hand(self, angle_rad: float) -> HandPose:
        """The hand at an angle beyond (positive) or before where it lets go."""
        angle = self.rise_rad + angle_rad
        palm = self.shoulder + self.radius_m * (math.sin(angle) * self.ahead - math.cos(angle) * UP)
        pitch = angle - math.pi / 2 + WRIST_RAD
        fingers = math.cos(pitch) * self.ahead + math.sin(pitch) * UP
        return HandPose(palm, fingers, SIGNS[self.side] * np.cross(UP, self.ahead))


def velocity_to(release: Array, goal: Array, flight_s: float) -> Array:
    """Velocity in m/s, (3,), with which a thing flies from where it is let go to a goal in some time."""
    return np.asarray((goal - release) / flight_s + GRAVITY_M_S2 * flight_s / 2 * UP)


# --- Tapping: a hand pushes a thing that lies still, which then slides or rolls on by itself.

BEFORE_M, BEYOND_M = 0.12, 0.05
"""How far from the thing a hand begins to push, and how far it goes on."""
TOUCHING_M = 0.002
"""Gap between hand and thing at which it is pushed."""
LOOKED_AT = 120
"""Moments of the push that are looked at."""
MOVES_S = 0.30
"""What was tapped moves for so long, at least: less is a nudge."""
PEAK = 1.875
"""Greatest speed of a minimum-jerk movement over its mean speed."""
MOVING_SHARE, LONGEST_S = 0.65, 0.8
"""The demonstration ends after this share of the time for which it is seen to move on its support, and so much at
most."""
LEVEL_M = 0.005
"""How much its height changes, at most, while it is on its support."""
SEEN_M_S = 0.10
"""Speed from which on people see something move on a table."""
STAYS_S = 0.4


@dataclass(frozen=True)
class Tap:
    """Push a thing with the palm, so that it moves on by itself.

    Attributes:
        thing: The thing.
        side: The hand.
        speed_m_s: Greatest speed of the hand.
    """

    thing: str
    side: str
    speed_m_s: float

    def play(self, acting: Acting) -> None:
        """Bring the open hand beside the thing, push, stop.

        Raises:
            SceneError: The hand does not meet the thing, or hardly moves it.
        """
        hand, torso = self._beside(acting)
        start, end = hand.moved(-BEFORE_M * hand.facing), hand.moved(BEYOND_M * hand.facing)
        body = acting.body
        acting.look(self.thing, ahead_s=EYES_AHEAD_S)
        way = sampled([body.hand(acting.state, self.side), *body.raising(self.side), start.moved(BEFORE_M * UP), start])
        acting.move(self.side, way[1:], torso_rad=torso, phase="out")
        since_s, duration_s = acting.now_s, PEAK * (BEFORE_M + BEYOND_M) / self.speed_m_s
        acting.move(self.side, sampled([start, end])[1:], torso_rad=torso, phase="over", duration_s=duration_s)
        at_s = self._met_s(acting, since_s, duration_s)
        motion = self._push(acting, at_s)
        acting.over_s = at_s + min(MOVING_SHARE * self._moving_s(acting, motion), LONGEST_S)
        acting.wait(STAYS_S)
        watch(acting, acting.over_s + STAYS_S)

    def _beside(self, acting: Acting) -> tuple[HandPose, Array]:
        """The hand against the thing's side, and the torso's turn and lean with which it gets there."""
        body, state = acting.body, acting.state
        stage = Stage(acting.scene, state)
        middle = stage.body_position(acting.scene.object_body(self.thing))
        torso = body.torso_for(state, self.side, middle)
        heading, dip = body.heading_to(state, self.side, middle), body.dip_to(state, self.side, middle, torso)
        return around(stage, self.thing, self.side, heading, dip_rad=dip, tip_m=body.tip_m(self.side)), torso

    def _met_s(self, acting: Acting, since_s: float, duration_s: float) -> float:
        """When the pushing hand meets the thing."""
        stage, arm = Stage(acting.scene), acting.body.agent.arm(self.side)
        for time in np.linspace(since_s, since_s + duration_s, LOOKED_AT):
            stage.show(state_at(acting, float(time)))
            if hand_gap_m(stage, arm, self.thing, limit_m=2 * TOUCHING_M) < TOUCHING_M:
                return float(time)
        raise SceneError("the hand passes it", where=acting.performer, field=self.thing, hint="clear the way to it")

    def _push(self, acting: Acting, at_s: float) -> FreeMotion:
        """Let the thing move on with the hand's velocity over the support."""
        after, before = (hand_at(acting, self.side, at_s + step) for step in (DIFFERENCE_S, -DIFFERENCE_S))
        velocity = (after.palm - before.palm) / (2 * DIFFERENCE_S) * (1.0, 1.0, 0.0)
        pose = np.array(acting.state.qpos[acting.scene.object_slice(self.thing)])
        return set_going(acting, self.thing, at_s, pose, (velocity, np.zeros(3)))

    def _moving_s(self, acting: Acting, motion: FreeMotion) -> float:
        """For how long it is seen to move on its support."""
        places = motion.poses[:, :3]
        speeds = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.diff(motion.times_s)
        seen = (speeds > SEEN_M_S) & (np.abs(places[1:, 2] - places[0, 2]) < LEVEL_M)
        moving_s = float(motion.times_s[1:][~seen].min(initial=motion.duration_s))
        if moving_s < MOVES_S:
            raise SceneError(
                f"it moves on for less than {MOVES_S:g} s",
                where=acting.performer,
                field=self.thing,
                value=round(moving_s, 3),
                hint="tap it faster, or tap something that rolls",
            )
        return moving_s


ARM_SHARE = 0.72
"""Share of the arm's length at which a throwing hand swings about its shoulder."""
BACK_RAD, ON_RAD = math.radians(30.0), math.radians(30.0)
"""How far it swings before and behind where it lets go."""
SWING_KNOTS, MOMENTS = 8, 100
"""Hands on the way of a swing, and moments of it at which its speed is looked at."""
WATCHED_S = 1.2
"""How long somebody watches what it has thrown before it takes the hand back, at most."""


@dataclass(frozen=True)
class LetFall:
    """Let go of what is held.

    Attributes:
        dropped: Whether the demonstration is over while it falls; else once it rests.
    """

    dropped: bool

    def play(self, acting: Acting) -> None:
        """Open the hand and watch it fall.

        Raises:
            SceneError: It is dropped, but does not fall far enough; or it shall rest, and rolls on and on.
        """
        since_s, thing = acting.now_s, acting.holding().thing
        motion = let_go(acting, since_s)
        acting.look(thing)
        if self.dropped:
            ends_in_air(acting, since_s, motion)
        elif not motion.rests:
            raise SceneError("it does not come to rest", where=acting.performer, field=thing, hint="let it fall lower")
        acting.wait(STAYS_S)
        watch(acting, since_s + motion.duration_s)


@dataclass(frozen=True)
class Throw:
    """Throw what is held, underarm: the arm swings about its shoulder and lets go half-way.

    Attributes:
        goal_m: Where it shall come down, (3,).
        flight_s: How long it shall fly there.
    """

    goal_m: tuple[float, float, float]
    flight_s: float

    def play(self, acting: Acting) -> None:
        """Bring it to where the swing begins, swing, let go, watch it fly.

        Raises:
            SceneError: It meets something too soon, or the hand does not get there.
        """
        thing, swing = acting.holding().thing, _aimed(acting, np.array(self.goal_m), self.flight_s)
        carry_to(acting, swing.hand(-BACK_RAD), lower=False)
        acting.look(acting.target)
        released_s = _swung(acting, swing)
        motion = let_go(acting, released_s)
        acting.look(thing)
        ends_in_air(acting, released_s, motion)
        acting.wait(STAYS_S)
        watch(acting, released_s + min(motion.duration_s, WATCHED_S))


def _aimed(acting: Acting, goal: Array, flight_s: float) -> Swing:
    """The swing of the acting hand that sends what it holds to a goal."""
    body, side = acting.body, acting.holding().side
    radius = ARM_SHARE * body.agent.arm(side).profile.length_m
    return Swing.to(goal, flight_s=flight_s, shoulder=body.shoulder(acting.state, side), radius_m=radius, side=side)


def _swung(acting: Acting, swing: Swing) -> float:
    """Let the hand swing, so fast that it has the right speed where it lets go; gives when that is."""
    carry, since_s = acting.holding(), acting.now_s
    way = [swing.hand(angle) for angle in np.linspace(-BACK_RAD, ON_RAD, SWING_KNOTS)[1:]]
    torso = acting.body.posture(acting.state)[:2]
    acting.move(carry.side, way, torso_rad=torso, phase="over", duration_s=1.0)
    hands = [hand_at(acting, carry.side, since_s + share) for share in np.linspace(0.0, 1.0, MOMENTS + 1)]
    nearest = int(np.argmin([np.linalg.norm(hand.palm - swing.hand(0.0).palm) for hand in hands[1:-1]])) + 1
    before, after = (carry.pose(hands[nearest + step])[:3] for step in (-1, 1))
    speed_m_s = float(np.linalg.norm(after - before)) * MOMENTS / 2
    duration_s = speed_m_s / swing.speed_m_s  # it took a second, and was that fast
    swung = acting.motions[-1]
    acting.motions[-1] = replace(swung, motion=replace(swung.motion, duration_s=duration_s))
    acting.now_s = since_s + duration_s
    return float(since_s + nearest / MOMENTS * duration_s)
