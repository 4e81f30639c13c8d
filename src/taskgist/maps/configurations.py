"""Configurations of an agent from which cells are seen and reached, and where nothing is in the way of them.

They are the search's own, level by level, all of them. At level 4 the agent stands anywhere on the floor that it can
get to, and the search turns its chest to the target; so does a map, to every cell by itself::

    configuration   torso, posture and base as the search has them, the chest somewhere
    place           where the base is moved to
    turn            about the vertical through the base, until the chest faces the cell

What a map asks is asked in the frame of the configuration as it is: there the cell is straight ahead of the chest, as
far away as it is from the place. Only what is in the way is tested in steps of the chest, from where the agent heads
now, for there are too many cells to test each of their directions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.common.compiled import compiled_part
from taskgist.perspective.candidates import Candidates, Neck
from taskgist.perspective.constraints import Collisions
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.world.geometry.transforms import yaw_of
from taskgist.world.state import State

AHEAD_M = 1000.0
SAME_M = 1e-9
LEVEL = 0.999
"""Cosine of the slope of what counts as a level floor."""
OVERHEAD_M = 1e-9
"""Nobody turns to what is this near to the axis of the base."""


class Base(NamedTuple):
    """Where a configuration may be brought, as compiled functions take it.

    Attributes:
        start: Where its base is, metres, (3,).
        chest: Cosine and sine of the direction that its chest faces, (2,).
        places: Where the base may be instead, metres in the world, (p, 2).
        turns: Whether the chest then turns to each cell; otherwise nothing moves.
    """

    start: Array
    chest: Array
    places: Array
    turns: bool


class Configuration:
    """An agent bent, turned, standing or sitting in some way, and all places that its base can get to so.

    Args:
        here: The agent's viewpoint.
        collisions: What the agent would push into.
        state: The configuration.
        frames: Where it brings the agent's frames, (f, 12).
        shoulders: Where it brings the shoulders of all its arms, (arms, 12); where they may be thrust forward, that
            comes after, (2 arms, 12).
        neck: The joints of the head that may be used.
        base: Where it may be brought.

    Attributes:
        clear: The places at which nothing can be in the way, wherever the chest faces, (n,).
        doubtful: The others, (m,).
    """

    def __init__(
        self,
        here: Viewpoint,
        collisions: Collisions,
        state: State,
        frames: Array,
        shoulders: Array,
        neck: Neck,
        base: Base,
    ) -> None:
        self._collisions = collisions
        self.state, self.frames, self.shoulders, self.neck, self.base = state, frames, shoulders, neck, base
        free = self._surely_free(here) if base.turns else np.ones(len(base.places), dtype=bool)
        self.clear, self.doubtful = np.flatnonzero(free), np.flatnonzero(~free)
        self._heading = yaw_of(here.state.qpos[here.agent.base][3:])
        self._step = here.settings.efforts.turn_step_rad
        self._known: dict[tuple[int, int], bool] = {}

    def at(self, places: Indices) -> Base:
        """The same at some of its places."""
        return self.base._replace(places=self.base.places[places])

    def free(self, here: Viewpoint, place: int, points: Array) -> Mask:
        """Whether nothing is in the way at a place, with the chest turned to each of some points, (k, 3); (k,)."""
        if place in self.clear:
            return np.ones(len(points), dtype=bool)
        ahead = points[:, :2] - self.base.places[place]
        turns = (np.arctan2(ahead[:, 1], ahead[:, 0]) - self._heading) / self._step
        steps = np.rint(np.round(turns, 9)).astype(int) % round(2 * math.pi / self._step)
        return np.array([self._free(here, place, step) for step in steps.tolist()], dtype=bool)

    def _free(self, here: Viewpoint, place: int, step: int) -> bool:
        """Place the agent's shapes, and ask what they push into."""
        if (place, step) not in self._known:
            stage, core = here.stage.show(self.state), here.agent.core_geoms
            positions, matrices = stage.geoms(core)
            angle = self._heading + step * self._step - math.atan2(self.base.chest[1], self.base.chest[0])
            cos, sin = math.cos(angle), math.sin(angle)
            turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
            start, there = np.array([*self.base.start[:2], 0.0]), np.array([*self.base.places[place], 0.0])
            stage.place(core, (positions - start) @ turn.T + there, (turn @ matrices.reshape(-1, 3, 3)).reshape(-1, 9))
            self._known[place, step] = self._collisions.find() is None
        return self._known[place, step]

    def _surely_free(self, here: Viewpoint) -> Mask:
        """Whether the agent plainly collides with nothing at each place, whatever its heading, (p,).

        Turning about the vertical through its base, each of its shapes stays in a cylinder. The boxes around solid
        shapes must keep away from these. The level floor is left out: it is met alike at all places.
        """
        stage, model = here.stage.show(self.state), here.stage.scene.model
        core, obstacles = here.agent.core_geoms, self._collisions.obstacles
        endless = model.geom_rbound[obstacles] == 0.0
        upright = stage.geoms(obstacles[endless])[1].reshape(-1, 3, 3)[:, 2, 2]
        if (upright < LEVEL).any():
            return np.zeros(len(self.base.places), dtype=bool)
        centers, radii = stage.geom_centers(core), np.asarray(model.geom_rbound[core])
        wide = np.linalg.norm(centers[:, :2] - self.base.start[:2], axis=1) + radii
        solid = obstacles[~endless]
        matrices, bounds = stage.geoms(solid)[1].reshape(-1, 3, 3), model.geom_aabb[solid]
        middle = stage.geom_centers(solid) + np.einsum("nij,nj->ni", matrices, bounds[:, :3])
        half = np.einsum("nij,nj->ni", np.abs(matrices), bounds[:, 3:])
        beside = np.abs(centers[:, 2, None] - middle[:, 2]) < radii[:, None] + half[:, 2]
        widest = np.where(beside, wide[:, None], 0.0).max(axis=0)
        away = np.maximum(np.abs(self.base.places[:, None] - middle[:, :2]) - half[:, :2], 0.0)
        return np.asarray((np.hypot(away[..., 0], away[..., 1]) >= widest).all(axis=1))


def configurations(here: Viewpoint, level: int) -> Iterator[Configuration]:
    """The configurations of an effort level, 0 to 4, in which nothing is in the way, but for where they are brought.

    Those of level 4 come as in the search, others from the greatest amount to the least: what cells are left from lower
    levels mostly need much. What touches now is no obstacle to staying as one is.
    """
    now = np.array(here.state.qpos[here.agent.base])
    heading = yaw_of(now[3:])
    target = now[:3] + AHEAD_M * np.array([math.cos(heading), math.sin(heading), 0.0])
    batches = list(here.candidates.of_level(level, target))
    if level == 4 and batches:
        places = np.array([place.offset_m for place in here.candidates.places])
        offsets = np.unique(np.round(places, 9), axis=0)
    for candidates in _first_of_each_posture(batches) if level == 4 else batches:
        agent_frames = candidates.torso.frames
        neck = agent_frames.usable(here.actions if level else frozenset()).neck
        collisions = here.collisions_of(candidates.torso.start)
        for index in range(len(candidates)) if level == 4 else reversed(range(len(candidates))):
            state, frames = candidates[index].state, candidates.frames(index)
            if level < 4 and (level <= 1 or collisions.blocking(state) is None):
                base = Base(now[:3], np.zeros(2), now[None, :2], turns=False)
            elif level == 4 and np.abs(candidates.offsets_m[index]).max() < SAME_M:
                start = np.array(state.qpos[here.agent.base][:3])
                ahead = (target - start)[:2]
                base = Base(start, ahead / np.linalg.norm(ahead), start[:2] + offsets, turns=True)
            else:
                continue
            shoulders = frames[agent_frames.first_shoulder :]
            shoulders = shoulders if candidates.torso.thrusts else shoulders[: len(here.agent.arms)]
            yield Configuration(here, collisions, state, frames, shoulders, neck, base)


def _first_of_each_posture(batches: Sequence[Candidates]) -> list[Candidates]:
    """Of the batches in which the search walks, those near to where the agent is: one for each posture."""
    return list({id(batch.torso): batch for batch in reversed(batches)}.values())[::-1]


@compiled_part
def straight_ahead(
    start: Array, chest: Array, places: Array, turns: bool, place: int, point: Array, ahead: Array
) -> None:
    """Write where a point, (3,), is in the frame of a configuration, (3,), if its base is brought to a place.

    The first four are those of a ``Base``.
    """
    ahead[0], ahead[1], ahead[2] = point[0], point[1], point[2]
    if turns:
        x, y = point[0] - places[place, 0], point[1] - places[place, 1]
        away = math.sqrt(x * x + y * y)
        ahead[0], ahead[1] = start[0] + away * chest[0], start[1] + away * chest[1]


@compiled_part
def turn_towards(chest: Array, places: Array, turns: bool, place: int, point: Array) -> tuple[float, float]:
    """Sine and cosine of the turn of a configuration at a place, for a point, (3,); see ``straight_ahead``."""
    x, y = point[0] - places[place, 0], point[1] - places[place, 1]
    away = math.sqrt(x * x + y * y)
    if not turns or away <= OVERHEAD_M:
        return 0.0, 1.0
    return (y * chest[0] - x * chest[1]) / away, (x * chest[0] + y * chest[1]) / away
