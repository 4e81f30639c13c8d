"""The twin's grasps: every sampled one is tried, nearest first, against every solid shape.

Which grasps there are, of a thing as it lies and of one that was tilted or slid, it shares with the fast search.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective import Viewpoint
from taskgist.perspective.grasp import Grasp
from taskgist.perspective.grasp_sampling import Grasps, hand_centers, hand_frames
from taskgist.world import ArmIndices, Hand, Pose, Stage
from taskgist.world.bodies.hands import Palms

if TYPE_CHECKING:
    from tests.perspective.twin import Twin

Array = NDArray[np.float64]
TOUCH_M = 1e-4
Found = tuple[tuple[str, ...], float]
"""Sides of the hands that grasp, and the distance that decides between equal amounts."""


class Tried:
    """Grasps in the world, tried one by one; what stands there is the same from every state.

    Args:
        twin: Whose.
        grasps: In the world.
        hand: What closes.
    """

    def __init__(self, twin: Twin, grasps: Grasps, hand: Hand | Palms) -> None:
        self._twin, self.grasps, self._hand = twin, grasps, hand
        self._blocked: dict[int, bool] = {}

    def distances(self, arm: ArmIndices, points: Array) -> Array:
        """From an arm's shoulder to each point of a grasp, infinite where it does not reach it from ahead."""
        twin = self._twin
        distances = twin.within(arm.shoulder_site, arm.carrier_body, arm.profile, points)
        ahead = points - twin.world.data.site_xpos[arm.shoulder_site]
        facing = np.sum(self.grasps.approaches * ahead, axis=1)
        behind = facing < twin.settings.grasp.facing * np.linalg.norm(ahead, axis=1) - 1e-9
        return np.where(behind, np.inf, distances)

    def nearest(self, distances: Array, ghosts: Sequence[int]) -> float | None:
        """The least distance of a grasp that is free, in the state that the twin's world shows."""
        for index in np.argsort(distances):
            if not np.isfinite(distances[index]):
                return None
            if self._free(ghosts, int(index)):
                return float(distances[index])
        return None

    def _free(self, ghosts: Sequence[int], index: int) -> bool:
        world, states = self._twin.world, self._twin.states
        for ghost, pose in zip(ghosts, hand_poses(self.grasps, index, self._hand), strict=True):
            world.data.geom_xpos[ghost], world.data.geom_xmat[ghost] = pose.position, pose.matrix.ravel()
        if index not in self._blocked:
            self._blocked[index] = bool(self.grasps.in_itself[index]) or any(
                depth > TOUCH_M and other not in self.grasps.solids
                for (_, other), depth in world.depths(ghosts, states.solid).items()
            )
            others = np.setdiff1d(states.solid, self.grasps.solids)
            self._blocked[index] |= something_between(self._twin.stage, self.grasps, index, others)
        if self._blocked[index]:
            return False
        return all(depth <= TOUCH_M for depth in world.depths(ghosts, states.core).values())


def something_between(stage: Stage, grasps: Grasps, index: int, others: NDArray[np.intp]) -> bool:
    """Whether a pad of a grasp in the world meets one of some shapes before it meets the object."""
    gap_m, closing = grasps.gaps_m[index], grasps.closings[index]
    for sign in (-1.0, 1.0):
        pad = grasps.centers[index] + sign * closing * (grasps.widths_m[index] / 2 + gap_m)
        met, distances, _ = stage.cast_each(others, pad[None], -sign * closing[None])
        if met[0] >= 0 and distances[0] < gap_m - TOUCH_M:
            return True
    return False


class TwinGrasps:
    """All ways to grasp an object where it is.

    Args:
        twin: Whose, and where.
        name: The object.
    """

    def __init__(self, twin: Twin, name: str) -> None:
        self._twin = twin
        here = Viewpoint(twin.stage.show(twin.state), twin.agent.name, twin.settings)
        judge = Grasp(here, here.target(name))
        hand = twin.agent.profile.hand
        assert hand is not None

        def tried(way: object) -> Tried | None:
            return None if way is None else Tried(twin, way.grasps, hand)  # type: ignore[attr-defined]

        self._plain, self._tilted = tried(judge.plain), tried(judge.tilted)
        self._slid, self._drawn = tried(judge.slid), tried(judge.drawn)
        assert self._plain is not None
        between = judge.between
        self._between = None if between is None else Tried(twin, between.grasps, hand.palms)  # type: ignore[arg-type]

    def found(self) -> list[Found]:
        """How the object can be grasped by the way of least trouble, in the state that the twin's world shows."""
        return next((found for found in self._by_way() if found), [])

    def _by_way(self) -> Iterator[list[Found]]:
        plain = self._plain
        assert plain is not None
        arms = [arm for arm in self._twin.agent.arms if np.isfinite(plain.distances(arm, plain.grasps.centers)).any()]
        yield self._with_one(plain, arms)
        if self._tilted is not None:
            yield self._with_one(self._tilted, arms)
        if self._between is not None:
            yield self._with_both(self._between)
        if self._slid is not None:
            yield self._with_one(self._slid, arms)
        if self._drawn is not None:
            yield self._with_one(self._drawn, arms)

    def _with_one(self, tried: Tried, arms: Sequence[ArmIndices]) -> list[Found]:
        found: list[Found] = []
        for arm in arms:
            distance = tried.nearest(tried.distances(arm, tried.grasps.centers), arm.ghosts.tolist())
            if distance is not None:
                found.append(((arm.profile.side,), distance))
        return found

    def _with_both(self, tried: Tried) -> list[Found]:
        grasps, arms = tried.grasps, [self._twin.agent.arm(side) for side in ("left", "right")]
        half = grasps.closings * grasps.widths_m[:, None] / 2
        points = (grasps.centers - half, grasps.centers + half)
        distances = [tried.distances(arm, at) for arm, at in zip(arms, points, strict=True)]
        distance = tried.nearest(distances[0] + distances[1], [arm.flat_ghost for arm in arms])
        return [] if distance is None else [(("left", "right"), distance)]


def hand_poses(grasps: Grasps, index: int, hand: Hand | Palms) -> tuple[Pose, ...]:
    """Poses of the boxes of ``hand_boxes`` in one grasp."""
    one = grasps.only(np.array([index]))
    matrix = hand_frames(one)[0]
    return tuple(Pose(center, matrix) for center in hand_centers(one, hand)[0])


def touched(grasps: Grasps, index: int) -> frozenset[int]:
    """The solid shapes that the fingers of a grasp close on."""
    return frozenset(grasps.solids[grasps.touching[index]].tolist())
