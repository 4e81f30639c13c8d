"""See: at least one visible pixel of the object lies in the gaze cone (5.1.1, with DESIGN 3's cone).

With effort, the head aims at the object; if the object is seen so, the first of the steps on the way that sees it
needs the least amount. What is not seen when looked at is not searched on the way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.aim import aimed, head_joints, on_the_way
from taskgist.perspective.judge import Miss, Outcome, untracked_parts
from taskgist.perspective.standpoint import Standpoint
from taskgist.perspective.virtual_actions import STILL_RAD, Stance
from taskgist.perspective.visibility import Sight, look, measure, object_middle, off_gaze_rad
from taskgist.world import State

PARTS: tuple[tuple[str, ...], ...] = (
    ("head",),
    ("head",),
    ("head", "torso"),
    ("head", "torso", "legs"),
    ("head", "torso", "legs"),
)
"""Parts that must be tracked to judge each level."""


class See:
    """Judges the ability to see one object.

    Args:
        here: Whose, and from where.
        name: The object.
    """

    def __init__(self, here: Standpoint, name: str) -> None:
        self._here, self._name = here, name
        self._stage, self._agent = here.stage, here.agent
        self._target = object_middle(here.stage, name)
        self._cone_rad = here.agent.profile.eye.gaze_cone_rad
        self._joints = head_joints(here.agent, here.actions)

    def unknown(self, level: int) -> str | None:
        """The eye is where the head is; torso and legs matter from their levels on."""
        return untracked_parts(self._here.state, self._agent.name, PARTS[level])

    def without_effort(self) -> Outcome | Miss:
        """Level 0: in the gaze cone of the current state."""
        state = self._here.state
        sight = self._gaze(state)
        return self._outcome(state, {}, sight) if sight.visible.any() else self._miss_now(state)

    def from_stance(self, stance: Stance) -> Iterator[Outcome | Miss]:
        """The head aims; the least turn on the way that sees the object comes first."""
        angles = aimed(self._stage, self._agent, stance.state, self._target, self._here.actions)
        sight = self._gaze(stance.state.replace(angles))
        if not sight.visible.any():
            yield self._miss(sight)
            return
        steps = self._here.settings.efforts.head_steps
        for step in ({}, *on_the_way(stance.state, angles, steps)):
            state = stance.state.replace(step)
            sight = self._gaze(state)
            if sight.visible.any():
                yield self._outcome(state, step, sight)

    def _gaze(self, state: State) -> Sight:
        return look(self._stage.show(state), self._agent, self._name, cone_rad=self._cone_rad)

    def _outcome(self, state: State, angles: dict[int, float], sight: Sight) -> Outcome:
        before = self._here.state.qpos
        turned = {
            action: abs(angles[index] - float(before[index]))
            for action, (index, _) in self._joints.items()
            if index in angles
        }
        actions = tuple(action for action, turn in turned.items() if turn > STILL_RAD)
        return Outcome(
            state,
            actions,
            head_rad=sum(turned.values()),
            merit=-float(sight.visible.sum()),
            evidence=lambda: measure(self._stage.show(state), self._agent, self._name).evidence,
        )

    def _miss(self, sight: Sight) -> Miss:
        """Why the object is not seen when looked at."""
        off_rad = off_gaze_rad(self._stage, self._agent, self._name)
        if len(sight.geoms):
            return Miss(off_rad, f"occluded by {self._names(sight.geoms)}")
        if off_rad <= self._cone_rad:
            return Miss(off_rad, "smaller than a pixel")
        return Miss(math.pi + off_rad, f"no nearer than {math.degrees(off_rad):.0f}° to the gaze")

    def _miss_now(self, state: State) -> Miss:
        """Why the object is not seen without effort: hidden, beside the gaze or out of the field of view."""
        sight = look(self._stage.show(state), self._agent, self._name)
        off_rad = off_gaze_rad(self._stage, self._agent, self._name)
        beside = f"{math.degrees(off_rad):.0f}° beside the gaze (cone {math.degrees(self._cone_rad):.0f}°)"
        if not len(sight.geoms):
            return Miss(off_rad, "smaller than a pixel" if off_rad <= self._cone_rad else f"out of view, {beside}")
        if not sight.visible.any():
            return Miss(off_rad, f"occluded by {self._names(sight.geoms)}")
        return Miss(off_rad, f"in view, but {beside}")

    def _names(self, geoms: NDArray[np.int32]) -> str:
        owners = self._stage.scene.owners
        return " and ".join(sorted({owners[geom] for geom in geoms}))
