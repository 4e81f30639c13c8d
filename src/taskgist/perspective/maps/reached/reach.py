"""Which cells an agent reaches from many stances: the sector of each arm, cell by cell (5.1.2)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.acting.standpoint import Standpoint
from taskgist.perspective.acting.virtual_actions import stretch
from taskgist.perspective.maps.cells import Cells
from taskgist.perspective.maps.footing import Footing, footing_of
from taskgist.perspective.maps.reached.sectors import (
    ARM_COLUMNS,
    AT_EASE,
    CARRIER,
    LENGTH,
    SHOULDER,
    Reaches,
    reached_cells,
)
from taskgist.perspective.maps.tree import tree_of
from taskgist.perspective.maps.trials import Indices, Mask, Sweep, Trials
from taskgist.perspective.reaching.sector import ROUNDING
from taskgist.world import Arm

Array = NDArray[np.float64]
EVERYWHERE = -2.0
"""In place of the cosine of half a circle: there is no angle beyond, whatever the rounding."""
EASE = 0.6
"""Share of an arm's length at which it reaches most directions, whatever way the agent leans."""


class CellsToReach:
    """What reaching asks for, whatever the effort level.

    Args:
        here: Whose ability, and from where.
        cells: What is to be reached.
    """

    def __init__(self, here: Standpoint, cells: Cells) -> None:
        self.here, self.cells = here, cells
        self.arms = [arm for arm in here.agent.arms if stretch(arm.profile.side) in here.actions]

    def trials(self, level: int) -> Trials | None:
        """The trials of a level, 0 to 4; nothing is held that is not there, so level 0 has none."""
        if level == 0 or not self.arms:
            return None
        footing = footing_of(self.here, level)
        return ReachTrials(self, footing) if len(footing.way) else None


class ReachTrials:
    """The trials of one effort level for reaching cells."""

    def __init__(self, asking: CellsToReach, footing: Footing) -> None:
        self.footing, self.cells, self._asking = footing, asking.cells, asking
        self._table = np.array([self._arms_of(way) for way in range(len(footing.states))])
        tree = tree_of(*self._boxes())
        self._reaches = Reaches(self._table, footing.way, footing.places_m, footing.turns, tree)

    def run(self, sweep: Sweep) -> None:
        """See ``Trials``."""
        reached_cells(self._reaches, sweep, self.cells.starts(sweep.rows))

    def look_closely(self, rows: Indices) -> Mask:
        """Nothing is doubtful."""
        return np.zeros(len(rows), dtype=bool)

    def _arms_of(self, way: int) -> Array:
        """Arms in the frame of a way, (arms, columns)."""
        here, frame = self._asking.here, self.footing.frame(way)
        stage = here.stage.show(self.footing.states[way])
        table = np.empty((len(self._asking.arms), ARM_COLUMNS))
        for row, arm in zip(table, self._asking.arms, strict=True):
            shoulder = stage.shoulder(arm)
            row[SHOULDER:CARRIER] = frame.to_local(shoulder.position)
            row[CARRIER:LENGTH] = (frame.matrix.T @ shoulder.matrix).ravel()
            row[LENGTH:AT_EASE] = _sector(arm.profile)
            row[AT_EASE:] = frame.to_local(shoulder.to_world(_at_ease(arm.profile)))
        return table

    def _boxes(self) -> tuple[Array, Array]:
        """The boxes in which the shoulders stay, least and greatest coordinates, (trials, 3) each."""
        shoulders = self._table[self.footing.way][:, :, SHOULDER:CARRIER]
        low, high = shoulders.min(axis=1), shoulders.max(axis=1)
        if self.footing.turns:
            around = np.hypot(shoulders[..., 0], shoulders[..., 1]).max(axis=1)[:, None]
            low[:, :2], high[:, :2] = self.footing.places_m - around, self.footing.places_m + around
        return low, high


def _sector(arm: Arm) -> tuple[float, ...]:
    """Numbers of a sector; see ``sectors``."""
    mirror = -1.0 if arm.side == "right" else 1.0
    return (arm.length_m, *_between(*arm.azimuth_rad, mirror), *_between(*arm.elevation_rad, 1.0))


def _between(low: float, high: float, mirror: float) -> tuple[float, float, float]:
    """Cosine and sine of the middle of a range of angles, and cosine of half its width."""
    middle, half = (low + high) / 2, (high - low) / 2 + ROUNDING
    return math.cos(middle), mirror * math.sin(middle), math.cos(half) if half < math.pi else EVERYWHERE


def _at_ease(arm: Arm) -> Array:
    """A point in the middle of an arm's sector, in the frame of what carries it, metres, (3,)."""
    azimuth, elevation = sum(arm.azimuth_rad) / 2, sum(arm.elevation_rad) / 2
    flat, mirror = math.cos(elevation), -1.0 if arm.side == "right" else 1.0
    direction = np.array((flat * math.cos(azimuth), mirror * flat * math.sin(azimuth), math.sin(elevation)))
    return EASE * arm.length_m * direction
