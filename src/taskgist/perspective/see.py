"""See: what is visible of the object in the gaze cone is large enough to be made out (5.1.1; cone and size are ours).

With effort, the head aims at the object; if the object is seen so, the first of the steps on the way that sees it
needs the least amount; eyes that are turned aside look ahead again then. What is not seen when looked at is not
searched on the way. Candidates from which the head
cannot turn far enough, or does not even glimpse the object, are passed over without showing their states.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property, partial

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.compiled import compiled, compiled_part
from taskgist.perspective.candidates import EYE, STILL_RAD, Candidates, Neck, Table, carry
from taskgist.perspective.effort import LOOK, Miss, Occlusion, Quantity, Reason, Visibility, assumed_gaze
from taskgist.perspective.gaze import TURN_COLUMNS, aim, aimed, off_gaze, turned_heads
from taskgist.perspective.image import Sight, measured
from taskgist.perspective.lens import Lens, lens_of, raster, ray_through
from taskgist.perspective.occlusion import GRAZE_M, away_m, from_eye, in_shadow
from taskgist.perspective.target import Sought, Target, vector
from taskgist.perspective.viewpoint import FindMiss, Hit, Viewpoint
from taskgist.world.geometry.linkage import POSE
from taskgist.world.geometry.rays import INF, NO_GEOM, Shapes, stand_between
from taskgist.world.geometry.transforms import Pose
from taskgist.world.state import State

# --- What many eyes see of an object, told roughly and quickly: never too little. Compiled.
#
# The agent's own body is looked past, meshes hide nothing, and a mesh that is looked at fills the box around it. So
# whoever does not even glimpse an object surely does not see it; whether the others do is for ``visibility`` to tell.

OCCLUDED, BEYOND = 0, 1
"""Why an object is not glimpsed from a candidate: something hides it, or the head cannot turn to it."""
MARGIN_RAD = 1e-6
"""How much farther than its cone the gaze counts as hopeful."""


@compiled
def first_glimpse(
    table: Table,
    neck: Neck,
    shapes: Shapes,
    others: Indices,
    sought: Sought,
    lens: Lens,
    start: int,
    stop: int,
    missed: Indices,
    off_rad: Array,
    eyes: Array,
) -> int:
    """The first of some candidates from which the aimed head may see an object in its gaze cone; ``stop`` if none.

    Args:
        table: The candidates.
        neck: The head's joints that may be used.
        shapes: All shapes; where the agent's are does not matter.
        others: Indices of those that may hide something: neither the agent's nor the object's.
        sought: The object.
        lens: Of the agent's eye.
        start: From which candidate on,
        stop: and before which.
        missed: Kept up to date: of the candidates passed over, the one from which the gaze comes nearest to the
            object's middle, among those whose head turns to it (``OCCLUDED``) and among the others (``BEYOND``), (2,).
        off_rad: Kept up to date: the angle between the two then, (2,).
        eyes: Lowest and highest corner of a box that is made to hold all eyes that look at the object, (2, 3).
    """
    frames, eye = np.empty((EYE + 1 + table.joints, POSE)), np.empty(POSE)
    joints, inwards, now, ranges = neck
    turns = np.empty((len(now), TURN_COLUMNS))
    hider = np.empty(1, dtype=np.intp)
    hider[0] = NO_GEOM
    for i in range(start, stop):
        for frame in range(len(frames)):
            carry(table, i, frame, frames[frame])
        aim(frames, joints, inwards, now, ranges, sought.middle, turns, eye)
        kind = BEYOND if _nearest_rad(eye, sought) > lens.cone_rad + MARGIN_RAD else OCCLUDED
        if kind == OCCLUDED:
            for axis in range(3):
                eyes[0, axis], eyes[1, axis] = min(eyes[0, axis], eye[axis]), max(eyes[1, axis], eye[axis])
            # what hides it from one eye mostly hides it from the next as well
            if hider[0] == NO_GEOM or in_shadow(from_eye(shapes, hider, eye, False), sought.corners, eye) == NO_GEOM:
                glimpsed, hider[0] = _glimpsed(shapes, others, sought, lens, eye)
                if glimpsed:
                    return i
        off = off_gaze(eye, sought.middle, 0.0)
        if off < off_rad[kind]:
            missed[kind], off_rad[kind] = i, off
    return stop


def next_glimpse(shapes: Shapes, others: Indices, sought: Sought, lens: Lens, eyes: Array, start: int) -> int:
    """The first of some eyes, poses (n, 12), from ``start`` on, that glimpses the object; n if none does."""
    for i in range(start, len(eyes)):
        if _glimpsed(shapes, others, sought, lens, eyes[i])[0]:
            return i
    return len(eyes)


@compiled
def _glimpsed(shapes: Shapes, others: Indices, sought: Sought, lens: Lens, eye: Array) -> tuple[bool, int]:
    """Whether an eye, pose (12,), may see an object in its gaze cone; if not, a shape that alone hides it, or −1."""
    between = stand_between(shapes, others, -1, eye[:3], sought.centers, sought.radii_m)
    hiders = from_eye(shapes, between, eye, False)
    hider = in_shadow(hiders, sought.corners, eye)
    if hider != NO_GEOM:
        return False, hider
    return _shows(from_eye(shapes, sought.shapes, eye, True), hiders, sought, lens, eye), NO_GEOM


@compiled_part
def _nearest_rad(eye: Array, sought: Sought) -> float:
    """Angle between the gaze and the nearest of an object's balls."""
    least, centers = math.pi, sought.centers
    for k in range(len(centers)):
        least = min(least, off_gaze(eye, centers[k], sought.radii_m[k]))
    return least


@compiled_part
def _shows(wanted: Array, others: Array, sought: Sought, lens: Lens, eye: Array) -> bool:
    """Whether the ray of some pixel meets a wanted shape, and none of the others before."""
    hider, frame = 0, eye[3:]
    halvings, first_row, last_row, first_column, last_column = raster(
        lens, eye, sought.centers, sought.radii_m, sought.corners
    )
    for row in range(first_row, last_row):
        for column in range(first_column, last_column):
            x, y, z = ray_through(lens, halvings, row, column)
            if x < lens.cone_cos:
                continue
            dx = frame[0] * x + frame[1] * y + frame[2] * z
            dy = frame[3] * x + frame[4] * y + frame[5] * z
            dz = frame[6] * x + frame[7] * y + frame[8] * z
            nearest = INF
            for k in range(len(wanted)):
                nearest = min(nearest, away_m(wanted, k, dx, dy, dz))
            if nearest == INF:
                continue
            if hider < len(others) and away_m(others, hider, dx, dy, dz) < nearest - GRAZE_M:
                continue  # what hid one pixel mostly hides the next as well
            hider = 0
            while hider < len(others) and away_m(others, hider, dx, dy, dz) >= nearest - GRAZE_M:
                hider += 1
            if hider == len(others):
                return True
    return False


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
        start, angles = self._start(index), self._on_the_way(self._aimed(index))
        sight = self._see.gaze(start.replace(self._head.changes(angles[-1])))
        if not sight.makes_out(sight.visible):
            yield partial(self._see.miss, sight)
            return
        for step in self._glimpsed(index, angles):
            changes = self._head.changes(angles[step]) if step else {}
            state = start.replace(changes)
            sight = self._see.gaze(state)
            if sight.makes_out(sight.visible):
                yield self._see.hit(state, changes, self._turned(changes), sight)

    def _start(self, index: int) -> State:
        """A candidate, its eyes turned back: who turns the head to a thing looks at it."""
        state = self._candidates[index].state
        return state.looking_ahead(self._here.agent.name) if self._head.joints else state

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
        hidden = int(self._missed[OCCLUDED])
        if hidden != NOT_ONE:
            state = self._start(hidden).replace(self._head.changes(self._aimed(hidden)))
            return self._see.miss(self._see.gaze(state))
        return beyond_neck(float(self._off_rad[BEYOND])) if self._missed[BEYOND] != NOT_ONE else None

    def _turned(self, changes: dict[int, float]) -> dict[str, float]:
        """How far each action turns the head, radians; where it stays, how far the eyes are turned back."""
        turn = self._here.state.eyes.get(self._here.agent.name)
        if not changes and self._head.joints and turn is not None:
            return {LOOK: turn.turned_rad}
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
        self.brief = self.hopeless = False

    def passes_over(self, level: int) -> bool:  # noqa: ARG002 - as all judges
        """False: things are seen from afar."""
        return False

    def unknown(self, level: int) -> str | None:
        """The eye is where the head is; torso and legs matter from their levels on."""
        return self._here.untracked(PARTS[level])

    def without_effort(self) -> Hit | FindMiss:
        """Level 0: in the gaze cone of the current state."""
        sight = self._here.sight(self.target)
        if sight.makes_out(sight.visible & (sight.rays_in_eye[:, 0] >= self.lens.cone_cos)):
            return self.hit(self._here.state, {}, {}, sight)
        return partial(self._miss_now, sight)

    def screen(self, candidates: Candidates) -> SeeScreening:
        """Where the head can turn to the object, and nothing hides all of it."""
        return SeeScreening(self, self._here, candidates)

    @cached_property
    def others(self) -> Indices:
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
            head_rad=sum(turn for action, turn in turned.items() if action != LOOK),
            cost=-sight.pixels(sight.visible),
        )

    def _visibility(self, state: State) -> Visibility:
        here, target = self._here, self.target
        sight = here.sight(target) if state is here.state else here.look(target, state)
        return measured(here.stage, self._agent, target, sight)

    def miss(self, sight: Sight) -> Miss:
        """Why the object is not seen in the gaze cone when looked at."""
        if sight.makes_out():
            return self._hidden(sight)
        off_rad = self._off_rad(sight)
        if off_rad <= self._cone_rad and self._in_image(sight):
            return Miss(Reason.TOO_SMALL, "too small to be made out", Quantity(off_rad, "rad"))
        return beyond_neck(off_rad)

    def _miss_now(self, sight: Sight) -> Miss:
        """Why the object is not seen without effort: hidden, beside the gaze or out of the field of view."""
        off_rad = self._off_rad(sight)
        off = Quantity(off_rad, "rad")
        beside = f"{math.degrees(off_rad):.0f}° beside the gaze (cone {math.degrees(self._cone_rad):.0f}°)"
        turn = self._here.state.eyes.get(self._agent.name)
        if turn is not None and turn.towards is not None:
            beside += f", {assumed_gaze(turn.towards, turn.turned_rad)}"
        if sight.makes_out(sight.visible):
            return Miss(Reason.BESIDE_GAZE, f"in view, but {beside}", off)
        if sight.makes_out():
            return self._hidden(sight)
        if self._in_image(sight):
            return Miss(Reason.TOO_SMALL, "too small to be made out", off)
        return Miss(Reason.OUT_OF_VIEW, f"out of view, {beside}", off)

    def _hidden(self, sight: Sight) -> Miss:
        """Something else hides the object, or all of it but too little."""
        scene, hidden = self._here.stage.scene, np.flatnonzero(~sight.visible)
        owners = [scene.owners[geom] for geom in sight.geoms[hidden].tolist()]
        first = {owner: hidden[owners.index(owner)] for owner in sorted(set(owners))}
        eye = eye_pose(sight)
        hits = eye.to_world(sight.rays_in_eye * sight.distances_m[:, None])
        occlusion = Occlusion(
            sight.owners(~sight.visible, scene.owners),
            sight.pixels(),
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
