"""Timing on one core, by the median of repeated runs; contenders take turns."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from statistics import median

from taskgist.world import Stage

Run = Callable[[], object]
REPEATS = 9


def use_one_core() -> None:
    """Keep this process, and all that it starts, on one core."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


@contextmanager
def all_cores() -> Iterator[int]:
    """Let this process, and the workers it starts, use all cores for a while; gives their number."""
    if not hasattr(os, "sched_setaffinity"):
        yield 1
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, range(os.cpu_count() or 1))
    try:
        yield len(os.sched_getaffinity(0))
    finally:
        os.sched_setaffinity(0, before)


def seconds(run: Run, repeats: int = REPEATS) -> float:
    """Median duration of a call, after one that does not count."""
    run()
    return median(once(run) for _ in range(repeats))


def in_turn(runs: Mapping[str, Run], repeats: int = REPEATS) -> dict[str, float]:
    """Median durations of several, taken in turn, after one round that does not count."""
    for run in runs.values():
        run()
    rounds = [{name: once(run) for name, run in runs.items()} for _ in range(repeats)]
    return {name: median(each[name] for each in rounds) for name in runs}


def once(run: Run) -> float:
    """Duration of one call."""
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def work(stage: Stage, run: Run) -> dict[str, int]:
    """States shown, rays cast and pairs of shapes measured on a stage during a call."""
    before = stage.counts
    run()
    return {name: count - before[name] for name, count in stage.counts.items()}


def share(values: list[float], percent: float) -> float:
    """A percentile by nearest rank."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, max(0, -(-len(ordered) * percent // 100).__trunc__() - 1))]
