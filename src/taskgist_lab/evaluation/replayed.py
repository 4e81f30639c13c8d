"""Held-out demonstrations of a pool as recordings, made again, and what was learned from the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from taskgist.common.workers import Progress, in_order, silent
from taskgist.errors import InputError
from taskgist.learning.knowledge import Knowledge
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist.recording.recording import Recording
from taskgist_lab.evaluation.pool import HELD_OUT_EVERY, SOURCES, Pool
from taskgist_lab.evaluation.values import CLEAN, Sample

LEARNED = 10
"""Demonstrations of each task that are known."""
MOST = 12
"""Held-out demonstrations of each task that are made again: each takes some seconds."""

T = TypeVar("T")


@dataclass(frozen=True)
class Replayed:
    """What is known, and what is watched.

    Args:
        recogniser: The tasks, learned from ``LEARNED`` demonstrations of each.
        samples: Held-out demonstrations.
        pool: Where they come from.
    """

    recogniser: TaskRecogniser
    samples: tuple[Sample, ...]
    pool: Pool

    @staticmethod
    def of(pool: Pool, most: int = MOST) -> Replayed:
        """What is known from a pool, and so many of each task that were held out.

        Raises:
            InputError: The pool holds too little.
        """
        known = Knowledge()
        samples: list[Sample] = []
        for task in pool.tasks:
            learned, held_out = (pool.of(task, CLEAN, held_out=held) for held in (False, True))
            if len(learned) < LEARNED or not held_out:
                hint = f"make {HELD_OUT_EVERY * LEARNED // 2 + HELD_OUT_EVERY} or more of each task (-n)"
                raise InputError("too few demonstrations", field="pool", where=task, value=len(learned), hint=hint)
            known = known.add(*(each.explanation(pool.nodes, pool.context) for each in learned[:LEARNED]))
            samples += held_out[:most]
        return Replayed(TaskRecogniser.of(known), tuple(samples), pool)

    def recording(self, sample: Sample) -> Recording:
        """The recording of a demonstration, as it was when it was judged."""
        return SOURCES[self.pool.source].play(sample.task, seed=self.pool.seed, number=sample.number)

    def each(
        self, watched: Callable[[Sample], T], what: str, *, processes: int | None = None, progress: Progress = silent
    ) -> Iterator[T]:
        """What a function gives for each held-out demonstration, on all cores."""
        found = in_order(lambda number: watched(self.samples[number]), len(self.samples), processes)
        for number, result in enumerate(found, start=1):
            progress(f"{what}: {number} of {len(self.samples)}", number / len(self.samples))
            yield result
