"""The head aimed at an object from many stances, and turned there in steps (5.1.1)."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.judge import Miss, Outcome, Why
from taskgist.perspective.seeing.aim import aimed, turned_heads
from taskgist.perspective.seeing.glimpse import BESIDE, HIDDEN, first_glimpse, next_glimpse

if TYPE_CHECKING:
    from taskgist.perspective.seeing.see import See

Array = NDArray[np.float64]
NOT_ONE = -1


class SeeAmong:
    """The head aimed at the object from n stances.

    Args:
        see: Whose eye, and at what.
        here: From where.
        stances: The stances.
    """

    def __init__(self, see: See, here: Standpoint, stances: Stances) -> None:
        self._see, self._here, self._stances = see, here, stances
        self._head = stances.bent.frames.usable(here.actions)
        self._sought = (here.stage.shapes, see.others, see.target.sought, see.lens)
        self._missed, self._off_rad = np.full(2, NOT_ONE), np.full(2, np.inf)

    def next(self, start: int, stop: int) -> int:
        """The first stance from which the aimed head glimpses the object."""
        table, eyes = self._stances.table, self._here.consulted.eyes.bounds
        return first_glimpse(table, self._head.neck, *self._sought, start, stop, self._missed, self._off_rad, eyes)

    def outcomes(self, index: int) -> Iterator[Outcome | Why]:
        """The least turn of the head on the way that sees the object comes first."""
        start, angles = self._stances[index].state, self._on_the_way(self._aimed(index))
        aimed_at = start.replace(self._head.changes(angles[-1]))
        sight = self._see.gaze(aimed_at)
        if not sight.visible.any():
            yield partial(self._see.miss, aimed_at, sight)
            return
        for step in self._glimpsed(index, angles):
            changes = self._head.changes(angles[step]) if step else {}
            state = start.replace(changes)
            sight = self._see.gaze(state)
            if sight.visible.any():
                yield self._see.outcome(state, changes, self._turned(changes), sight)

    def _aimed(self, index: int) -> Array:
        """Angles of the head when it is aimed from a stance, (h,)."""
        return aimed(self._stances.frames(index), self._head.neck, self._see.target.middle)

    def _on_the_way(self, aimed: Array) -> Array:
        """Angles of the head at equal steps from where it is to where it is aimed, both included, (k, h)."""
        steps, now = self._here.settings.efforts.head_steps, self._head.neck.now
        angles = now + (aimed - now) * (np.arange(steps + 1) / steps)[:, None]
        angles[-1] = aimed
        return np.asarray(angles)

    def _glimpsed(self, index: int, angles: Array) -> Iterator[int]:
        """Those of some angles of the head, from a stance, with which it glimpses the object."""
        eyes = turned_heads(self._stances.frames(index), self._head.neck, angles)
        self._here.consulted.eyes.add_points(eyes[:, :3])
        step = next_glimpse(*self._sought, eyes, 0)
        while step < len(eyes):
            yield step
            step = next_glimpse(*self._sought, eyes, step + 1)

    def miss(self) -> Miss | None:
        """Why the other stances do not see it."""
        hidden = int(self._missed[HIDDEN])
        if hidden != NOT_ONE:
            state = self._stances[hidden].state.replace(self._head.changes(self._aimed(hidden)))
            return self._see.miss(state, self._see.gaze(state))
        return beside_gaze(float(self._off_rad[BESIDE])) if self._missed[BESIDE] != NOT_ONE else None

    def _turned(self, changes: dict[int, float]) -> dict[str, float]:
        """How far each action turns the head, radians."""
        return {
            joint.action: abs(changes[joint.index] - joint.now_rad)
            for joint in self._head.joints
            if joint.index in changes
        }


def beside_gaze(off_rad: float) -> Miss:
    """The head cannot turn far enough: worse than being hidden."""
    return Miss(math.pi + off_rad, f"no nearer than {math.degrees(off_rad):.0f}° to the gaze")
