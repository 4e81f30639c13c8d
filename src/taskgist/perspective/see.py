"""See: at least one visible pixel of the object lies in the gaze cone (5.1.1, with DESIGN 3's cone).

With effort, the head aims at the object; if the object is seen so, the first of the steps on the way that sees it
needs the least amount. What is not seen when looked at is not searched on the way. Candidates from which the head
cannot turn far enough, or does not even glimpse the object, are passed over without showing their states.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array
from taskgist.perspective.candidates import STILL_RAD, Candidates
from taskgist.perspective.effort import Miss, Occlusion, Quantity, Reason, Visibility
from taskgist.perspective.gaze import aimed, off_gaze, turned_heads
from taskgist.perspective.glimpse import BESIDE, HIDDEN, first_glimpse, next_glimpse
from taskgist.perspective.image import Sight, lens_of, measured
from taskgist.perspective.target import Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Viewpoint
from taskgist.world.geometry.transforms import Pose
from taskgist.world.state import State

# --- Aiming the head: analytic, joint by joint.
#
# Each joint of the head turns by the signed angle, about its own axis, between where the eye looks and where the
# target is. Turning moves the eye as well, so this is done twice; what remains is below a degree for anything farther
# than an arm. No convention about zero angles or signs of a robot's neck is needed.


# --- What many eyes see of an object, told roughly and quickly: never too little.
#
# The agent's own body is looked past, meshes hide nothing, and a mesh that is looked at fills the box around it. So
# whoever does not even glimpse an object surely does not see it; whether the others do is for ``visibility`` to tell.


# --- The head aimed at an object from many candidates, and turned there in steps (5.1.1).

NOT_ONE = -1


class SeeScreening:
    """The head aimed at the object from n candidates.

    Args:
        see: Whose eye, and at what.
        here: From where.
        candidates: The candidates.
    """

    def __init__(self, see: See, here: Viewpoint, candidates: Candidates) -> None:
        self._see, self._here, self._candidates = see, here, candidates
        self._head = candidates.torso.frames.usable(here.actions)
        self._sought = (here.stage.shapes, see.others, see.target.sought, see.lens)
        self._missed, self._off_rad = np.full(2, NOT_ONE), np.full(2, np.inf)

    def next(self, start: int, stop: int) -> int:
        """The first candidate from which the aimed head glimpses the object; notes all eyes that look at it."""
        table, eyes = self._candidates.table, self._here.recorder.eyes.bounds
        return first_glimpse(table, self._head.neck, *self._sought, start, stop, self._missed, self._off_rad, eyes)

    def results(self, index: int) -> Iterator[Hit | FindMiss]:
        """The least turn of the head on the way that sees the object comes first."""
        start, angles = self._candidates[index].state, self._on_the_way(self._aimed(index))
        sight = self._see.gaze(start.replace(self._head.changes(angles[-1])))
        if not sight.visible.any():
            yield partial(self._see.miss, sight)
            return
        for step in self._glimpsed(index, angles):
            changes = self._head.changes(angles[step]) if step else {}
            state = start.replace(changes)
            sight = self._see.gaze(state)
            if sight.visible.any():
                yield self._see.hit(state, changes, self._turned(changes), sight)

    def _aimed(self, index: int) -> Array:
        """Angles of the head when it is aimed from a candidate, (h,)."""
        return aimed(self._candidates.frames(index), self._head.neck, self._see.target.middle)

    def _on_the_way(self, aimed: Array) -> Array:
        """Angles of the head at equal steps from where it is to where it is aimed, both included, (k, h)."""
        steps, now = self._here.settings.efforts.head_steps, self._head.neck.now
        angles = now + (aimed - now) * (np.arange(steps + 1) / steps)[:, None]
        angles[-1] = aimed
        return np.asarray(angles)

    def _glimpsed(self, index: int, angles: Array) -> Iterator[int]:
        """Those of some angles of the head, from a candidate, with which it glimpses the object; notes the eyes."""
        eyes = turned_heads(self._candidates.frames(index), self._head.neck, angles)
        self._here.recorder.eyes.add_points(eyes[:, :3])
        step = next_glimpse(*self._sought, eyes, 0)
        while step < len(eyes):
            yield step
            step = next_glimpse(*self._sought, eyes, step + 1)

    def miss(self) -> Miss | None:
        """Why the other candidates do not see it."""
        hidden = int(self._missed[HIDDEN])
        if hidden != NOT_ONE:
            state = self._candidates[hidden].state.replace(self._head.changes(self._aimed(hidden)))
            return self._see.miss(self._see.gaze(state))
        return beyond_neck(float(self._off_rad[BESIDE])) if self._missed[BESIDE] != NOT_ONE else None

    def _turned(self, changes: dict[int, float]) -> dict[str, float]:
        """How far each action turns the head, radians."""
        return {
            joint.action: abs(changes[joint.index] - joint.now_rad)
            for joint in self._head.joints
            if joint.index in changes
        }


def beyond_neck(off_rad: float) -> Miss:
    """The head cannot turn far enough."""
    text = f"no nearer than {math.degrees(off_rad):.0f}° to the gaze"
    return Miss(Reason.BEYOND_NECK, text, Quantity(off_rad, "rad"))


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

    def __init__(self, here: Viewpoint, target: Target) -> None:
        self._here, self.target = here, target
        self._agent, self._cone_rad = here.agent, here.agent.profile.eye.gaze_cone_rad
        self.lens = lens_of(here.agent.profile.eye)

    def unknown(self, level: int) -> str | None:
        """The eye is where the head is; torso and legs matter from their levels on."""
        return self._here.untracked(PARTS[level])

    def without_effort(self) -> Hit | FindMiss:
        """Level 0: in the gaze cone of the current state."""
        sight = self._here.sight(self.target)
        if (sight.visible & (sight.rays_in_eye[:, 0] >= self.lens.cone_cos)).any():
            return self.hit(self._here.state, {}, {}, sight)
        return partial(self._miss_now, sight)

    def screen(self, candidates: Candidates) -> SeeScreening:
        """Where the head can turn to the object, and nothing hides all of it."""
        return SeeScreening(self, self._here, candidates)

    @cached_property
    def others(self) -> NDArray[np.intp]:
        """Shapes that may hide the object from candidates, wherever the agent's own are then, (n,)."""
        others = self.target.others
        return others[~self._here.is_own[others]]

    def gaze(self, state: State) -> Sight:
        """What is seen of the object in the gaze cone of a state."""
        return self._here.look(self.target, state, cone_rad=self._cone_rad)

    def hit(self, state: State, angles: dict[int, float], turned: dict[str, float], sight: Sight) -> Hit:
        """Seen in a state, whose head has some angles, each turned by an action."""
        return Hit(
            partial(self._visibility, state),
            angles,
            tuple(action for action, turn in turned.items() if turn > STILL_RAD),
            head_rad=sum(turned.values()),
            cost=-float(sight.visible.sum()),
        )

    def _visibility(self, state: State) -> Visibility:
        here, target = self._here, self.target
        sight = here.sight(target) if state is here.state else here.look(target, state)
        return measured(here.stage, self._agent, target, sight)

    def miss(self, sight: Sight) -> Miss:
        """Why the object is not seen in the gaze cone when looked at."""
        if len(sight.geoms):
            return self._hidden(sight)
        off_rad = self._off_rad(sight)
        if off_rad <= self._cone_rad and self._in_image(sight):
            return Miss(Reason.TOO_SMALL, "smaller than a pixel", Quantity(off_rad, "rad"))
        return beyond_neck(off_rad)

    def _miss_now(self, sight: Sight) -> Miss:
        """Why the object is not seen without effort: hidden, beside the gaze or out of the field of view."""
        off_rad = self._off_rad(sight)
        off = Quantity(off_rad, "rad")
        beside = f"{math.degrees(off_rad):.0f}° beside the gaze (cone {math.degrees(self._cone_rad):.0f}°)"
        if sight.visible.any():
            return Miss(Reason.BESIDE_GAZE, f"in view, but {beside}", off)
        if len(sight.geoms):
            return self._hidden(sight)
        if self._in_image(sight):
            return Miss(Reason.TOO_SMALL, "smaller than a pixel", off)
        return Miss(Reason.OUT_OF_VIEW, f"out of view, {beside}", off)

    def _hidden(self, sight: Sight) -> Miss:
        """All of the object's pixels show something else."""
        owners = [self._here.stage.scene.owners[geom] for geom in sight.geoms.tolist()]
        counts = sorted(Counter(owners).items())
        first = {owner: owners.index(owner) for owner, _ in counts}
        eye = eye_pose(sight)
        hits = eye.to_world(sight.rays_in_eye * sight.distances_m[:, None])
        occlusion = Occlusion(
            tuple(sorted(counts, key=lambda each: -each[1])),
            len(owners),
            vector(eye.position),
            tuple((owner, vector(hits[row])) for owner, row in first.items()),
        )
        text = f"occluded by {' and '.join(first)}"
        return Miss(Reason.OCCLUDED, text, Quantity(self._off_rad(sight), "rad"), occlusion)

    def _in_image(self, sight: Sight) -> bool:
        """Whether the object's middle is within the field of view."""
        x, y, z = eye_pose(sight).to_local(self.target.middle)
        across, up = self._agent.profile.eye.fov_rad
        return bool(x > 0 and abs(y) <= x * math.tan(across / 2) and abs(z) <= x * math.tan(up / 2))

    def _off_rad(self, sight: Sight) -> float:
        return off_gaze(sight.eye, self.target.middle, 0.0)


def eye_pose(sight: Sight) -> Pose:
    """Pose of the eye that looked."""
    return Pose(sight.eye[:3], sight.eye[3:].reshape(3, 3))
