"""What tells one known task from another: the literals that decide between the two, each with its weight.

A clause says what a task is about beside all that people do. Between two tasks much of it decides nothing, because both
have it: whoever hides and whoever puts away leaves the thing at rest. So the two are compared with each other alone.
For each literal it is counted in how many demonstrations of either task it holds, h of n and h' of n'. Its weight where
it holds is ``ln((h + ½) / (n + 1)) − ln((h' + ½) / (n' + 1))``, and where it fails the same of failures: positive
weights speak for the first task. How well it decides is what both kinds of demonstrations lead one to expect of it,
``(p − p') (weight where it holds − weight where it fails)``, p and p' being the shares (Jeffreys' divergence).

Nodes of one subtree repeat each other: the class of an effort follows from its two ends. Of each subtree only the
literal that decides best is told, of equal ones the shortest in description; and where that holds in the very same
demonstrations as one that was told already (what is hard to grasp is hard to reach), nothing is told of the subtree.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from taskgist.errors import KnowledgeError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Nodes, TreeOf
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.learning.clauses import EQUAL, smoothed
from taskgist.learning.evidence import Evidence, evidence_of
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.literals import SetLiteral, vocabularies

LEAST = 0.5
"""How well a literal decides, in nats, from which on it is told: one that holds in three of four of the one task and in
half of the other has less, and with few demonstrations may be so by chance."""


@dataclass(frozen=True)
class Contrasted:
    """One literal, and how often it holds in the demonstrations of either task.

    Args:
        literal: The literal.
        first: Demonstrations of the first task in which it holds, and in which that is known.
        second: The same of the second task.
    """

    literal: SetLiteral
    first: tuple[int, int]
    second: tuple[int, int]

    def weight(self, holds: bool | Unknown) -> float:
        """Natural logarithm of how much more often it holds, or fails, in the first task; 0 where that is unknown."""
        if holds is UNKNOWN:
            return 0.0
        mine, other = self._shares
        return math.log(mine / other) if holds else math.log((1.0 - mine) / (1.0 - other))

    @property
    def decides(self) -> float:
        """How well it tells the two tasks apart; 0: not at all."""
        mine, other = self._shares
        return (mine - other) * (self.weight(True) - self.weight(False))

    @property
    def _shares(self) -> tuple[float, float]:
        return smoothed(*self.first), smoothed(*self.second)


@dataclass(frozen=True)
class Weighed:
    """One literal in one episode.

    Args:
        contrasted: The literal, and how often it holds in either task.
        holds: Whether it holds in the episode.
        weight: What that says: positive for the first task, negative for the second, 0 where it is unknown.
    """

    contrasted: Contrasted
    holds: bool | Unknown
    weight: float


@dataclass(frozen=True)
class Contrast:
    """What tells two tasks apart."""

    first: str
    second: str
    literals: tuple[Contrasted, ...]
    """That which decides best first, at most one of each subtree; none: their demonstrations do not differ."""
    of: TreeOf = "target"
    """Whose trees were compared: those of the target agents, or of who performs."""

    def weigh(self, nodes: Nodes) -> tuple[Weighed, ...]:
        """What each literal says of an episode, what says most first."""
        truths = ((each, each.literal.holds(nodes)) for each in self.literals)
        found = [Weighed(each, holds, each.weight(holds)) for each, holds in truths]
        return tuple(sorted(found, key=lambda each: (-round(abs(each.weight), EQUAL), each.contrasted.literal.order)))


def contrast_of(
    knowledge: Knowledge, first: str, second: str, tree: HypothesisTree = STANDARD_TREE, of: TreeOf = "target"
) -> Contrast:
    """What tells two known tasks apart.

    Args:
        knowledge: Experience of both.
        first: Name of the one task.
        second: Name of the other.
        tree: Whose effects literals are about.
        of: Whose trees, as ``Knowledge.experience``.

    Raises:
        UnknownNameError: One of them is not known.
        KnowledgeError: They are the same, or not known in the trees of the same agents.
    """
    own, other = (knowledge.experience(task, of) for task in (first, second))
    if own.task == other.task:
        hint = f"name another one (known: {', '.join(knowledge.tasks)})"
        raise KnowledgeError("a task has no contrast with itself", field="contrast", value=second, hint=hint)
    if own.tree_of != other.tree_of:
        whose = {"target": "its target agents", "performer": "who performs it"}
        problem = f"{own.task!r} is known for {whose[own.tree_of]}, {other.task!r} for {whose[other.tree_of]}"
        raise KnowledgeError(problem, field="contrast", value=second, hint="learn both in the same trees: learn --of")
    evidence = evidence_of([own, other])
    best: list[Contrasted] = []
    subtrees: set[str] = set()
    told: set[tuple[int, int]] = set()
    for each, bits in sorted(_candidates(evidence, own.task, other.task, tree), key=lambda pair: _order(pair[0])):
        subtree = each.literal.node.partition(".")[0]
        if each.decides < LEAST or subtree in subtrees:
            continue
        subtrees.add(subtree)
        if bits not in told:
            best.append(each)
            told |= {bits, bits[::-1]}
    return Contrast(own.task, other.task, tuple(best), own.tree_of)


def _order(each: Contrasted) -> tuple[float, float, tuple[str, bool, tuple[str, ...]]]:
    return -round(each.decides, EQUAL), each.literal.bits, each.literal.order


def _candidates(
    evidence: Evidence, first: str, second: str, tree: HypothesisTree
) -> Iterator[tuple[Contrasted, tuple[int, int]]]:
    """Each literal of a value seen in either task, how often it holds in both, and where it holds and fails."""
    kinds = evidence.kind(first), evidence.kind(second)
    for vocabulary in vocabularies(tree):
        seen = evidence.seen(vocabulary.node.name, first) | evidence.seen(vocabulary.node.name, second)
        for literal in vocabulary.literals(seen):
            true, false = evidence.truth(literal)
            hits, known = ([kind.of(bits).bit_count() for kind in kinds] for bits in (true, true | false))
            if all(known):
                yield Contrasted(literal, (hits[0], known[0]), (hits[1], known[1])), (true, false)
