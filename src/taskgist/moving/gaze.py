"""Gaze: where people turn their heads, and how; and what an onlooker looks at.

A **subject** is something to look at, named as everything is: "P1" is a face, "cup" a thing, "P1/right_arm" a hand.
Each fixation begins with a smooth turn of the head and then follows its subject; eyes do the rest, so heads stay within
a comfortable range, and in that of the agent's profile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import SceneError, UnknownNameError
from taskgist.moving.motion import minimum_jerk
from taskgist.world.bodies.agent import Agent, ArmIndices
from taskgist.world.bodies.profile import Axis
from taskgist.world.geometry.transforms import normalized
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import State

TURN_S = 0.4
"""Duration of a turn of the head towards a new subject (for gaze shifts of 40° [Guitton & Volle 1987])."""
COMFORTABLE_PAN_RAD, COMFORTABLE_TILT_RAD = math.radians(60.0), math.radians(30.0)
"""How far a head turns and tilts for a look, though necks do more: eyes do the rest (ours)."""
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
    low, high = np.transpose((_comfortable(pan, COMFORTABLE_PAN_RAD), _comfortable(tilt, COMFORTABLE_TILT_RAD)))
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


def _comfortable(axis: Axis, most_rad: float) -> tuple[float, float]:
    low, high = axis.range_rad
    return max(low, -most_rad), min(high, most_rad)


def _pan_and_tilt(line: Array) -> Array:
    """Angles to the left and upwards, (2,), of a line (3,) in the frame of what carries the head."""
    x, y, z = line
    return np.array([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])


# --- Attention: what an onlooker looks at while somebody acts.
#
# What moves draws the eyes: first the acting hand, then the thing in it, as long as the onlooker has it in view. When
# nothing in view is worth it, people look at each other's faces. The onlooker has a thing in view where a straight
# line from its eye to the thing's middle is free and not too far off its line of sight: simple geometry of its own,
# made with less care than the perspective that later judges what was visible.

NOTICED_RAD = math.radians(75.0)
"""How far off the line of sight a movement is noticed (people notice motion out to about 90°)."""
MOVING_M_S = 0.08
"""Speed from which on something draws attention."""
LOOK_EVERY = 3
"""Frames between two decisions: ten a second at 30 Hz."""
REACTION_S = 0.2
"""From what happens to the onset of the head's turn."""
CLEAR_M = 0.06
"""A line of sight may end so far before a thing's middle: on the fingers around it."""


@dataclass(frozen=True, eq=False)
class Onlooker:
    """Somebody who looks on.

    Attributes:
        name: The agent.
        performer: Whom it watches.
        hand: The acting hand, as a subject.
        thing: The thing that is acted on.
    """

    name: str
    performer: str
    hand: str
    thing: str

    def fixations(self, stage: Stage, times: Array, frames: Array, first: str) -> list[Fixation]:
        """What it looks at, from the first subject on.

        Args:
            stage: The scene; it shows another state afterwards.
            times: Times in seconds, (n,).
            frames: Positions, (n, nq).
            first: What it looks at in the beginning.
        """
        fixations = [Fixation(0.0, first)]
        before = None
        for index in range(0, len(times), LOOK_EVERY):
            stage.show(State(frames[index]))
            now = {subject: subject_place(stage, subject) for subject in (self.hand, self.thing)}
            moving = _moving(before, now, LOOK_EVERY * float(times[1] - times[0]))
            subject = self._subject(stage, fixations[-1].subject, moving)
            if subject != fixations[-1].subject:
                fixations.append(Fixation(float(times[index]) + REACTION_S, subject))
            before = now
        return fixations

    def _subject(self, stage: Stage, present: str, moving: set[str]) -> str:
        """What it looks at next."""
        if self.thing in moving and self._in_view(stage, self.thing, present):
            return self.thing
        if present == self.thing and self._in_view(stage, self.thing, present):
            return self.thing
        if self.hand in moving and self._in_view(stage, self.hand, present):
            return self.hand
        return self.performer if present in (self.hand, self.thing) else present

    def _in_view(self, stage: Stage, subject: str, present: str) -> bool:
        """Whether a subject can be noticed by somebody who looks at the present one."""
        agent = stage.scene.agent(self.name)
        eye = stage.eye(agent).position
        line, sight = subject_place(stage, subject) - eye, subject_place(stage, present) - eye
        if normalized(line) @ normalized(sight) < math.cos(NOTICED_RAD):
            return False
        (geom,), (distance,) = stage.cast(eye, normalized(line)[None], exclude_body=agent.eye_exclude_body)
        met = geom >= 0 and distance < np.linalg.norm(line) - CLEAR_M
        return not met or geom in shapes_of(stage.scene, subject)


def _moving(before: dict[str, Array] | None, now: dict[str, Array], seconds: float) -> set[str]:
    if before is None:
        return set()
    return {subject for subject, place in now.items() if np.linalg.norm(place - before[subject]) > MOVING_M_S * seconds}
