"""Which cells an agent reaches from many stances: the sector of each arm, cell by cell (5.1.2)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.maps.trials import (
    Facing,
    FreeFacing,
    Indices,
    Mask,
    Trial,
    always_free,
    facings,
    free_in,
    stances_of,
)
from taskgist.perspective.reaching.sector import ROUNDING
from taskgist.world import Arm, Pose, State
from taskgist.world.geometry.compiled import compiled

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Sectors:
    """The sectors of an agent's arms in one stance.

    Attributes:
        shoulders: Where they are, metres, (arms, 3).
        matrices: The frames of what carries the arms, (arms, 3, 3).
        arms: Length, azimuth across and outward, elevation down and up, and 1 for left or −1 for right, (arms, 6).
    """

    shoulders: Array
    matrices: Array
    arms: Array


class ReachTrials:
    """The trials of each effort level for reaching the cells of a grid.

    Args:
        here: Whose ability, and from where.
        centers: Centres of the cells, metres, (cells, 3).
    """

    def __init__(self, here: Standpoint, centers: Array) -> None:
        self._here, self._centers = here, centers
        self._arms = [arm for arm in here.agent.arms if stretch(arm.profile.side) in here.actions]
        self._numbers = np.array([_numbers(arm.profile) for arm in self._arms]).reshape(-1, 6)
        self._length_m = float(self._numbers[:, 0].max(initial=0.0))

    def of(self, level: int) -> list[Trial]:
        """Trials of a level, 0 to 4; nothing is held that is not there, so level 0 has none."""
        if level == 0 or not self._arms:
            return []
        if level == 4:
            ways = [(way, self._sectors(way.state, way.local)) for way in facings(self._here)]
            return [self._turned(*way, spot) for way in ways for spot in range(len(way[0].places_m))]
        return [
            self._fixed(self._sectors(stance.state), free_in(self._here, stance.state) if level > 1 else always_free)
            for stance in stances_of(self._here, level)
        ]

    def cull(self, cells: Indices, low_m: Array, high_m: Array) -> Mask:
        """Cells that are farther than an arm from wherever the shoulders may be."""
        return far_from_box(self._centers, cells, low_m, high_m, self._length_m + ROUNDING)

    def _sectors(
        self, state: State, local: Callable[[Pose], tuple[Array, Array]] = lambda pose: (pose.position, pose.matrix)
    ) -> Sectors:
        stage = self._here.stage.show(state)
        frames = [local(stage.shoulder(arm)) for arm in self._arms]
        return Sectors(np.array([at for at, _ in frames]), np.array([turn for _, turn in frames]), self._numbers)

    def _fixed(self, sectors: Sectors, free: Callable[[Indices], Mask]) -> Trial:
        low, high = sectors.shoulders.min(axis=0), sectors.shoulders.max(axis=0)

        def able(cells: Indices) -> Mask:
            return in_sectors(self._centers, cells, sectors.shoulders, sectors.matrices, sectors.arms, NOWHERE, False)

        return Trial(low, high, sectors.shoulders.ravel(), able, free)

    def _turned(self, way: Facing, sectors: Sectors, spot: int) -> Trial:
        place = way.places_m[spot]
        around = float(np.linalg.norm(sectors.shoulders[:, :2], axis=1).max())
        heights = sectors.shoulders[:, 2]
        low, high = (*(place - around), heights.min()), (*(place + around), heights.max())

        def able(cells: Indices) -> Mask:
            return in_sectors(self._centers, cells, sectors.shoulders, sectors.matrices, sectors.arms, place, True)

        free = FreeFacing(self._here, way, place, self._centers, clear=bool(way.clear[spot]))
        return Trial(np.array(low), np.array(high), np.array((*place, *heights)), able, free)


NOWHERE = np.zeros(2)


def _numbers(arm: Arm) -> tuple[float, ...]:
    mirror = -1.0 if arm.side == "right" else 1.0
    return (arm.length_m, *arm.azimuth_rad, *arm.elevation_rad, mirror)


@compiled
def in_sectors(
    centers: Array,
    cells: Indices,
    shoulders: Array,
    matrices: Array,
    arms: Array,
    place: Array,
    turned: bool,
) -> Mask:
    """Whether any arm reaches each of some cells; ``turned``: the shoulders are given for facing it from a place."""
    found = np.zeros(len(cells), dtype=np.bool_)
    for row in range(len(cells)):
        x, y, z = centers[cells[row], 0], centers[cells[row], 1], centers[cells[row], 2]
        if turned:
            x, y = math.hypot(x - place[0], y - place[1]), 0.0
        for arm in range(len(arms)):
            dx, dy, dz = x - shoulders[arm, 0], y - shoulders[arm, 1], z - shoulders[arm, 2]
            reach = arms[arm, 0] + ROUNDING
            if dx * dx + dy * dy + dz * dz > reach * reach:
                continue
            m = matrices
            ahead = dx * m[arm, 0, 0] + dy * m[arm, 1, 0] + dz * m[arm, 2, 0]
            left = dx * m[arm, 0, 1] + dy * m[arm, 1, 1] + dz * m[arm, 2, 1]
            up = dx * m[arm, 0, 2] + dy * m[arm, 1, 2] + dz * m[arm, 2, 2]
            azimuth = math.atan2(left * arms[arm, 5], ahead)
            elevation = math.atan2(up, math.hypot(ahead, left))
            beside = azimuth < arms[arm, 1] - ROUNDING or azimuth > arms[arm, 2] + ROUNDING
            if not beside and arms[arm, 3] - ROUNDING <= elevation <= arms[arm, 4] + ROUNDING:
                found[row] = True
                break
    return found


@compiled
def far_from_box(centers: Array, cells: Indices, low: Array, high: Array, limit: float) -> Mask:
    """Whether each of some cells is farther from a box than a limit."""
    found = np.zeros(len(cells), dtype=np.bool_)
    for row in range(len(cells)):
        squared = 0.0
        for axis in range(3):
            at = centers[cells[row], axis]
            outside = max(low[axis] - at, at - high[axis], 0.0)
            squared += outside * outside
        found[row] = squared > limit * limit
    return found
