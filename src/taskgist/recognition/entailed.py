"""Which known tasks are done with another: who hides a thing away hides it.

Nobody tells that: each demonstration has one label. But if *hide* is recognised in nearly all demonstrations of *hide
away*, it is learned. Where a *hide away* is recognised, the law of total probability says how probable a *hide* is:
with p of the one, q of the other by itself, and s the share of the demonstrations of *hide away* in which *hide* is
recognised, it is ``s p + (1 − p) q``. So the two never compete: what is both is called the more general one at least as
surely as it is called so by itself.

Shares are (h + ½) / (n + 1), as everywhere, and count from ``ENTAILS`` on: what is recognised in some of another task's
demonstrations is a likeness. Figures stand in docs/howto/recognition.md.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import permutations

from taskgist.common.frozen import FrozenMap
from taskgist.facts.tree import Nodes
from taskgist.facts.values import Observation
from taskgist.learning.clauses import WeighedClause, smoothed
from taskgist.learning.evidence import Evidence
from taskgist.learning.task_clauses import LIKELY

ENTAILS = 0.8
"""Share of its demonstrations from which on a task entails another (ours: fitted on seed 101, beside 0.7)."""
MOST = 50
"""Demonstrations of a task that are looked at, evenly spread over all."""

Entailed = FrozenMap[tuple[str, str], float]
"""By a task and one that it entails: the share of its demonstrations in which that one is recognised."""


def entailed_tasks(
    by_task: Mapping[str, Evidence],
    clauses: Mapping[str, WeighedClause],
    probability: Callable[[str, Nodes], float],
) -> Entailed:
    """Which of some tasks entail which others.

    Args:
        by_task: The evidence that each was learned from.
        clauses: The best clause of each.
        probability: How probable a task is by itself, given the values of nodes.
    """
    found = {}
    for task, other in permutations(by_task, 2):
        evidence = by_task[other]
        if task in evidence.kinds and _share_by_clause(evidence, task, clauses[other]) > LIKELY:
            demonstrations = _some_of(evidence, task)
            hits = sum(probability(other, nodes) > LIKELY for nodes in demonstrations)
            share = smoothed(hits, len(demonstrations))
            if share >= ENTAILS:
                found[task, other] = share
    return FrozenMap(found)


def raised(alone: Mapping[str, float], entailed: Entailed) -> dict[str, tuple[float, str | None]]:
    """The probability of each task in an episode, and by which other task it is greater than by itself.

    Args:
        alone: How probable each is by itself.
        entailed: Which of them entail which others.
    """
    found: dict[str, tuple[float, str | None]] = {task: (each, None) for task, each in alone.items()}
    for (task, other), share in entailed.items():
        total = share * alone[task] + (1.0 - alone[task]) * alone[other]
        if alone[task] > LIKELY and total > found[other][0]:
            found[other] = total, task
    return found


def _share_by_clause(evidence: Evidence, task: str, clause: WeighedClause) -> float:
    """The share of a task's demonstrations in which a clause holds: quickly, for all of them at once."""
    kind = evidence.kind(task)
    holds, _ = evidence.together(clause.literals)
    return kind.of(holds).bit_count() / kind.count if kind.count else 0.0


def _some_of(evidence: Evidence, task: str) -> list[Nodes]:
    """The facts of some of a task's demonstrations."""
    kind = evidence.kind(task)
    step = max(1, -(-kind.count // MOST))
    effects = [evidence.effects(number) for number in range(kind.start, kind.start + kind.count, step)]
    return [{name: Observation(value) for name, value in each.items()} for each in effects]
