"""Things that no hand can take as they lie: tilted about an edge first, slid over the support's edge, or drawn aside.

A book on a table has its only graspable faces one above the other, and the lower one lies on the table. People tilt it
about its far edge until fingers fit beneath, if there is room to tilt. People and robots slide it over an edge of what
it lies on, if nothing stands in the way, until enough of it sticks out. What lies against a wall, or in the corner of a
bin, people draw aside by a little more than a finger. All give the grasps that there are then, in the object's frame
as it lies now, so that they are tried like all others.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from taskgist.common.arrays import Array, Indices, Mask
from taskgist.perspective.grasp_sampling import PER_GRASP, Grasps
from taskgist.perspective.sliding import CLEAR_M, Sliding
from taskgist.perspective.target import Target
from taskgist.perspective.viewpoint import Viewpoint
from taskgist.settings import Grasp
from taskgist.world.geometry.shapes import lowest_point
from taskgist.world.geometry.transforms import Pose

DIRECTIONS = 8
"""In how many level directions a thing is drawn aside, evenly, from an axis of its own (ours)."""
STEEP = -0.5
"""Least steepness at which hands come for what was drawn aside: in a corner, or a bin, they come from above (ours)."""
SECTORS = 16
"""In how many level directions a thing is tilted or slid, at most (ours)."""


def _upright(grasps: Grasps, settings: Grasp) -> Mask:
    """Which grasps in the world close from above and beneath, (n,)."""
    return np.asarray(np.abs(grasps.closings[:, 2]) >= math.cos(settings.upright_rad))


def closes_sideways(grasps: Grasps, settings: Grasp) -> bool:
    """Whether a hand closes on a thing otherwise than from above and beneath; its grasps are in the world."""
    return bool((~grasps.in_itself & ~_upright(grasps, settings)).any())


def is_flat(grasps: Grasps, settings: Grasp) -> bool:
    """Whether hands close on a thin thing from above and beneath, and it is wider than that from all sides.

    Args:
        grasps: Its grasps, in the world.
        settings: What is thin, and how much wider it must be.
    """
    sideways = np.abs(grasps.closings[:, 2]) <= math.sin(settings.upright_rad)
    thickness_m = float(grasps.widths_m[_upright(grasps, settings)].min(initial=np.inf))
    widest_m = float(grasps.widths_m[sideways].min(initial=np.inf))
    return thickness_m <= settings.flat_m and widest_m >= settings.flat_ratio * thickness_m


class LyingThing:
    """An object that lies on something.

    Args:
        here: Whose hands are to take it.
        target: The object.
        pose: Where it lies.
        grasps: Its grasps as it lies, in its own frame.
    """

    def __init__(self, here: Viewpoint, target: Target, pose: Pose, grasps: Grasps) -> None:
        self._here, self._pose, self._grasps = here, pose, grasps
        self._in_world = grasps.placed(pose)
        stage = here.stage
        offset = pose.position - stage.body_position(stage.scene.object_body(target.name))
        self._points = target.points + offset
        self._seen = [(geom, stage.geom(geom)) for geom in target.shapes.tolist()]
        self._offset = offset
        settings = here.settings.grasp
        radius_m = float(np.linalg.norm(self._points - pose.position, axis=1).max(initial=0.0))
        around, _ = here.collisions.around(pose.position, radius_m + settings.slide_m + settings.overhang_m)
        obstacles = np.setdiff1d(around, grasps.solids)
        self._sliding = Sliding(stage, grasps.solids, self._points, obstacles, settings, offset=offset)

    def _by_direction(self) -> Iterator[tuple[Array, Mask]]:
        """Level directions in which the hand comes when it closes from above and beneath, and the grasps of each."""
        approaches = self._in_world.approaches
        lying = _upright(self._in_world, self._here.settings.grasp) & ~self._grasps.in_itself
        lying &= np.hypot(approaches[:, 0], approaches[:, 1]) > math.sqrt(0.5)
        angles = np.arctan2(approaches[:, 1], approaches[:, 0]) - self._heading_rad
        sectors = np.round(angles * SECTORS / (2 * math.pi)).astype(int) % SECTORS
        for sector in np.unique(sectors[lying]).tolist():
            yield self._direction(sector / SECTORS), lying & (sectors == sector)

    @property
    def _heading_rad(self) -> float:
        """Where that axis of its frame looks which is most level, about the vertical."""
        ahead = self._pose.matrix[:2, np.argmin(np.round(np.abs(self._pose.matrix[2]), 6))]
        return math.atan2(ahead[1], ahead[0])

    def _direction(self, share: float) -> Array:
        """A level direction, that share of a whole turn from its own heading, (3,)."""
        angle_rad = self._heading_rad + 2 * math.pi * share
        return np.array((math.cos(angle_rad), math.sin(angle_rad), 0.0))

    def tilted(self) -> Grasps:
        """Its grasps when it is tilted about the edge that is farthest from the hand, where there is room for that."""
        found = []
        for direction, rows in self._by_direction():
            for angle_rad in self._here.settings.grasp.tilts_rad:
                turn = _about(np.array((-direction[1], direction[0], 0.0)), angle_rad)
                shift = self._onto_edge(turn)
                turned = (self._sliding.positions - self._pose.position) @ turn.T + shift
                if self._sliding.is_free(turned, turn @ self._sliding.matrices):
                    found.append(self._moved(rows, turn, shift))
        return _joined(self._grasps, found)

    def _onto_edge(self, turn: Array) -> Array:
        """Where the middle of the thing gets when it turns about what is then its lowest point, metres, (3,)."""
        model = self._here.stage.scene.model
        before, after = [], []
        for geom, pose in self._seen:
            point = lowest_point(model, geom, turn @ pose.matrix)
            if point is not None:
                before.append(pose.to_world(point) + self._offset)
                after.append((before[-1] - self._pose.position) @ turn.T)
        lowest = int(np.argmin([point[2] for point in after]))
        shift = before[lowest] - after[lowest]
        shift[2] = self._points[:, 2].min() - after[lowest][2] + CLEAR_M
        return np.asarray(shift)

    def slid(self) -> Grasps:
        """Its grasps when it is slid over an edge of what it lies on, where nothing stands in the way."""
        found = []
        for direction, rows in self._by_direction():
            way = -direction  # the hand comes towards what sticks out
            over = self._sliding.over_edge(way)
            if over is not None:
                beyond = rows & (self._in_world.centers @ way >= (self._points @ way).max() - over.out_m)
                found.append(self._moved(beyond, np.eye(3), self._pose.position + way * over.by_m))
        return _joined(self._grasps, found)

    def drawn(self) -> Grasps:
        """Its grasps from above when it is drawn aside a little, where nothing stands in the way."""
        found = []
        steep = (self._in_world.approaches[:, 2] <= STEEP) & ~self._grasps.in_itself
        for turn, by_m in itertools.product(range(DIRECTIONS), self._here.settings.grasp.asides_m):
            way = self._direction(turn / DIRECTIONS)
            if self._sliding.is_free_along(way, by_m):
                found.append(self._moved(steep, np.eye(3), self._pose.position + way * by_m))
        return _joined(self._grasps, found)

    def _moved(self, rows: Mask | Indices, turn: Array, position: Array) -> Grasps:
        """Some grasps, the thing having been turned about its frame's origin, which has come to a position."""
        grasps = self._in_world.only(rows)
        pose = self._pose
        centers = (grasps.centers - pose.position) @ turn.T + position
        return replace(
            grasps,
            centers=pose.to_local(centers),
            closings=grasps.closings @ turn.T @ pose.matrix,
            approaches=grasps.approaches @ turn.T @ pose.matrix,
        )


def _about(axis: Array, angle_rad: float) -> Array:
    """The matrix (3, 3) of a turn about a unit axis (Rodrigues)."""
    x, y, z = axis.tolist()
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle_rad) * cross + (1 - math.cos(angle_rad)) * cross @ cross)


def _joined(of: Grasps, parts: list[Grasps]) -> Grasps:
    """Some sets of grasps of one object as one."""
    if not parts:
        return of.only(np.empty(0, dtype=np.intp))
    joined = {field: np.concatenate([getattr(part, field) for part in parts]) for field in PER_GRASP}
    return replace(of, **joined)  # type: ignore[arg-type]  # all fields of PER_GRASP are arrays
