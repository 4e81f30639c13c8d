"""The head of an agent, as one row of numbers: how its eye moves with it, whatever the rest of the body does.

All is told in the frame that the eye has when the head's joints are in the middle of their ranges: the same from each
stance.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import PAN, TILT
from taskgist.perspective.maps.seen.aiming import (
    AHEAD,
    EYE,
    MOVES,
    START,
    SWING,
    about,
    around,
    outer_axis,
    part_of_head,
    within_head,
)
from taskgist.world.body.profile import Axis

Array = NDArray[np.float64]
SAMPLES = 9
SLACK, SLACK_RAD = 0.02, math.radians(5.0)
"""Between two of the sampled angles the eye goes no farther than this share of its way, the gaze than this angle."""
ORIGIN = np.zeros(3)
AHEAD_IN_MIDDLE = np.array([1.0, 0.0, 0.0])
ALL_ROUND = np.array([way for way in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(way)])


@dataclass(frozen=True, eq=False)
class Head:
    """A head, or one that does not move.

    Attributes:
        numbers: The row for compiled functions.
        middle: Angles in the middle of the ranges by index into qpos, radians.
        low_m: With ``high_m`` the box in which the eye stays, metres, (3,).
        high_m: See ``low_m``.
        gazes: Where it may look, unit vectors some degrees apart, (n, 3).
    """

    numbers: Array
    middle: Mapping[int, float]
    low_m: Array
    high_m: Array
    gazes: Array

    @property
    def stiff(self) -> Head:
        """The same head, that stays as it is now."""
        numbers = np.array(self.numbers)
        numbers[MOVES : MOVES + 2] = 0.0
        _, gaze = _eye_and_gaze(numbers, *numbers[START : START + 4].tolist())
        return replace(self, numbers=numbers, gazes=gaze[None])

    def cones(self, view_rad: float) -> Array:
        """Cones in which lies all that is seen, (n, columns) of ``gaze``: one round the gazes, and others aside.

        Args:
            view_rad: Half the angle of the gaze cone.
        """
        middle = self.gazes.mean(axis=0)
        axes = np.vstack((middle / np.linalg.norm(middle), ALL_ROUND / np.linalg.norm(ALL_ROUND, axis=1)[:, None]))
        limits = np.arccos(np.clip(self.gazes @ axes.T, -1.0, 1.0)).max(axis=0) + SLACK_RAD + view_rad
        narrow = limits < math.pi
        narrow[0] = True
        limits = np.minimum(limits, math.pi)
        return np.asarray(np.column_stack((axes, np.cos(limits), np.sin(limits)))[narrow])


def head_of(here: Standpoint) -> Head:
    """The head of an agent; the stage shows its state afterwards."""
    joints = (here.agent.profile.pan, here.agent.profile.tilt)
    ranges = [_range_rad(here, action, joint) for action, joint in zip((PAN, TILT), joints, strict=True)]
    middle = {
        here.agent.joints[joint.joint]: sum(ends) / 2 for joint, ends in zip(joints, ranges, strict=True) if joint
    }
    stage = here.stage.show(here.state.replace(middle))
    eye = stage.eye(here.agent)
    axes, anchors = np.zeros((2, 3)), np.zeros((2, 3))
    for row, joint in enumerate(joints):
        if joint is not None:
            anchor, axis = stage.screw(_joint_id(here, joint))
            axes[row], anchors[row] = axis @ eye.matrix, eye.to_local(anchor)
    here.stage.show(here.state)
    pan, tilt = (_joint_id(here, joint) for joint in joints)
    inner = 0 if pan > tilt else 1  # bodies, and the joints of one body, are numbered from the root outwards
    now = [
        float(here.state.qpos[here.agent.joints[joint.joint]]) - sum(ends) / 2 if joint else 0.0
        for joint, ends in zip(joints, ranges, strict=True)
    ]
    limits = np.array([((low - high) / 2, (high - low) / 2) for low, high in ranges])
    return _measured(_numbers(inner, axes, anchors, limits, now), inner, limits, middle)


def _range_rad(here: Standpoint, action: str, joint: Axis | None) -> tuple[float, float]:
    """The angles that a joint may take: its present one is always allowed, and the only one if it may not move."""
    if joint is None:
        return 0.0, 0.0
    now = float(here.state.qpos[here.agent.joints[joint.joint]])
    return (min(joint.range_rad[0], now), max(joint.range_rad[1], now)) if action in here.actions else (now, now)


def shapes_of_head(here: Standpoint) -> NDArray[np.intp]:
    """Shapes that the head's joints carry, and those of the body that the eye looks through, (n,)."""
    model, agent = here.stage.scene.model, here.agent
    joints = [_joint_id(here, axis) for axis in (agent.profile.pan, agent.profile.tilt) if axis]
    carried = {agent.eye_exclude_body, *(int(model.jnt_bodyid[joint]) for joint in joints)}
    for body in agent.bodies:  # a parent's index is always below its children's
        if int(model.body_parentid[body]) in carried:
            carried.add(int(body))
    return np.array([geom for geom in agent.geoms if int(model.geom_bodyid[geom]) in carried], dtype=np.intp)


def _joint_id(here: Standpoint, axis: Axis | None) -> int:
    """A joint's place in the model's order, −1 for none."""
    return int(here.stage.scene.model.joint(f"{here.agent.name}/{axis.joint}").id) if axis else -1


def _numbers(inner: int, axes: Array, anchors: Array, limits: Array, now: Sequence[float]) -> Array:
    axis, anchor = axes[inner], anchors[inner]
    parts = []
    for vector, start in ((-anchor, anchor), (AHEAD_IN_MIDDLE, ORIGIN), (np.array([0.0, 1.0, 0.0]), ORIGIN)):
        along = axis * float(axis @ vector)  # Rodrigues' formula, taken apart
        parts += [start + along, vector - along, np.cross(axis, vector)]
    ends = [f(limit) for row in limits for limit in row for f in (math.cos, math.sin, around)]
    start = [f(now[joint]) for joint in (inner, 1 - inner) for f in (math.cos, math.sin)]
    moves = limits[:, 0] < limits[:, 1]
    return np.concatenate(([inner], moves, axes.ravel(), anchors.ravel(), ends, *parts, [0.0], start))


def _measured(numbers: Array, inner: int, limits: Array, middle: Mapping[int, float]) -> Head:
    """A head, with how far its eye moves and its gaze turns at most, from sampled angles."""
    eyes, gazes = [ORIGIN], []
    for angles in itertools.product(*(np.linspace(low, high, SAMPLES) for low, high in limits)):
        inside, outside = angles[inner], angles[1 - inner]
        eye, gaze = _eye_and_gaze(numbers, math.cos(inside), math.sin(inside), math.cos(outside), math.sin(outside))
        eyes.append(eye)
        gazes.append(gaze)
    slack_m = SLACK * float(np.ptp(eyes, axis=0).max())
    numbers[SWING] = float(np.linalg.norm(eyes, axis=1).max()) + slack_m
    low_m, high_m = np.min(eyes, axis=0) - slack_m, np.max(eyes, axis=0) + slack_m
    return Head(numbers, middle, low_m, high_m, np.array(gazes))


def _eye_and_gaze(
    numbers: Array, inner_cos: float, inner_sin: float, outer_cos: float, outer_sin: float
) -> tuple[Array, Array]:
    """Where the eye is, and where it looks, metres and a unit vector, (3,) each."""
    outer = outer_axis(numbers)
    eye, ahead = (within_head(part_of_head(numbers, part), inner_cos, inner_sin) for part in (EYE, AHEAD))
    position = np.array(about(outer, outer_cos, outer_sin, *eye))
    return position, np.array(about(outer, outer_cos, outer_sin, *np.add(eye, ahead))) - position
