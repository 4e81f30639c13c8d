"""A pool: judged demonstrations of all tasks, from which experiments draw."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from taskgist.errors import InputError
from taskgist.learning import Context
from taskgist.study.evaluation.sample import CLEAN, Failure, Sample
from taskgist.study.intuition import INTUITION

HELD_OUT_EVERY = 3
"""Of every so many demonstrations the last one is held out: others learn, it judges."""


@dataclass(frozen=True)
class Pool:
    """Judged demonstrations, sorted by task, number and condition.

    Args:
        context: Settings and tree that they were judged with.
        source: Where the demonstrations come from; see ``sources.SOURCES``.
        seed: Their seed.
        nodes: The tree's nodes, in canonical order.
        samples: What was judged.
        failures: What could not be.
    """

    context: Context
    source: str
    seed: int
    nodes: tuple[str, ...]
    samples: tuple[Sample, ...] = ()
    failures: tuple[Failure, ...] = ()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks, those of the paper first, in the order of its Table 4."""
        found = {sample.task for sample in self.samples}
        return (*(task for task in INTUITION if task in found), *sorted(found - INTUITION.keys()))

    @property
    def conditions(self) -> tuple[str, ...]:
        """Names of the conditions, the clean one first."""
        found = {sample.condition for sample in self.samples}
        return tuple(sorted(found, key=lambda name: (name != CLEAN, name)))

    def of(self, task: str, condition: str = CLEAN, *, held_out: bool) -> tuple[Sample, ...]:
        """Demonstrations of a task under a condition: those held out, or those to learn from."""
        return tuple(
            each
            for each in self.samples
            if each.task == task and each.condition == condition and is_held_out(each.number) == held_out
        )

    def with_more(self, samples: Iterable[Sample], failures: Iterable[Failure] = ()) -> Pool:
        """This pool and more of the same kind; what it has already stays as it is."""
        more = {_key(each): each for each in samples} | {_key(each): each for each in self.samples}
        missed = set(self.failures) | set(failures)
        return replace(self, samples=tuple(sorted(more.values(), key=_key)), failures=tuple(sorted(missed)))

    def restricted(self, count: int) -> Pool:
        """The first ``count`` demonstrations of each task."""
        return replace(
            self,
            samples=tuple(each for each in self.samples if each.number < count),
            failures=tuple(each for each in self.failures if each.number < count),
        )

    def check(self, context: Context, *, source: str, seed: int, where: str) -> None:
        """Refuse a pool that was made otherwise than wanted.

        Raises:
            InputError: It holds facts of other settings, of another tree, or other demonstrations.
        """
        wanted = {"context": str(context), "source": source, "seed": str(seed)}
        found = {"context": str(self.context), "source": self.source, "seed": str(self.seed)}
        for field, value in found.items():
            if value != wanted[field]:
                hint = f"wanted is {wanted[field]}; name another --pool file, or remove this one"
                raise InputError("the pool is another one", where=where, field=field, value=value, hint=hint)


def is_held_out(number: int) -> bool:
    """Whether a demonstration of this number is kept for judging."""
    return number % HELD_OUT_EVERY == HELD_OUT_EVERY - 1


def _key(sample: Sample) -> tuple[str, int, str]:
    return sample.task, sample.number, sample.condition
