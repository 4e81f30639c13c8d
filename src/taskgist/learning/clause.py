"""The clause: what a task means, as a conjunction of predicates (6, step 3; Eq. 36-42).

The paper forms it of the leaves of the kept subtree. Leaves alone would lose meaning where a constant initial
effort stands beside a varying final one: the constant is a leaf, and *Becomes_Easier* above it is none. So
*effects* are the deepest kept nodes with the initial ones (¹) left aside, and *preconditions* the deepest kept
initial ones; the clause of the paper is both together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from taskgist.facts.tree import Instant, Node, Nodes
from taskgist.facts.values import NEGLIGIBLE, UNKNOWN, Unknown
from taskgist.learning.understanding import Judgement, Understanding


@dataclass(frozen=True)
class Literal:
    """One predicate of a clause: this node must have this value."""

    node: str
    title: str
    value: str
    instant: Instant | None

    def __str__(self) -> str:
        relation = "" if self.value == NEGLIGIBLE else "= "
        return f"({self.title} {relation}{self.value})"

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether it holds where the nodes are as given; unknown where its node is missing or unknown."""
        if self.node not in nodes or isinstance(value := nodes[self.node].value, Unknown):
            return UNKNOWN
        return value == self.value


@dataclass(frozen=True)
class Clause:
    """The learned meaning of a task.

    Args:
        task: Name of the task.
        literals: Its predicates, in the canonical order of the tree.
    """

    task: str
    literals: tuple[Literal, ...]

    @property
    def effects(self) -> tuple[Literal, ...]:
        """What the task brings about."""
        return tuple(literal for literal in self.literals if literal.instant != 1)

    @property
    def preconditions(self) -> tuple[Literal, ...]:
        """How the world was at the start of each demonstration."""
        return tuple(literal for literal in self.literals if literal.instant == 1)

    def __str__(self) -> str:
        return f"Task({self.task}) ← {' ∧ '.join(map(str, self.literals)) or 'nothing in common'}"

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether all predicates hold: false if one surely does not, else unknown if one is unknown."""
        return conjunction(literal.holds(nodes) for literal in self.literals)


def clause_of(understanding: Understanding) -> Clause:
    """The clause of the largest consistent subtree."""
    kept = understanding.kept
    parents_of_effects = {each.node.parent for each in kept if each.node.instant != 1}
    parents_of_preconditions = {each.node.parent for each in kept if each.node.instant == 1}
    deepest = (
        each
        for each in kept
        if each.node.name not in (parents_of_preconditions if each.node.instant == 1 else parents_of_effects)
    )
    return Clause(understanding.task, tuple(_literal(each) for each in deepest))


def conjunction(truths: Iterator[bool | Unknown]) -> bool | Unknown:
    """Three-valued *and*."""
    unknown = False
    for truth in truths:
        if truth is False:
            return False
        unknown = unknown or truth is UNKNOWN
    return UNKNOWN if unknown else True


def _literal(judgement: Judgement) -> Literal:
    node: Node = judgement.node
    assert judgement.value is not None, node  # kept nodes are relevant, and relevant nodes have a value
    return Literal(node.name, node.title, judgement.value, node.instant)
