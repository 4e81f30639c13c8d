"""Making a pool: demonstrations are played, spoiled and judged on all cores, each once."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from taskgist.errors import InputError, TaskgistError
from taskgist.facts import STANDARD_TREE
from taskgist.learning import Context
from taskgist.recording import Progress, Recording, silent
from taskgist.study.episodes import explain_recording
from taskgist.study.evaluation.conditions import CONDITIONS
from taskgist.study.evaluation.pool import Pool
from taskgist.study.evaluation.sample import CLEAN, Failure, Sample
from taskgist.study.evaluation.sources import SOURCES, means_of
from taskgist.workers import in_order

NODES = tuple(node.name for node in STANDARD_TREE.nodes)


@dataclass(frozen=True)
class Job:
    """One demonstration to be played, and the conditions under which it is to be judged."""

    source: str
    seed: int
    task: str
    number: int
    conditions: tuple[str, ...]

    def done(self) -> tuple[tuple[Sample, ...], tuple[Failure, ...]]:
        """Samples and failures."""
        try:
            recording = SOURCES[self.source].play(self.task, seed=self.seed, number=self.number)
        except TaskgistError as error:
            return (), (Failure(self.task, self.number, "", str(error)),)
        found = [self._judged(recording, condition) for condition in self.conditions]
        samples = tuple(each for each in found if isinstance(each, Sample))
        return samples, tuple(each for each in found if isinstance(each, Failure))

    def _judged(self, recording: Recording, condition: str) -> Sample | Failure:
        try:
            watched = CONDITIONS[condition].applied(recording, seed=self.seed, number=self.number)
            explanation = explain_recording(watched, predicates=())
        except TaskgistError as error:
            return Failure(self.task, self.number, condition, str(error))
        return Sample.of(explanation, NODES, number=self.number, condition=condition, means=means_of(recording))


def empty_pool(source: str, seed: int) -> Pool:
    """A pool without demonstrations, for the present settings and tree."""
    return Pool(Context.of(), source, seed, NODES)


def extended(
    pool: Pool,
    count: int,
    *,
    conditions: Collection[str] = (CLEAN,),
    processes: int | None = None,
    progress: Progress = silent,
) -> Pool:
    """A pool with at least so many demonstrations of each task under each condition.

    Args:
        pool: What there is already.
        count: Demonstrations of each task.
        conditions: Names of conditions.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The pool's demonstrations can no longer be made as they were.
    """
    jobs = tuple(_jobs(pool, count, conditions))
    if not jobs:
        return pool
    if pool.samples:
        _check_still_made(pool)
    samples: list[Sample] = []
    failures: list[Failure] = []
    for number, (made, missed) in enumerate(_results(jobs, processes), start=1):
        samples += made
        failures += missed
        progress(f"demonstrations: {number} of {len(jobs)}", number / len(jobs))
    return pool.with_more(samples, failures)


def _jobs(pool: Pool, count: int, conditions: Collection[str]) -> Iterator[Job]:
    """What is missing, the tasks by turns."""
    had = {(each.task, each.number, each.condition) for each in pool.samples}
    had |= {(each.task, each.number, each.condition) for each in pool.failures}
    for number, task in itertools.product(range(count), SOURCES[pool.source].tasks):
        missing = tuple(name for name in CONDITIONS if name in conditions and (task, number, name) not in had)
        if missing and (task, number, "") not in had:
            yield Job(pool.source, pool.seed, task, number, missing)


def _results(jobs: tuple[Job, ...], processes: int | None) -> Iterator[tuple[tuple[Sample, ...], tuple[Failure, ...]]]:
    """Results in order. The first job is done here: what must be compiled is compiled once, before others need it."""
    yield jobs[0].done()
    rest = jobs[1:]
    yield from in_order(lambda number: rest[number].done(), len(rest), processes)


def _check_still_made(pool: Pool) -> None:
    """Refuse to add to demonstrations that would be others today: generator or judge have changed since."""
    first = next((each for each in pool.samples if each.condition == CLEAN), None)
    if first is None:
        return
    again, _ = Job(pool.source, pool.seed, first.task, first.number, (CLEAN,)).done()
    if again != (first,):
        hint = "it was made by another version of taskgist; name another --pool file, or remove this one"
        where = f"{first.task} {first.number} of seed {pool.seed}"
        raise InputError("a demonstration of the pool is not what it was", where=where, field="pool", hint=hint)
