"""Compare lazy verdicts with those in full in generated rooms, and tell their speed: ``python -m tools.verdicts``.

Every state has a room, by its number, and a number in it, so that one that differs is found again.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import os
import sys
import time
from collections import Counter

from taskgist.planning import Attention
from tests.learning.learning_samples import STUDY
from tests.planning.judged_rooms import room

PER_ROOM = 50
"""States judged in a room."""
Outcome = tuple[str, int, list[int], Counter[str], float, float]
"""Task, room, states of which the verdicts differ, verdicts, and CPU seconds of both kinds."""


def compare(numbered: tuple[str, int], attention: Attention) -> Outcome:
    """Verdicts on the states of one room."""
    task, number = numbered
    each = room(task, number)
    lazily, in_full, states = each.judge(attention), each.judge(attention), each.candidates(PER_ROOM, seed=number)
    start_s = time.process_time()
    lazy = [lazily.verdict(state) for state in states]
    between_s = time.process_time()
    full = [in_full.verdict(state, lazily=False) for state in states]
    full_s = time.process_time() - between_s
    differ = [
        index
        for index, (one, other) in enumerate(zip(lazy, full, strict=True))
        if (one.holds, one.failed) != (other.holds, other.failed) or not one.values.items() <= other.values.items()
    ]
    return task, number, differ, Counter(str(each.holds) for each in lazy), between_s - start_s, full_s


def main() -> int:
    """Compare; the exit status says whether all verdicts agree."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=5000, help="states to judge")
    parser.add_argument("--attention", default="stays", help="what the target agent looks at")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes")
    chosen = parser.parse_args()
    rooms = [(list(STUDY)[index % len(STUDY)], index // len(STUDY)) for index in range(-(-chosen.count // PER_ROOM))]
    found, times_s, differing = dict[str, Counter[str]](), dict[str, list[float]](), 0
    with multiprocessing.Pool(chosen.jobs) as pool:
        work = functools.partial(compare, attention=chosen.attention)
        for task, number, differ, verdicts, lazy_s, full_s in pool.imap_unordered(work, rooms):
            found.setdefault(task, Counter()).update(verdicts)
            spent = times_s.setdefault(task, [0.0, 0.0])
            spent[0], spent[1] = spent[0] + lazy_s, spent[1] + full_s
            differing += len(differ)
            if differ:
                print(f"{task}, room {number}: states {differ} differ")
    for task, verdicts in found.items():
        count = verdicts.total()
        lazy_ms, full_ms = (1000 * spent / count for spent in times_s[task])
        print(f"{task}: {count} states, {dict(verdicts)}; {lazy_ms:.1f} ms each lazily, {full_ms:.1f} ms in full")
    print(f"{sum(each.total() for each in found.values())} states, {differing} differ")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
