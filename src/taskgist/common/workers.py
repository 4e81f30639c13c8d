"""Work on several cores: a function of 0, 1, 2, … by workers, its results in order; compiled work on threads.

Workers are forks of this process: they have all that it has, scenes and compiled functions among them, without
anything being sent, and a script that is not guarded by ``if __name__ == "__main__"`` is not run again. Where a
process cannot be forked safely, all is done in this one. Only a few results are ahead of the one that is asked for, so
that thousands need no memory.
"""

from __future__ import annotations

import multiprocessing
import os
import sys
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from typing import TypeVar

from taskgist.errors import InputError, WorkerError

R = TypeVar("R")
T = TypeVar("T")
AHEAD = 4
"""Calls that each worker is given ahead of the one whose result is waited for."""
_work: Callable[[int], object] | None = None


def cores() -> int:
    """How many cores this process may use for workers; 1 where none can be had, and in a worker itself."""
    if not sys.platform.startswith("linux") or multiprocessing.parent_process() is not None:
        return 1
    return len(os.sched_getaffinity(0))


def in_order(work: Callable[[int], R], count: int, processes: int | None = None) -> Iterator[R]:
    """What a function gives for 0 to ``count`` − 1, in this order; an error comes in the place of its result.

    Args:
        work: The function; what it gives, or raises, must bear pickling.
        count: How often it is called.
        processes: How many workers; None: one for each core. With one, all is done here.

    Raises:
        InputError: The number of processes is less than one.
        WorkerError: A worker was ended from outside.
    """
    if processes is not None and processes < 1:
        raise InputError("too small", field="processes", value=processes, hint="give a whole number from 1 on")
    workers = min(processes or cores(), count)
    return map(work, range(count)) if workers <= 1 or cores() == 1 else _together(work, count, workers)


def _together(work: Callable[[int], R], count: int, workers: int) -> Iterator[R]:
    context = multiprocessing.get_context("fork")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(work,))
    try:
        coming = (pool.submit(_one, number) for number in range(count))
        waiting: deque[Future[object]] = deque(_forked(coming, AHEAD * workers))
        while waiting:
            result = waiting.popleft().result()
            waiting.extend(_forked(coming, 1))
            yield result  # type: ignore[misc] # work gives R
    except BrokenProcessPool as error:
        hint = "fewer processes need less memory; one shows what went wrong"
        raise WorkerError("a worker ended before its work was done", hint=hint) from error
    finally:
        pool.shutdown(cancel_futures=True)


def _forked(coming: Iterator[Future[object]], count: int) -> list[Future[object]]:
    """The next calls, handed over, for which workers may be forked."""
    with warnings.catch_warnings():
        # What other threads hold, such as the lock of a progress bar's stream, workers do not touch; see _begin.
        warnings.simplefilter("ignore", DeprecationWarning)
        return list(islice(coming, count))


def _begin(work: Callable[[int], object]) -> None:
    """Make a worker ready; its streams are new, for a thread of the parent may have held those when it was forked."""
    global _work
    _work = work
    sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115 - for as long as the worker lives
    sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _one(number: int) -> object:
    assert _work is not None
    return _work(number)


# Threads: for compiled work, which leaves Python to others while it lasts (``compiled_for_threads``).


def on_threads(work: Callable[[T], object], parts: Sequence[T]) -> None:
    """Do all parts of some work, on as many threads as there are cores; which comes first must not matter."""
    if cores() == 1 or len(parts) == 1:
        for part in parts:
            work(part)
    else:
        with ThreadPoolExecutor(cores()) as threads:
            list(threads.map(work, parts))  # raises what any of them raised


# Progress of long work.

Progress = Callable[[str, float], None]
"""Called with what is being done and how far it is, from 0 to 1."""


def silent(_what: str, _share: float) -> None:
    """Progress that nobody watches."""
