"""Samples and results as values: what a demonstration was judged to be, numbers with their spread, and plain data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, SupportsFloat

import numpy as np
from numpy.typing import ArrayLike

from taskgist.facts.values import UNKNOWN, Observation, Unknown
from taskgist.learning.explanation import Context, Explanation

# --- Results as plain data.


@dataclass(frozen=True)
class Result:
    """What an experiment found."""

    def to_json(self) -> dict[str, Any]:
        """Plain data: numbers, texts, lists and dictionaries."""
        return asdict(self)


CLEAN = "clean"
"""Condition of recordings as the demonstrator made them."""


@dataclass(frozen=True, order=True)
class Sample:
    """The value of each node in one demonstration, watched under one condition.

    Args:
        task: Name of the task.
        number: Which demonstration of the pool's seed.
        condition: How it was watched: ``CLEAN``, or one of ``conditions.CONDITIONS``.
        means: How the task was performed.
        values: Value of each of the pool's nodes, in their order; None is unknown.
        fulfilled: All tasks that it fulfils by the generator's own checks, its own among them; sorted.
    """

    task: str
    number: int
    condition: str
    means: str
    values: tuple[str | None, ...]
    fulfilled: tuple[str, ...] = ()

    @staticmethod
    def of(
        explanation: Explanation,
        nodes: Sequence[str],
        *,
        number: int,
        condition: str,
        means: str,
        fulfilled: tuple[str, ...] = (),
    ) -> Sample:
        """The sample that an explanation gives."""
        values = (explanation.nodes[name].value for name in nodes)
        plain = tuple(None if isinstance(value, Unknown) else value for value in values)
        return Sample(explanation.task, number, condition, means, plain, fulfilled)

    def fulfils(self, task: str) -> bool:
        """Whether it was played as a task, or is that one as well."""
        return task == self.task or task in self.fulfilled

    def explanation(self, nodes: Sequence[str], context: Context) -> Explanation:
        """The explanation again, without evidence, of the pool's nodes and under its context."""
        return Explanation(
            task=self.task,
            demonstration=f"{self.task} {self.number}",
            performing_agent="performer",
            target_agents=("target",),
            target_objects=("object",),
            source=f"pool: {self.task} {self.number} {self.condition}",
            context=context,
            nodes=_observations(nodes, self.values),
        )


@dataclass(frozen=True, order=True)
class Failure:
    """A demonstration that could not be played (no condition), or not be watched under one.

    Args:
        task: Name of the task.
        number: Which demonstration.
        condition: Under which condition; empty where it could not be played.
        problem: Why.
    """

    task: str
    number: int
    condition: str
    problem: str


def _observations(nodes: Sequence[str], values: Sequence[str | None]) -> Mapping[str, Observation[str | Unknown]]:
    pairs = zip(nodes, values, strict=True)
    return {name: Observation(UNKNOWN if value is None else value) for name, value in pairs}


# --- A number with its spread over runs.

LOW, HIGH = 0.1, 0.9
"""Quantiles that tell the spread: four of five runs lie between them."""


@dataclass(frozen=True)
class Spread:
    """Mean and spread over runs; all are None where no run gives a number."""

    mean: float | None
    low: float | None
    """10 % quantile."""
    high: float | None
    """90 % quantile."""
    count: int
    """Runs that give a number."""

    @staticmethod
    def of(values: ArrayLike) -> Spread:
        """Of numbers, NaN where a run gives none."""
        known = np.asarray(values, dtype=np.float64).ravel()
        known = known[~np.isnan(known)]
        if not len(known):
            return Spread(None, None, None, 0)
        low, high = np.quantile(known, (LOW, HIGH))
        return Spread(rounded(known.mean()), rounded(low), rounded(high), len(known))


def rounded(value: SupportsFloat) -> float:
    """To four decimals: more would be noise."""
    return round(float(value), 4)
