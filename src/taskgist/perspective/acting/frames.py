"""The frames of an agent that abilities depend on: its eye, the joints of its head, and its shoulders.

Frames are rows of 12 numbers, position and then orientation, as compiled functions take them: the eye first, then the
joints of the head (a point of the axis, and the axis as x), then the shoulders.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.virtual_actions import PAN, TILT
from taskgist.world import Agent, Linkage, Pose, Stage

Array = NDArray[np.float64]
EYE = 0
"""Which of the frames is the eye."""


@dataclass(frozen=True)
class HeadJoint:
    """A joint of the head: the virtual action that moves it, its index into qpos, range and present angle in radians.

    ``depth`` is the joint's place in the model's order: of two joints of a head, the later one is carried by the other.
    """

    action: str
    index: int
    range_rad: tuple[float, float]
    now_rad: float
    depth: int


class Neck(NamedTuple):
    """The usable joints of a head, as compiled functions take them.

    Attributes:
        frames: Which of the agent's frames each is, (h,).
        inwards: Their order from the eye to the base, (h,).
        now: Their present angles, radians, (h,).
        ranges: The angles that they may take, radians, (h, 2): the present one is always allowed.
    """

    frames: NDArray[np.intp]
    inwards: NDArray[np.intp]
    now: Array
    ranges: Array


@dataclass(frozen=True, eq=False)
class UsableHead:
    """Those joints of a head that may be used."""

    joints: tuple[HeadJoint, ...]
    neck: Neck

    @classmethod
    def of(cls, head: Sequence[HeadJoint], actions: frozenset[str]) -> UsableHead:
        """The joints that some actions move."""
        columns = [column for column, joint in enumerate(head) if joint.action in actions]
        joints = tuple(head[column] for column in columns)
        now = np.array([joint.now_rad for joint in joints])
        low, high = np.array([joint.range_rad for joint in joints]).reshape(-1, 2).T
        frames = EYE + 1 + np.array(columns, dtype=np.intp)
        inwards = np.argsort([-joint.depth for joint in joints]).astype(np.intp)
        return cls(joints, Neck(frames, inwards, now, np.column_stack((np.minimum(low, now), np.maximum(high, now)))))

    def changes(self, angles: Array) -> dict[int, float]:
        """Angles, (h,), by index into qpos."""
        return {joint.index: angle for joint, angle in zip(self.joints, angles.tolist(), strict=True)}


class Frames:
    """Where an agent's frames are in one state, and where turns and leans of its torso would bring them.

    Args:
        stage: The scene in that state.
        agent: The agent.

    Attributes:
        head: The joints of its head.
        first_shoulder: Which of the frames is the first arm's shoulder.
        base: Where its base is, metres, (3,).
    """

    def __init__(self, stage: Stage, agent: Agent) -> None:
        model, profile = stage.scene.model, agent.profile
        self._qpos = stage.state.qpos
        frames = [(int(model.site_bodyid[agent.eye_site]), stage.eye(agent))]
        head = []
        for action, axis in ((PAN, profile.pan), (TILT, profile.tilt)):
            if axis is not None:
                joint = int(model.joint(f"{agent.name}/{axis.joint}").id)
                index = agent.joints[axis.joint]
                head.append(HeadJoint(action, index, axis.range_rad, float(self._qpos[index]), joint))
                anchor, along = stage.screw(joint)
                frames.append((int(model.jnt_bodyid[joint]), Pose(anchor, np.repeat(along[:, None], 3, axis=1))))
        self.head, self.first_shoulder = tuple(head), len(frames)
        self._usable: dict[frozenset[str], UsableHead] = {}
        frames += [(arm.carrier_body, stage.shoulder(arm)) for arm in agent.arms]
        torso = tuple(axis.joint for axis in (profile.turn, profile.lean) if axis is not None)
        self._linkage = Linkage.of(stage, agent, torso, tuple(frames))
        self.base = self._linkage.base

    def usable(self, actions: frozenset[str]) -> UsableHead:
        """The joints of the head that some actions move."""
        if actions not in self._usable:
            self._usable[actions] = UsableHead.of(self.head, actions)
        return self._usable[actions]

    def bent(self, angles: Sequence[Mapping[int, float]]) -> Array:
        """Where new angles of the torso's joints by index into qpos, n of them, bring the frames: (n, f, 12)."""
        joints = self._linkage.joints.tolist()
        now = {index: float(self._qpos[index]) for index in joints}
        moves = [[new.get(index, now[index]) - now[index] for index in joints] for new in angles]
        return self._linkage.moved(np.array(moves).reshape(len(angles), len(joints)))
