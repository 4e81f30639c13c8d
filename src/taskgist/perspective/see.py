"""See: at least one visible pixel of the object lies in the gaze cone (5.1.1, with DESIGN 3's cone).

With effort, the head aims at the object; if the object is seen so, the first of the steps on the way that sees it
needs the least amount. What is not seen when looked at is not searched on the way. Stances from which the head cannot
turn far enough, or does not even glimpse the object, are passed over without showing their states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.perspective.actions import STILL_RAD
from taskgist.perspective.candidates import Stances
from taskgist.perspective.effort import Miss, Outcome, Why, untracked_parts
from taskgist.perspective.gaze import aimed, off_gaze, turned_heads
from taskgist.perspective.glimpse import BESIDE, HIDDEN, first_glimpse, next_glimpse
from taskgist.perspective.image import Sight, lens_of, look, measured, sight_now
from taskgist.perspective.viewpoint import Standpoint, Target
from taskgist.world.state import State

# --- The head aimed at an object from many stances, and turned there in steps (5.1.1).

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
        target: The object.
    """

    def __init__(self, here: Standpoint, target: Target) -> None:
        self._here, self.target = here, target
        self._stage, self._agent = here.stage, here.agent
        self._cone_rad = here.agent.profile.eye.gaze_cone_rad
        self.lens = lens_of(here.agent.profile.eye)

    def unknown(self, level: int) -> str | None:
        """The eye is where the head is; torso and legs matter from their levels on."""
        return untracked_parts(self._here.state, self._agent.name, PARTS[level])

    def without_effort(self) -> Outcome | Why:
        """Level 0: in the gaze cone of the current state."""
        sight = sight_now(self._here, self.target)
        self._here.consulted.target.add_balls(self.target.centers, self.target.radii_m)
        self._here.consulted.eyes.add_points(sight.eye[None, :3])
        state = self._here.state
        if (sight.visible & (sight.rays_in_eye[:, 0] >= self.lens.cone_cos)).any():
            return self.outcome(state, {}, {}, sight)
        return partial(self._miss_now, state, sight)

    def among(self, stances: Stances) -> SeeAmong:
        """Where the head can turn to the object, and nothing hides all of it."""
        return SeeAmong(self, self._here, stances)

    @cached_property
    def others(self) -> NDArray[np.intp]:
        """Shapes that may hide the object from stances, wherever the agent's own are then, (n,)."""
        others = self.target.others
        return others[~self._here.is_own[others]]

    def gaze(self, state: State) -> Sight:
        """What is seen of the object in the gaze cone of a state."""
        return look(self._stage.show(state), self._agent, self.target, cone_rad=self._cone_rad)

    def outcome(self, state: State, angles: dict[int, float], turned: dict[str, float], sight: Sight) -> Outcome:
        """Seen in a state, whose head has some angles, each turned by an action."""
        return Outcome(
            angles,
            tuple(action for action, turn in turned.items() if turn > STILL_RAD),
            head_rad=sum(turned.values()),
            merit=-float(sight.visible.sum()),
            evidence=partial(self._evidence, state),
        )

    def _evidence(self, state: State) -> dict[str, object]:
        here, target = self._here, self.target
        now = state is here.state
        sight = sight_now(here, target) if now else look(self._stage.show(state), self._agent, target)
        return measured(self._stage, self._agent, target, sight).evidence

    def miss(self, state: State, sight: Sight) -> Miss:
        """Why the object is not seen in a state, when looked at."""
        off_rad = self._off_rad(state)
        if len(sight.geoms):
            return self._hidden(off_rad, state, sight)
        if off_rad <= self._cone_rad and self._in_image(state):
            return Miss(off_rad, "smaller than a pixel")
        return beside_gaze(off_rad)

    def _miss_now(self, state: State, sight: Sight) -> Miss:
        """Why the object is not seen without effort: hidden, beside the gaze or out of the field of view."""
        off_rad = self._off_rad(state)
        beside = f"{math.degrees(off_rad):.0f}° beside the gaze (cone {math.degrees(self._cone_rad):.0f}°)"
        if not len(sight.geoms):
            return Miss(off_rad, "smaller than a pixel" if self._in_image(state) else f"out of view, {beside}")
        if not sight.visible.any():
            return self._hidden(off_rad, state, sight)
        return Miss(off_rad, f"in view, but {beside}")

    def _hidden(self, off_rad: float, state: State, sight: Sight) -> Miss:
        """All of the object's pixels show something else."""
        owners = self._stage.scene.owners
        hiders = sorted({owners[geom] for geom in sight.geoms.tolist()})

        def evidence() -> dict[str, object]:
            eye = self._stage.show(state).eye(self._agent)
            of = np.array([hiders.index(owners[geom]) for geom in sight.geoms.tolist()])
            counts = [(owner, int((of == index).sum())) for index, owner in enumerate(hiders)]
            hits = eye.to_world(sight.rays_in_eye * sight.distances_m[:, None])
            first = [int(np.argmax(of == index)) for index in range(len(hiders))]
            return {
                "occluders": sorted(counts, key=lambda each: -each[1]),
                "unoccluded_px": len(of),
                "eye_m": eye.position.tolist(),
                "hits_m": {owner: hits[row].tolist() for owner, row in zip(hiders, first, strict=True)},
            }

        return Miss(off_rad, f"occluded by {' and '.join(hiders)}", evidence)

    def _in_image(self, state: State) -> bool:
        """Whether the object's middle is within the field of view."""
        x, y, z = self._stage.show(state).eye(self._agent).to_local(self.target.middle)
        across, up = self._agent.profile.eye.fov_rad
        return bool(x > 0 and abs(y) <= x * math.tan(across / 2) and abs(z) <= x * math.tan(up / 2))

    def _off_rad(self, state: State) -> float:
        eye = self._stage.show(state).eye_row(self._agent)
        return off_gaze(eye, self.target.middle, 0.0)
