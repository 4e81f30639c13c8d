"""Timing by the median of repeated runs, two contenders in turn."""

from __future__ import annotations

import time
from collections.abc import Callable
from statistics import median

REPEATS = 15


def seconds(run: Callable[[], object], repeats: int = REPEATS) -> float:
    """Median duration of a call, after one that does not count."""
    run()
    return median(_timed(run) for _ in range(repeats))


def ratio(slow: Callable[[], object], fast: Callable[[], object], repeats: int = REPEATS) -> tuple[float, float, float]:
    """Median durations of both, taken in turn, and the median of their ratios pair by pair."""
    slow(), fast()
    pairs = [(_timed(slow), _timed(fast)) for _ in range(repeats)]
    return median(s for s, _ in pairs), median(f for _, f in pairs), median(s / f for s, f in pairs)


def _timed(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start
