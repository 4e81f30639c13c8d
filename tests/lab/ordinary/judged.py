"""An ordinary room, judged once for all tests of a process: of its pairs 105 are got at by an able adult, 30 by nobody."""

from __future__ import annotations

from functools import cache

from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_rooms

ROOMS, SEED = 1, 14


@cache
def found() -> RoomsFound:
    return judged_rooms(count=ROOMS, seed=SEED)
