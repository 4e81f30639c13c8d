"""The frames of an agent that abilities depend on: its eye, the joints of its head, and its shoulders."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.virtual_actions import PAN, TILT
from taskgist.world import Agent, Linkage, Pose, Stage

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Placed:
    """Where the frames are in n states.

    Attributes:
        eyes: Positions of the eye, metres, (n, 3), and its orientation, (n, 3, 3).
        anchors: A point on the axis of each joint of the head, (n, h, 3).
        axes: Unit directions of these axes, (n, h, 3).
        shoulders: Positions of the shoulders, (n, a, 3).
        carriers: Orientation of what carries the arms, (n, a, 3, 3).
    """

    eyes: tuple[Array, Array]
    anchors: Array
    axes: Array
    shoulders: Array
    carriers: Array


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


@dataclass(frozen=True, eq=False)
class UsableHead:
    """Those joints of a head that may be used.

    Attributes:
        columns: Their places among all joints of the head, (h,).
        joints: The joints.
        inwards: Their order from the eye to the base, (h,).
        now: Their present angles, radians, (h,).
        ranges: Their ranges, radians, (h, 2).
    """

    columns: list[int]
    joints: tuple[HeadJoint, ...]
    inwards: NDArray[np.intp]
    now: Array
    ranges: Array

    @classmethod
    def of(cls, head: Sequence[HeadJoint], actions: frozenset[str]) -> UsableHead:
        """The joints that some actions move."""
        columns = [column for column, joint in enumerate(head) if joint.action in actions]
        joints = tuple(head[column] for column in columns)
        return cls(
            columns,
            joints,
            np.argsort([-joint.depth for joint in joints]),
            np.array([joint.now_rad for joint in joints]),
            np.array([joint.range_rad for joint in joints]).reshape(-1, 2),
        )


class Frames:
    """Where an agent's frames are in one state, and where turns and leans of its torso would bring them.

    Args:
        stage: The scene in that state.
        agent: The agent.
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
        self.head = tuple(head)
        self._usable: dict[frozenset[str], UsableHead] = {}
        frames += [(arm.carrier_body, stage.shoulder(arm)) for arm in agent.arms]
        torso = tuple(axis.joint for axis in (profile.turn, profile.lean) if axis is not None)
        self._linkage = Linkage.of(stage, agent, torso, tuple(frames))

    def usable(self, actions: frozenset[str]) -> UsableHead:
        """The joints of the head that some actions move."""
        if actions not in self._usable:
            self._usable[actions] = UsableHead.of(self.head, actions)
        return self._usable[actions]

    def by(self, angles: Sequence[Mapping[int, float]]) -> Array:
        """How far each of the torso's joints moves to new angles by index into qpos, n of them: (n, j)."""
        joints = self._linkage.joints.tolist()
        now = {index: float(self._qpos[index]) for index in joints}
        moves = [[new.get(index, now[index]) - now[index] for index in joints] for new in angles]
        return np.array(moves).reshape(len(angles), len(joints))

    def bent(self, by: Array) -> tuple[Array, Array]:
        """Where moves of the torso's joints, (n, j), bring the frames: positions and orientations."""
        return self._linkage.moved(by)

    def displaced(
        self, bent: tuple[Array, Array], which: NDArray[np.intp], offsets_m: Array, turned_rad: Array
    ) -> Placed:
        """Where moves of the base bring them afterwards.

        Args:
            bent: Frames after some bends of the torso.
            which: Which of these bends, (n,).
            offsets_m: How far the base moves, metres along the world's x and y, (n, 2).
            turned_rad: How far the agent turns about the vertical through its base before that, (n,).
        """
        places, turned = self._linkage.displaced(bent, which, offsets_m, turned_rad)
        arms = 1 + len(self.head)
        return Placed(
            eyes=(places[:, 0], turned[:, 0]),
            anchors=places[:, 1:arms],
            axes=turned[:, 1:arms, :, 0],
            shoulders=places[:, arms:],
            carriers=turned[:, arms:],
        )
