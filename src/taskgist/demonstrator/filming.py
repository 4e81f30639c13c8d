"""Filming: what was acted becomes frames, and frames a recording.

Motions move bodies; what somebody carries moves rigidly with the hand, what was let go by physics; everybody sways a
little and looks somewhere (``gaze``).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.acting import Acting
from taskgist.demonstrator.carry import Carry
from taskgist.demonstrator.sway import SWAYING, sway
from taskgist.world import Stage, State

Array = NDArray[np.float64]

RATE_HZ = 30.0


def filmed(acting: Acting) -> tuple[Array, Array]:
    """Frames of everything but people's gaze.

    Args:
        acting: The performance.

    Returns:
        Times in seconds, (n,), and positions, (n, nq).
    """
    times = np.arange(0.0, acting.now_s, 1.0 / RATE_HZ)
    frames = np.tile(acting.at_rest.qpos, (len(times), 1))
    for moving in acting.motions:
        since, body = times >= moving.start_s, acting.body_of(moving.agent)
        within = np.clip(moving.motion.at(times[since]), *body.ranges_rad.T)  # curves swing a little beyond their knots
        frames[np.ix_(since, body.columns)] = within
    for name in acting.scene.agents:
        joints = acting.scene.agent(name).joints
        if set(SWAYING) <= set(joints):  # robots keep still
            for joint, offsets in sway(times, acting.rng).items():
                frames[:, joints[joint]] += offsets
    for carry in acting.carries:
        _carry(acting, carry, times, frames)
    for flight in acting.flights:
        since = times >= flight.from_s
        frames[since, acting.scene.object_slice(flight.thing)] = flight.poses(times[since])
    return times, frames


def _carry(acting: Acting, carry: Carry, times: Array, frames: Array) -> None:
    """Let a thing follow the hand from where it was in the frame before, and rest where it was put."""
    column = acting.scene.object_slice(carry.thing)
    held = np.flatnonzero((times >= carry.from_s) & (times < carry.until_s))
    palms, turns = _hand_frames(acting, carry, frames[held])
    taken = replace(carry, taken=frames[held[0] - 1, column])
    frames[held, column] = taken.poses(times[held], palms, turns)
    if carry.rest is not None:
        frames[times >= carry.until_s, column] = carry.rest


def _hand_frames(acting: Acting, carry: Carry, frames: Array) -> tuple[Array, Array]:
    """Places (n, 3) and rotations (n, 3, 3) of the hand that carries."""
    stage, arm = Stage(acting.scene), acting.scene.agent(carry.agent or acting.performer).arm(carry.side)
    poses = [stage.show(State(frame)).site(arm.palm_site) for frame in frames]
    return np.array([pose.position for pose in poses]), np.array([pose.matrix for pose in poses])
