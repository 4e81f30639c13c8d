"""Which cells an agent sees, its head aimed at each from its configurations: the point-like twin of ``see``.

A cell is seen if its centre lies in the gaze cone and in the field of view, and no seen shape is met on the straight
line from the eye (5.1.1). Cells come in blocks: what the eye does not even turn to, and what cannot stand between, is
plain of a whole block, as it is of an object.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled_for_threads, compiled_part
from taskgist.common.workers import on_threads
from taskgist.maps.configurations import Base, Configuration, straight_ahead, turn_towards
from taskgist.maps.grid import BLOCK_CELLS, Cells, Undecided
from taskgist.perspective.candidates import Neck
from taskgist.perspective.gaze import TURN_COLUMNS, aim, off_gaze
from taskgist.perspective.lens import Lens, in_view, lens_of
from taskgist.perspective.occlusion import CLEAR, HIDDEN, from_eye, hidden_point
from taskgist.perspective.target import ball_around
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.geometry.linkage import POSE, carry_pose
from taskgist.world.geometry.rays import Shapes, stand_between

MARGIN = 2.0
"""A block is passed over if the head, aimed at its middle, looks past a ball so many times as wide as its own: aimed
at one of its cells instead, it looks elsewhere by less than that."""


class Looking(NamedTuple):
    """How an agent looks, as compiled functions take it.

    Attributes:
        shapes: All shapes, the agent's as its configuration has them.
        own: Indices of its own that may hide something: not those that the head carries.
        others: Of all others.
        frames: Its frames, (f, 12).
        neck: The joints of its head that may be used.
        lens: Of its eye.
    """

    shapes: Shapes
    own: Indices
    others: Indices
    frames: Array
    neck: Neck
    lens: Lens


@compiled_for_threads
def see_cells(looking: Looking, base: Base, cells: Undecided, found: NDArray[np.uint8], eyes: Array) -> None:
    """Find out which cells are seen from a configuration, at some of its places; those are undecided no longer.

    Args:
        looking: How the agent looks.
        base: Where it is brought.
        cells: The cells.
        found: Of all cells, lessened to ``CLEAR`` where one is seen, and to ``BOXED`` where only meshes may hide it.
        eyes: Of all cells, filled where one is in view: where the eye is then, metres in the world, (cells, 3).
    """
    points, rows, starts, counts, middles, radii_m = cells
    ahead, eye_ahead, eye = np.empty((BLOCK_CELLS, 3)), np.empty((BLOCK_CELLS, 3)), np.empty((BLOCK_CELLS, 3))
    middle = np.empty(3)
    for block in range(len(starts)):
        start = starts[block]
        for place in range(len(base.places)):
            count = counts[block]
            if count == 0:
                break
            straight_ahead(base.start, base.chest, base.places, base.turns, place, middles[block], middle)
            asked = rows[start : start + count]
            viewed = _view(looking, base, place, middle, radii_m[block], points, asked, ahead, eye_ahead, eye)
            if viewed > 0:
                own = _from_eyes(looking.shapes, looking.own, eye_ahead[:viewed], middle, radii_m[block])
                others = _from_eyes(looking.shapes, looking.others, eye[:viewed], middles[block], radii_m[block])
                counts[block] = _shade(
                    looking.shapes.formless, own, others, points, asked, viewed, ahead, eye_ahead, eye, found, eyes
                )


@compiled_part
def _view(
    looking: Looking,
    base: Base,
    place: int,
    middle: Array,
    radius_m: float,
    points: Array,
    asked: Indices,
    ahead: Array,
    eye_ahead: Array,
    eye: Array,
) -> int:
    """Bring the cells of a block that are in view to the front of ``asked``; how many there are.

    Written is where these are in the configuration's frame, and the eye that looks there, in this frame and the world.
    """
    (joints, inwards, now, ranges), lens, frames = looking.neck, looking.lens, looking.frames
    start, chest, places, turns = base
    angles, pose, carried = np.empty((len(now), TURN_COLUMNS)), np.empty(POSE), np.empty(POSE)
    aim(frames, joints, inwards, now, ranges, middle, angles, pose)
    if off_gaze(pose, middle, MARGIN * radius_m) > lens.cone_rad:
        return 0
    across_tan, up_tan = lens.half_tan
    offset = places[place] - start[:2]
    viewed = 0
    for lane in range(len(asked)):
        row, at = asked[lane], ahead[viewed]
        straight_ahead(start, chest, places, turns, place, points[row], at)
        aim(frames, joints, inwards, now, ranges, at, angles, pose)
        if in_view(pose, at, lens.cone_cos, across_tan, up_tan):
            sine, cosine = turn_towards(chest, places, turns, place, points[row])
            carry_pose(pose, start, offset, sine, cosine, carried)
            for axis in range(3):
                eye_ahead[viewed, axis], eye[viewed, axis] = pose[axis], carried[axis]
            asked[lane], asked[viewed] = asked[viewed], row
            viewed += 1
    return viewed


@compiled_part
def _from_eyes(shapes: Shapes, candidates: Indices, eyes: Array, middle: Array, radius_m: float) -> tuple[Array, Array]:
    """Those of some shapes that may stand between some eyes and points of a ball, from the middle of these eyes."""
    eye, eyes_radius_m = ball_around(eyes)
    radius = np.full(1, max(radius_m, eyes_radius_m))
    near = stand_between(shapes, candidates, -1, eye, middle.reshape(1, 3), radius)
    return from_eye(shapes, near, eye, True), eye


@compiled_part
def _shade(
    formless: Mask,
    own: tuple[Array, Array],
    others: tuple[Array, Array],
    points: Array,
    asked: Indices,
    viewed: int,
    ahead: Array,
    eye_ahead: Array,
    eye: Array,
    found: NDArray[np.uint8],
    eyes: Array,
) -> int:
    """Note which of the cells in view are seen, and keep the others at the front of ``asked``; how many these are."""
    (own_rows, own_eye), (other_rows, other_eye) = own, others
    kept = 0
    for lane in range(len(asked)):
        row, hidden = asked[lane], HIDDEN
        if lane < viewed:
            hidden = hidden_point(own_rows, formless, own_eye, eye_ahead[lane], ahead[lane])
            if hidden != HIDDEN:
                hidden = max(hidden, hidden_point(other_rows, formless, other_eye, eye[lane], points[row]))
            found[row] = min(found[row], hidden)
            for axis in range(3):
                eyes[row, axis] = eye[lane, axis]
        if hidden != CLEAR:
            asked[kept] = row
            kept += 1
    return kept


class CellsToSee:
    """What seeing asks for, whatever the effort level.

    Args:
        here: Whose ability, and from where.
        cells: What is to be seen.
    """

    first_level = 0

    def __init__(self, here: Viewpoint, cells: Cells) -> None:
        self._here, self._cells = here, cells
        self.found = np.full(len(cells.points), HIDDEN, dtype=np.uint8)
        self._eyes = np.empty((len(cells.points), 3))
        stage, agent = here.stage.show(here.state), here.agent
        seen = np.flatnonzero(stage.seen & stage.scene.hiding(here.settings.vision.transparent_alpha))
        mine = np.isin(seen, agent.geoms)
        self._own, self._others = np.setdiff1d(seen[mine], shapes_of_head(here)), seen[~mine]
        self._lens = lens_of(agent.profile.eye)

    def find(self, configuration: Configuration, places: Indices, cells: Undecided) -> None:
        """What a configuration sees at some of its places: see ``see_cells``."""
        stage, base = self._here.stage.show(configuration.state), configuration.at(places)
        looking = Looking(stage.shapes, self._own, self._others, configuration.frames, configuration.neck, self._lens)
        on_threads(lambda part: see_cells(looking, base, part, self.found, self._eyes), cells.parts(len(places)))

    def past_meshes(self, configuration: Configuration, rows: Indices) -> Mask:
        """Whether rays from where cells were just looked at get past all meshes, which have no formula, (n,).

        An agent that turns has its own where it began: they are left out.
        """
        stage, own = (
            self._here.stage.show(configuration.state),
            self._own[:0] if configuration.base.turns else self._own,
        )
        shapes = np.concatenate((own, self._others))
        meshes = shapes[stage.shapes.formless[shapes]]
        passed = np.asarray(self.found[rows] == CLEAR)
        for number in np.flatnonzero(~passed).tolist():
            eye = self._eyes[rows[number]]
            way = self._cells.points[rows[number]] - eye
            away_m = np.linalg.norm(way)
            geoms, distances_m = stage.cast(eye, way[None] / away_m, only=meshes)
            passed[number] = geoms[0] < 0 or distances_m[0] >= away_m
        return passed


def shapes_of_head(here: Viewpoint) -> Indices:
    """Shapes that the head's joints carry, and those of the body that the eye looks through, (n,)."""
    model, agent = here.stage.scene.model, here.agent
    axes = (agent.profile.pan, agent.profile.tilt)
    joints = [int(model.joint(f"{agent.name}/{axis.joint}").id) for axis in axes if axis]
    carried = {agent.eye_exclude_body, *(int(model.jnt_bodyid[joint]) for joint in joints)}
    for body in agent.bodies:  # a parent's index is always below its children's
        if int(model.body_parentid[body]) in carried:
            carried.add(int(body))
    return np.array([geom for geom in agent.geoms if int(model.geom_bodyid[geom]) in carried], dtype=np.intp)
