"""See: at least one visible pixel of the object lies in the gaze cone (5.1.1, with DESIGN 3's cone).

With effort, the head aims at the object; if the object is seen so, the first of the steps on the way that sees it
needs the least amount. What is not seen when looked at is not searched on the way. Stances from which the head cannot
turn far enough, or does not even glimpse the object, are passed over without showing their states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.stances import Stances
from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import STILL_RAD
from taskgist.perspective.judge import Miss, Outcome, untracked_parts
from taskgist.perspective.seeing.aim import Aims, aimed, on_the_way
from taskgist.perspective.seeing.glimpse import glimpsed, off_gaze
from taskgist.perspective.seeing.visibility import Sight, look, measure
from taskgist.perspective.target import Target
from taskgist.world import State

Array = NDArray[np.float64]
PARTS: tuple[tuple[str, ...], ...] = (
    ("head",),
    ("head",),
    ("head", "torso"),
    ("head", "torso", "legs"),
    ("head", "torso", "legs"),
)
"""Parts that must be tracked to judge each level."""
MARGIN_RAD = 1e-6
"""How much farther than its cone the gaze counts as hopeful."""


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

    def unknown(self, level: int) -> str | None:
        """The eye is where the head is; torso and legs matter from their levels on."""
        return untracked_parts(self._here.state, self._agent.name, PARTS[level])

    def without_effort(self) -> Outcome | Miss:
        """Level 0: in the gaze cone of the current state."""
        state = self._here.state
        self.consult(self._stage.show(state).eye(self._agent).position[None])
        sight = look(self._stage, self._agent, self.target)
        in_cone = sight.rays_in_eye[:, 0] >= math.cos(self._cone_rad)
        if (sight.visible & in_cone).any():
            return self.outcome(state, {}, {}, sight)
        return self._miss_now(state, sight)

    def parts(self, stances: Stances) -> Sequence[Stances]:
        """Few at first: a glimpse takes its time, and mostly succeeds early."""
        return stances.parts

    def among(self, stances: Stances) -> SeeAmong:
        """Where the head can turn to the object, and nothing hides all of it."""
        return SeeAmong(self, self._here, stances)

    def consult(self, eyes: Array) -> None:
        """Note that something was looked for between eyes, (n, 3), and the object."""
        region = self._here.consulted
        region.add_points(eyes)
        region.add_balls(self.target.centers, self.target.radii_m)

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
            evidence=lambda: measure(self._stage.show(state), self._agent, self.target).evidence,
        )

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
        eye = self._stage.show(state).eye(self._agent)
        return float(off_gaze(eye.position[None], eye.matrix[None, :, 0], self.target.middle)[0])


class SeeAmong:
    """The head aimed at the object from n stances."""

    def __init__(self, see: See, here: Standpoint, stances: Stances) -> None:
        self._see, self._here, self._stances = see, here, stances
        target = see.target
        self._aims: Aims = aimed(stances.placed, stances.frames, target.middle, here.actions)
        self._off_rad = off_gaze(self._aims.eyes, self._aims.gazes, target.middle)
        cone_rad = here.agent.profile.eye.gaze_cone_rad + MARGIN_RAD
        self._in_cone = off_gaze(self._aims.eyes, self._aims.gazes, target.centers, target.radii_m) <= cone_rad
        see.consult(self._aims.eyes[self._in_cone])
        self.hopeful = glimpsed(here.stage, here.agent, target, (self._aims.eyes, self._aims.turned), self._in_cone)

    def outcomes(self, index: int) -> Iterator[Outcome | Miss]:
        """The least turn of the head on the way that sees the object comes first."""
        start, steps = self._stances[index].state, self._on_the_way(index)
        last = len(steps.eyes) - 1
        aimed_at = start.replace(steps.changes(last))
        sight = self._see.gaze(aimed_at)
        if not sight.visible.any():
            yield self._see.miss(aimed_at, sight)
            return
        for step in np.flatnonzero(self._glimpsed(steps)).tolist():
            angles = steps.changes(step) if step else {}
            state = start.replace(angles)
            sight = self._see.gaze(state)
            if sight.visible.any():
                yield self._see.outcome(state, angles, self._turned(angles), sight)

    def _on_the_way(self, index: int) -> Aims:
        stances, steps = self._stances, self._here.settings.efforts.head_steps
        way = on_the_way(stances.placed, stances.frames, self._aims, index, steps, self._here.actions)
        self._see.consult(way.eyes)
        return way

    def _glimpsed(self, aims: Aims) -> NDArray[np.bool_]:
        here, everywhere = self._here, np.ones(len(aims.eyes), dtype=np.bool_)
        return glimpsed(here.stage, here.agent, self._see.target, (aims.eyes, aims.turned), everywhere)

    def miss(self) -> Miss:
        """Why the hopeless stances do not see it."""
        hidden = np.where(self._in_cone & ~self.hopeful, self._off_rad, np.inf)
        nearest = int(np.argmin(hidden))
        if np.isinf(hidden[nearest]):
            return beside_gaze(float(np.where(self.hopeful, np.inf, self._off_rad).min()))
        state = self._stances[nearest].state.replace(self._aims.changes(nearest))
        return self._see.miss(state, self._see.gaze(state))

    def _turned(self, angles: dict[int, float]) -> dict[str, float]:
        return {
            joint.action: abs(angles[joint.index] - joint.now_rad)
            for joint in self._stances.frames.head
            if joint.index in angles
        }


def beside_gaze(off_rad: float) -> Miss:
    """The head cannot turn far enough: worse than being hidden."""
    return Miss(math.pi + off_rad, f"no nearer than {math.degrees(off_rad):.0f}° to the gaze")
