"""Adding to knowledge: what it costs, and how long others wait for it, whatever is there already."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any

from sqlalchemy import Connection, insert

from benchmarks.figure import Figure
from benchmarks.timing import in_turn
from taskgist.facts import Episode, Observation
from taskgist.learning import Explanation, Knowledge, explain
from taskgist.store import save, tables, update
from taskgist.store.connecting import transact

FEW, MANY = 100, 100_000
TASKS = ("give", "hide", "show")
HELD = 50
"""Additions whose lock is timed."""


def figures() -> Iterator[Figure]:
    """Adding one demonstration to knowledge of many, beside adding it to knowledge of few."""
    with tempfile.TemporaryDirectory() as folder:
        few, many = (filled(Path(folder) / f"{count}.db", count) for count in (FEW, MANY))
        fresh = iter(range(10**9, 2 * 10**9))
        runs = {"ours": lambda: add(many, next(fresh)), f"adding it to {FEW:,}": lambda: add(few, next(fresh))}
        beside = in_turn(runs, 51)
        held = sorted(held_s(many, next(fresh)) for _ in range(HELD))
        ours = beside.pop("ours")
        yield Figure(
            "store",
            f"adding a demonstration to a file of {MANY:,}, synced",
            ours,
            beside,
            goal="at most twice as long as to 100",
            met=ours <= 2.0 * min(beside.values()),
            note=f"others wait {1000 * median(held):.2g} ms for it, {1000 * held[-1]:.2g} ms at most of {HELD}",
        )


def add(path: Path, number: int) -> None:
    """One addition, as ``taskgist learn`` makes it."""
    update(path, [demonstration(number)], relabelled="refuse")


def held_s(path: Path, number: int) -> float:
    """How long an addition keeps other writers out, without the final sync."""
    spent: list[float] = []
    adding = tables.add

    def timed(*args: Any, **options: Any) -> None:
        start = time.perf_counter()
        adding(*args, **options)
        spent.append(time.perf_counter() - start)

    tables.add = timed
    try:
        add(path, number)
    finally:
        tables.add = adding
    return spent[0]


def demonstration(number: int) -> Explanation:
    """One of many, each of another recording."""
    start = {"see.effort": Observation("Head_Effort"), "posture": Observation("Sitting")}
    end = {"see.effort": Observation("No_Effort_Required"), "posture": Observation("Sitting")}
    task, source = TASKS[number % len(TASKS)], f"{number:016x} 0.0000-2.0000 s"
    return explain(Episode(task, f"demonstration {number}", "P1", "P2", "cup", start, end, source=source))


def filled(path: Path, count: int, of: Callable[[int], Explanation] = demonstration) -> Path:
    """A knowledge file of so many demonstrations, whose rows are put straight into the tables."""
    save(Knowledge().add(of(0)), path)

    def fill(connection: Connection) -> None:
        for some in tables.batches(range(1, count)):
            rows = [tables.explanation_row(of(number)) for number in some]
            connection.execute(insert(tables.EXPLANATIONS), rows)

    transact(path, fill)
    return path
