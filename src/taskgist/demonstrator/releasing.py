"""Releasing: a hand lets go of what it holds, or pushes what lies, and physics moves it on."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.flight import Flight
from taskgist.demonstrator.hand import HandPose
from taskgist.errors import SceneError
from taskgist.world import FreeMotion, State, free_motion
from taskgist.world.geometry.rotations import conjugate, multiply

Array = NDArray[np.float64]

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
