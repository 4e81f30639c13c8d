"""Scanning: which cells does any of many trials win?

Only that one of them does is asked, not which one needs least, so their order is free. A few that differ most come
first and win most cells. The others are halved again and again by where they are; of a box around many trials it is
often plain that none can win a cell (it is hidden from the whole box, or out of its reach).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from taskgist.perspective.maps.trials import Indices, Mask, Trial

Array = NDArray[np.float64]
FIRST = 8
"""How many trials come before all others are divided."""
Cull = Callable[[Indices, Array, Array], Mask]
"""Whether it is plain that no trial in a box (low, high) wins each of some cells."""


def winners(trials: Sequence[Trial], cells: Indices, cull: Cull) -> Indices:
    """Those of some cells towards which any of the trials gives the ability.

    Args:
        trials: What may win them.
        cells: By index, (n,).
        cull: May say in advance that a box of trials is in vain.
    """
    if not trials:
        return cells[:0]
    won = _Won(cells)
    cells = cells[~cull(cells, *_box(trials))]
    first = _different(trials)
    for index in first:
        won.by(trials[index], won.open(cells))
    rest = [trial for index, trial in enumerate(trials) if index not in set(first)]
    _divided(rest, cells, cull, won)
    return won.cells


class _Won:
    """Keeps which cells are won."""

    def __init__(self, cells: Indices) -> None:
        self._won = np.zeros(int(cells.max(initial=-1)) + 1, dtype=bool)

    def open(self, cells: Indices) -> Indices:
        return cells[~self._won[cells]]

    def by(self, trial: Trial, cells: Indices) -> None:
        able = cells[trial.able(cells)]
        if len(able):
            self._won[able[trial.free(able)]] = True

    @property
    def cells(self) -> Indices:
        return np.flatnonzero(self._won)


def _divided(trials: Sequence[Trial], cells: Indices, cull: Cull, won: _Won) -> None:
    cells = won.open(cells)
    if not trials or not len(cells):
        return
    if len(trials) == 1:
        won.by(trials[0], cells)
        return
    low, high = _box(trials)
    cells = cells[~cull(cells, low, high)]
    axis = int(np.argmax(high - low))
    ordered = sorted(trials, key=lambda trial: float(trial.low_m[axis]))
    half = len(ordered) // 2
    _divided(ordered[:half], cells, cull, won)
    _divided(ordered[half:], cells, cull, won)


def _box(trials: Sequence[Trial]) -> tuple[Array, Array]:
    """The box around those of all trials."""
    return np.min([trial.low_m for trial in trials], axis=0), np.max([trial.high_m for trial in trials], axis=0)


def _different(trials: Sequence[Trial]) -> list[int]:
    """Indices of trials whose marks lie far apart: each is the farthest from those before it."""
    marks = np.array([trial.mark for trial in trials])
    chosen = [0]
    away = np.linalg.norm(marks - marks[0], axis=1)
    while len(chosen) < min(FIRST, len(trials)):
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(marks - marks[chosen[-1]], axis=1))
    return list(dict.fromkeys(chosen))
