"""Compare the perspective's fast answers with their slow twins in many random rooms: ``make twins COUNT=2000``.

The tests do so in a few rooms. Levels and pixels are those of a room as it stands; who follows a room in which
something moves is compared with who looks at each frame afresh.

Every room has its number; ``python -m tools.twins --first 17 --count 1`` looks at room 17 again.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import os
import sys
import time
from dataclasses import replace

from taskgist.settings import DEFAULT, Settings
from tests.perspective.comparing import Comparison, compare_following, compare_levels, compare_pixels
from tests.perspective.random_rooms import random_case
from tools.rooms import ROUGH

FINE = replace(DEFAULT, reach=ROUGH.reach)


def compare(seed: int, settings: Settings = ROUGH) -> tuple[Comparison, Comparison, Comparison]:
    """Levels of one of the agents, and pixels and what is followed of all of them, in one room."""
    case = random_case(seed)
    agents = case.scene.agents
    levels = compare_levels(case, agents[seed % len(agents)], settings)
    return levels, compare_pixels(case), compare_following(random_case(seed, image_px=(48, 36)))


def main() -> int:
    """Compare; the exit status says whether all answers agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="rooms to compare")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    parser.add_argument("--fine", action="store_true", help="states as fine as the default settings have them: slow")
    chosen = parser.parse_args()
    levels, pixels, following, start = Comparison(), Comparison(), Comparison(), time.perf_counter()
    seeds = range(chosen.first, chosen.first + chosen.count)
    with multiprocessing.get_context("spawn").Pool(chosen.jobs) as pool:
        one = functools.partial(compare, settings=FINE if chosen.fine else ROUGH)
        for of_levels, of_pixels, of_following in pool.imap_unordered(one, seeds):
            for line in (*of_levels.differences, *of_pixels.differences, *of_following.differences):
                print(line, flush=True)
            levels += of_levels
            pixels += of_pixels
            following += of_following
    return report(chosen.count, levels, pixels, following, time.perf_counter() - start)


def report(rooms: int, levels: Comparison, pixels: Comparison, following: Comparison, seconds: float) -> int:
    """Print what was compared."""
    print(f"{rooms} rooms in {seconds:.0f} s")
    print(f"efforts: {levels.count} compared, {len(levels.differences)} differ")
    for (ability, level), count in sorted(levels.levels.items(), key=str):
        print(f"  {ability} {'unknown' if level is None else level}: {count}")
    print(f"images and objects in them: {pixels.count} compared, {len(pixels.differences)} differ")
    print(f"efforts that are followed: {following.count} compared, {len(following.differences)} differ")
    return 1 if levels.differences or pixels.differences or following.differences else 0


if __name__ == "__main__":
    sys.exit(main())
