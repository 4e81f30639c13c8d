"""Random orders in which demonstrations come, some of them wrong ones if wanted."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import InputError
from taskgist.study.evaluation.coded import Coded, Codes
from taskgist.study.evaluation.pool import HELD_OUT_EVERY
from taskgist.study.evaluation.sample import CLEAN
from taskgist.study.evaluation.sources import SOURCES

LONGEST = 20
"""Demonstrations of a draw."""


def drawn(coded: Coded, task: str, *, draws: int, seed: int, condition: str = CLEAN, wrong_share: float = 0.0) -> Codes:
    """Demonstrations in random order, none twice in a draw, (draws, up to ``LONGEST``, nodes).

    The same task and seed give the same orders whatever is compared. Where the source has a few distinct
    demonstrations, each displaced many times, all of them come, in random order, before one comes again.

    Args:
        coded: A pool.
        task: The task that is learned.
        draws: How many orders.
        seed: Their seed.
        condition: Under which the demonstrations were watched.
        wrong_share: Probability of each demonstration to be one of another task that is labelled as this one.

    Raises:
        InputError: There are no demonstrations to learn this task from.
    """
    own = coded.of_task(task, condition, held_out=False)
    if not len(own):
        hint = f"make more demonstrations: every {HELD_OUT_EVERY}rd is held out, and some cannot be played"
        raise InputError("no demonstrations to learn from", where=f"{task}, {condition}", field="pool", hint=hint)
    rng = np.random.default_rng([seed, zlib.crc32(task.encode())])
    source = SOURCES[coded.pool.source]
    kinds = [source.kind(task, each.number) for each in coded.pool.of(task, condition, held_out=False)]
    chosen = own[_by_turns(rng, kinds, draws)]
    others = _others(coded, task, condition)
    return _with_wrong(chosen, others, rng, wrong_share) if wrong_share and len(others) else chosen


def sizes_within(sizes: Sequence[int], orders: Iterable[Codes]) -> tuple[int, ...]:
    """The sizes that every draw reaches.

    Raises:
        InputError: There is none.
    """
    shortest = min(each.shape[1] for each in orders)
    reached = tuple(size for size in sizes if size <= shortest)
    if not reached:
        hint = f"learn from {sizes[0]} or more; every {HELD_OUT_EVERY}rd demonstration is held out"
        raise InputError("too few demonstrations to learn from", field="pool", value=shortest, hint=hint)
    return reached


def _orders(rng: np.random.Generator, count: int, draws: int) -> NDArray[np.intp]:
    """Orders of indices, (draws, up to ``LONGEST``)."""
    return np.asarray(rng.permuted(np.tile(np.arange(count), (draws, 1)), axis=1)[:, :LONGEST])


def _by_turns(rng: np.random.Generator, kinds: Sequence[int], draws: int) -> NDArray[np.intp]:
    """Orders of indices in rounds, each with every kind once as long as there are any; all kinds differ: one round."""
    rounds = np.empty((draws, len(kinds)))
    for kind in sorted(set(kinds)):
        members = np.flatnonzero(np.equal(kinds, kind))
        rounds[:, members] = rng.permuted(np.tile(np.arange(len(members)), (draws, 1)), axis=1)
    return np.argsort(rounds + rng.random(rounds.shape), axis=1)[:, :LONGEST]


def _others(coded: Coded, task: str, condition: str) -> Codes:
    tasks = (each for each in coded.pool.tasks if each != task)
    return np.concatenate([coded.codes(()), *(coded.of_task(each, condition, held_out=False) for each in tasks)])


def _with_wrong(chosen: Codes, others: Codes, rng: np.random.Generator, share: float) -> Codes:
    wrong = rng.random(chosen.shape[:2]) < share
    orders = _orders(rng, len(others), len(chosen))
    replacing = others[orders[:, np.arange(chosen.shape[1]) % orders.shape[1]]]
    return np.where(wrong[:, :, None], replacing, chosen)
