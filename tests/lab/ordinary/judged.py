"""An ordinary room, judged once for all tests of a process: an able adult gets at 105 of its things, nobody at 30."""

from __future__ import annotations

from functools import cache

from taskgist_lab.evaluation.ordinary_rooms import RoomsFound, judged_rooms

ROOMS, SEED = 1, 14


@cache
def found() -> RoomsFound:
    return judged_rooms(count=ROOMS, seed=SEED)
