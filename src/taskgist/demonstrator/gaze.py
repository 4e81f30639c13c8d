"""Gaze: where people turn their heads, and how.

A **subject** is something to look at, named as everything is: "P1" is a face, "cup" a thing, "P1/right_arm" a hand.
Each fixation begins with a smooth turn of the head and then follows its subject; eyes do the rest, so heads stay within
a comfortable range (that of the agent's profile).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.motion import minimum_jerk
from taskgist.errors import SceneError, UnknownNameError
from taskgist.world import Agent, ArmIndices, Scene, Stage, State

Array = NDArray[np.float64]
Indices = NDArray[np.intp]

TURN_S = 0.4
"""Duration of a turn of the head towards a new subject (for gaze shifts of 40° [Guitton & Volle 1987])."""
AIMING_ROUNDS = 2
"""Turning the head moves the eye a little: the aim is corrected this often."""


@dataclass(frozen=True)
class Fixation:
    """From some time on, a subject is looked at.

    Attributes:
        from_s: When the head begins to turn there.
        subject: The subject.
        turn_s: How long that takes.
    """

    from_s: float
    subject: str
    turn_s: float = TURN_S


def looked(scene: Scene, name: str, times: Array, frames: Array, fixations: Sequence[Fixation]) -> Array:
    """Angles of an agent's head while it looks from subject to subject.

    Args:
        scene: The scene.
        name: The agent.
        times: Times in seconds, (n,).
        frames: Positions, (n, nq).
        fixations: Its fixations, in order; the first one holds from the beginning.

    Returns:
        Pan and tilt in radians, (n, 2).
    """
    agent, stage = scene.agent(name), Stage(scene)
    angles = np.zeros((len(frames), 2))
    for fixation, shares in zip(fixations, _shares(times, fixations), strict=True):
        during = shares > 0.0
        angles[during] += shares[during, None] * _following(stage, agent, frames[during], fixation.subject)
    return angles


def _shares(times: Array, fixations: Sequence[Fixation]) -> Array:
    """How much each of k fixations decides where the head points, (k, n): one turns it, the next turns it on."""
    turned = np.array([minimum_jerk((times - fixation.from_s) / fixation.turn_s) for fixation in fixations])
    turned[0] = 1.0
    left = np.ones_like(turned)  # by those that come after
    left[:-1] = np.cumprod((1.0 - turned)[:0:-1], axis=0)[::-1]
    return np.asarray(turned * left)


def _following(stage: Stage, agent: Agent, frames: Array, subject: str) -> Array:
    """Pan and tilt (n, 2) of a head that follows a subject through frames (n, nq)."""
    places = [subject_place(stage.show(State(frame)), subject) for frame in frames]
    return aimed(stage, agent, frames, np.reshape(places, (-1, 3)))


def subject_place(stage: Stage, subject: str) -> Array:
    """Where a subject is, metres, (3,).

    Raises:
        UnknownNameError: There is no such agent, object or hand.
    """
    scene = stage.scene
    if subject in scene.agents:
        return stage.eye(scene.agent(subject)).position
    if subject in scene.objects:
        return stage.body_position(scene.object_body(subject))
    return stage.site(_arm(scene, subject).palm_site).position


def shapes_of(scene: Scene, subject: str) -> Indices:
    """Shapes of a subject, (n,): who sees one of them sees the subject.

    Raises:
        UnknownNameError: There is no such agent, object or hand.
    """
    if subject in scene.agents or subject in scene.objects:
        return np.asarray(scene.geoms_of(subject))
    return np.asarray(_arm(scene, subject).hand_geoms)


def _arm(scene: Scene, subject: str) -> ArmIndices:
    """The arm whose hand is a subject."""
    name, _, part = subject.partition("/")
    side = part.removesuffix("_arm")
    if name in scene.agents and part.endswith("_arm") and side in scene.agent(name).sides:
        return scene.agent(name).arm(side)
    raise UnknownNameError("subject to look at", subject, (*scene.agents, *scene.objects))


def aimed(stage: Stage, agent: Agent, frames: Array, places: Array) -> Array:
    """Pan and tilt in radians (n, 2) with which a head faces places (n, 3), within its comfortable range.

    Args:
        stage: The scene; it shows another state afterwards.
        agent: Whose head.
        frames: Positions, (n, nq).
        places: What it faces in each, metres, (n, 3).

    Raises:
        SceneError: The agent has no head to turn.
    """
    pan, tilt = agent.profile.pan, agent.profile.tilt
    if pan is None or tilt is None:
        raise SceneError("demonstrators need a head that pans and tilts", where=agent.name)
    columns = [agent.joints[pan.joint], agent.joints[tilt.joint]]
    low, high = np.transpose((pan.range_rad, tilt.range_rad))
    model = stage.scene.model
    joints = [model.joint(f"{agent.name}/{axis.joint}").id for axis in (pan, tilt)]
    carrier = int(model.body_parentid[model.jnt_bodyid[joints[0]]])
    signs = np.copysign(1.0, (model.jnt_axis[joints[0]][2], -model.jnt_axis[joints[1]][1]))  # some heads tilt downwards
    angles = np.zeros((len(frames), 2))
    for frame, place, towards in zip(frames, places, angles, strict=True):
        posed = np.array(frame)
        for _ in range(AIMING_ROUNDS):
            posed[columns] = towards
            line = place - stage.show(State(posed)).eye(agent).position
            towards[:] = np.clip(signs * _pan_and_tilt(line @ stage.body(carrier).matrix), low, high)
    return angles


def _pan_and_tilt(line: Array) -> Array:
    """Angles to the left and upwards, (2,), of a line (3,) in the frame of what carries the head."""
    x, y, z = line
    return np.array([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
