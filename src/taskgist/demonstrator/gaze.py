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
from taskgist.world import Agent, Scene, Stage, State

Array = NDArray[np.float64]

TURN_S = 0.4
"""Duration of a turn of the head towards a new subject (for gaze shifts of 40° [Guitton & Volle 1987])."""
AIMING_ROUNDS = 2
"""Turning the head moves the eye a little: the aim is corrected this often."""


@dataclass(frozen=True)
class Fixation:
    """From some time on, a subject is looked at."""

    from_s: float
    subject: str


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
    agent = scene.agent(name)
    angles = aimed(scene, agent, frames, subject_places(scene, frames, fixations[0].subject))
    for fixation in fixations[1:]:
        wanted = aimed(scene, agent, frames, subject_places(scene, frames, fixation.subject))
        turned = minimum_jerk((times - fixation.from_s) / TURN_S)[:, None]
        angles = (1.0 - turned) * angles + turned * wanted
    return angles


def subject_places(scene: Scene, frames: Array, subject: str) -> Array:
    """Where a subject is in each frame, metres, (n, 3).

    Raises:
        UnknownNameError: There is no such agent, object or hand.
    """
    stage = Stage(scene)
    return np.array([subject_place(stage.show(State(frame)), subject) for frame in frames])


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
    name, _, part = subject.partition("/")
    if name in scene.agents and part.endswith("_arm"):
        return stage.site(scene.agent(name).arm(part.removesuffix("_arm")).palm_site).position
    raise UnknownNameError("subject to look at", subject, (*scene.agents, *scene.objects))


def aimed(scene: Scene, agent: Agent, frames: Array, places: Array) -> Array:
    """Pan and tilt in radians (n, 2) with which a head faces places (n, 3), within its comfortable range.

    Raises:
        SceneError: The agent has no head to turn.
    """
    pan, tilt = agent.profile.pan, agent.profile.tilt
    if pan is None or tilt is None:
        raise SceneError("demonstrators need a head that pans and tilts", where=agent.name)
    columns = [agent.joints[pan.joint], agent.joints[tilt.joint]]
    low, high = np.transpose((pan.range_rad, tilt.range_rad))
    stage, angles = Stage(scene), np.zeros((len(frames), 2))
    for i, (frame, place) in enumerate(zip(frames, places, strict=True)):
        for _ in range(AIMING_ROUNDS):
            state = State(frame).replace(dict(zip(columns, angles[i], strict=True)))
            angles[i] = np.clip(_angles_to(stage.show(state), agent, place), low, high)
    return angles


def _angles_to(stage: Stage, agent: Agent, place: Array) -> Array:
    """Pan and tilt (2,) of the line from the eye to a place, in the frame of what carries the head."""
    carrier = int(stage.scene.model.body_parentid[agent.eye_exclude_body])
    x, y, z = (place - stage.eye(agent).position) @ stage.body(carrier).matrix
    return np.array([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])
