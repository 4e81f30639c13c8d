"""The pool that an evaluation wants: read, extended by what is missing, and kept."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from taskgist.errors import InputError, UnknownNameError
from taskgist.recording import Progress, silent
from taskgist.study.evaluation.making import empty_pool, extended
from taskgist.study.evaluation.pool import Pool
from taskgist.study.evaluation.pool_file import read_pool, write_pool
from taskgist.study.evaluation.sources import SOURCES

BATCH = 60
"""Demonstrations of each task after which the file is written: who interrupts a long run loses little."""


@dataclass(frozen=True)
class Wanted:
    """What a pool shall hold.

    Args:
        source: Where demonstrations come from.
        seed: Their seed.
        count: Demonstrations of each task.
        conditions: Under which they are watched.

    Raises:
        UnknownNameError: There is no such source.
        InputError: The seed is negative.
    """

    source: str
    seed: int
    count: int
    conditions: tuple[str, ...]

    def __post_init__(self) -> None:
        if self.source not in SOURCES:
            raise UnknownNameError("source", self.source, SOURCES)
        if self.seed < 0:
            raise InputError("negative", field="--seed", value=self.seed, hint="give 0 or more")


def kept_pool(path: Path | None, wanted: Wanted, *, processes: int | None = None, progress: Progress = silent) -> Pool:
    """The wanted demonstrations, those that the file has and those that are made now; the file keeps them all.

    Args:
        path: The pool's file, which need not exist; None keeps nothing.
        wanted: What it shall hold.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The file is no pool, another one than wanted, or cannot be written; or no demonstration at all
            could be played and judged.
    """
    fresh = empty_pool(wanted.source, wanted.seed)
    if path is None:
        made = extended(fresh, wanted.count, conditions=wanted.conditions, processes=processes, progress=progress)
        return _checked(made)
    if not path.parent.is_dir():
        raise InputError("no such folder", where=path, field="pool", hint="name a file in a folder that exists")
    known = read_pool(path) if path.exists() else fresh
    known.check(fresh.context, source=wanted.source, seed=wanted.seed, where=str(path))
    for done, count in pairwise((*range(0, wanted.count, BATCH), wanted.count)):

        def of_all(what: str, share: float, done: int = done, count: int = count) -> None:
            progress(what, (done + share * (count - done)) / wanted.count)

        whole = extended(known, count, conditions=wanted.conditions, processes=processes, progress=of_all)
        if whole != known:
            write_pool(whole, path)
        known = whole
    return _checked(known.restricted(wanted.count))


def _checked(pool: Pool) -> Pool:
    """Refuse a pool in which there is nothing to learn from, and say why that is so."""
    if not pool.samples:
        first = pool.failures[0]
        where = f"{first.task} {first.number} of seed {pool.seed}"
        hint = f"the first problem is: {first.problem}; try another --seed and another --pool file"
        raise InputError("no demonstration could be played and judged", where=where, field="pool", hint=hint)
    return pool
