"""Lessons: which further demonstration would teach most.

A demonstration is worth most where what is believed would come apart. Two kinds are proposed.

**Another start.** In all demonstrations P2 was sitting. That it takes *standing up* to see the thing and that seeing
it *becomes harder* came to the same; with P2 standing they would not. For each value of a node of the start that was
never seen, the demonstrations of other kinds that began so are taken as samples of what may happen then. In those
``x`` that the posterior takes for the task, by its probability ``p(x)``, a demonstration would change the weights of
the clauses from ``w`` to ``w'``, each by the likelihood of its hit or slip against chance. The expected information
is::

    Σ_x p(x) KL(w' ‖ w) / Σ_x p(x),    in bits about the clauses

Where the start of a demonstration is not known, as in the neutral manipulations that are shipped, it is inferred from
its effects where these leave one start alone (what keeps its posture and ends standing, stood). A start that no
sample had is not proposed: nothing is known of what would come of it.

**A contrast.** The thing ended in a hand in all demonstrations, while seeing it became easier. Which of both is meant?
Somebody who can show the task without the first one tells that it is not needed; who cannot, that it is. That is a
question answered by doing (``SetQuestion.contrast``), in bits for each demonstration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from taskgist.facts.tree import Node
from taskgist.learning.asking import LEAST_GAIN, Asking, SetQuestion
from taskgist.learning.clauses import EQUAL, SLIPS, WeighedClause
from taskgist.learning.literals import SetLiteral

LEAST_BITS = 0.01
"""Information about the clauses below which a start is not proposed."""


@dataclass(frozen=True)
class OtherStart:
    """A demonstration that begins otherwise.

    Args:
        node: What should be otherwise at its start.
        value: How it should be.
        always: How it was in all demonstrations.
        bits: Expected information about the clauses.
    """

    node: Node
    value: str
    always: tuple[str, ...]
    bits: float


@dataclass(frozen=True)
class OtherEnd:
    """A demonstration in which one thing is so that always was, and another one is not.

    Args:
        fails: What should not be so.
        holds: What should be so all the same: what is believed to be meant without the other; None if nothing is.
        gain: Expected information on whether the task is done, bits for each demonstration.
    """

    fails: SetLiteral
    holds: SetLiteral | None
    gain: float


def other_starts(asking: Asking) -> tuple[OtherStart, ...]:
    """Starts that were never shown and would teach most, the best first; of each node the best value."""
    found: dict[str, OtherStart] = {}
    for node in asking.tree.nodes:
        seen = asking.evidence.seen(node.name, asking.posterior.task)
        if node.instant != 1 or not node.values or len(seen) != 1:
            continue
        for value in node.values:
            if value not in seen:
                bits = _expected_change(asking, _began(asking, node.name, value))
                if bits >= LEAST_BITS and (node.name not in found or bits > found[node.name].bits):
                    found[node.name] = OtherStart(node, value, tuple(seen), bits)
    return tuple(sorted(found.values(), key=lambda each: (-round(each.bits, EQUAL), each.node.name)))


def contrasts(asking: Asking, questions: tuple[SetQuestion, ...]) -> tuple[OtherEnd, ...]:
    """Demonstrations in which what held together comes apart, those that would teach most first.

    Args:
        asking: What is known of the task.
        questions: Its questions.
    """
    always = [
        each
        for each in questions
        if each.support.k == each.support.n > 0 and each.contrast >= LEAST_GAIN and not each.literal.but
    ]
    always.sort(key=lambda each: (-round(each.contrast, EQUAL), each.literal.order))
    return tuple(OtherEnd(each.literal, _without(asking, each.literal), each.contrast) for each in always)


def _began(asking: Asking, node: str, value: str) -> int:
    """The demonstrations of other kinds that began so, told or inferred; as bits of ``Counting.truth``."""
    vocabulary = SetLiteral(node, node, (value,))
    began, _ = asking.counting.truth((vocabulary,))
    start = asking.entailment.worlds(vocabulary)
    names = [name for name in asking.vocabularies if asking.entailment.space(name) == start.space]
    for first in names:
        for second in (name for name in names if name >= first):
            for one in asking.evidence.having.get(first, {}):
                for other in asking.evidence.having.get(second, {}):
                    literals = (SetLiteral(first, first, (one,)), SetLiteral(second, second, (other,)))
                    worlds = asking.entailment.together(literals).get(start.space, 0)
                    if worlds and not worlds & ~start.bits:
                        began |= asking.counting.truth(literals)[0]
    return began & asking.counting.background


def _expected_change(asking: Asking, samples: int) -> float:
    """Bits by which the clauses' weights change, expected over samples as far as they are taken for the task."""
    if not samples or not asking.counting.compares:
        return 0.0
    clauses = asking.posterior.clauses
    ratios = [tuple(_likelihood_ratio(each, holds=holds) for holds in (True, False)) for each in clauses]
    total = taken = 0.0
    for same, holding in asking.alike:
        share = asking.counting.share(same & samples)
        believed = math.fsum(clauses[index].weight for index in holding)
        if share and believed:
            inside = set(holding)
            after = [
                each.weight * hit if index in inside else each.weight * miss
                for index, (each, (hit, miss)) in enumerate(zip(clauses, ratios, strict=True))
            ]
            total += share * believed * _divergence(after, [each.weight for each in clauses])
            taken += share * believed
    return total / taken if taken else 0.0


def _likelihood_ratio(clause: WeighedClause, *, holds: bool) -> float:
    """How likely the next demonstration is if the clause is meant, as a multiple of how likely it is by chance."""
    a, b = SLIPS
    k, n, chance = clause.support.k, clause.support.n, clause.support.chance
    if not clause.literals:
        return 1.0
    return (k + b) / (n + a + b) / chance if holds else (n - k + a) / (n + a + b) / (1.0 - chance)


def _divergence(after: list[float], before: list[float]) -> float:
    """Kullback-Leibler divergence of weights that need not sum to one, in bits."""
    whole = math.fsum(after)
    return math.fsum(p / whole * math.log2(p / whole / q) for p, q in zip(after, before, strict=True) if p > 0.0 < q)


def _without(asking: Asking, literal: SetLiteral) -> SetLiteral | None:
    """What is believed to be meant if this literal is not: the heaviest literal of clauses that leave it open."""
    worlds = asking.entailment.worlds(literal)
    weights: dict[SetLiteral, float] = {}
    for clause in asking.posterior.clauses:
        meaning = asking.entailment.together(clause.literals).get(worlds.space, asking.entailment.all(worlds.space))
        if meaning & ~worlds.bits:
            for each in clause.literals:
                if asking.entailment.worlds(each).space != worlds.space:
                    weights[each] = weights.get(each, 0.0) + clause.weight
    return min(weights, key=lambda each: (-round(weights[each], EQUAL), each.order), default=None)


def lessons_of(asking: Asking, questions: tuple[SetQuestion, ...], most: int = 2) -> Iterator[OtherStart | OtherEnd]:
    """The demonstrations that would teach most: contrasts, then other starts; of each kind so many, at most."""
    yield from contrasts(asking, questions)[:most]
    yield from other_starts(asking)[:most]
