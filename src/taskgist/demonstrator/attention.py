"""Attention: what an onlooker looks at while somebody acts.

What moves draws the eyes: first the acting hand, then the thing in it, as long as the onlooker has it in view. When
nothing in view is worth it, people look at each other's faces. The onlooker has a thing in view where a straight line
from its eye to the thing's middle is free and not too far off its line of sight: simple geometry of its own, made with
less care than the perspective that later judges what was visible.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.demonstrator.gaze import Fixation, shapes_of, subject_place
from taskgist.world import Stage, State
from taskgist.world.geometry.rotations import normalized

Array = NDArray[np.float64]

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
