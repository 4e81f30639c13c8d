"""Two ordinary rooms, judged once for all tests of a process."""

from __future__ import annotations

from functools import cache

from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_rooms

ROOMS, SEED = 2, 14


@cache
def found() -> RoomsFound:
    return judged_rooms(count=ROOMS, seed=SEED)
