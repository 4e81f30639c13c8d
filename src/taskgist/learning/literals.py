"""Literals of clauses that are learned as a whole: each is a set of values that one node may have.

The paper's predicates say *this node has this value*. Demonstrations of one task often agree on less than that: the
thing ends anywhere but in somebody's hand, it can be reached with an effort of the arms or of none. So a literal here
is a set of values of one node:

- a value: ``(Object_Final_Status = In_Hand)``;
- an interval of a ladder, which is an order of effort types or of score bins: ``(Effort_to_See ≥ Whole_Body_Effort)``;
- all values but one, of a node that has three to six: ``(Object_Final_Status ≠ In_Hand)``, and two classes of three.

Literals are about effects alone, which are the nodes of a final state or of a change. A node whose values nobody has
declared, such as a joint configuration or the words of an action, gives no literal: any two demonstrations differ
there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from functools import cached_property, lru_cache

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.tree import HypothesisTree, Instant, Leaf, Node, Nodes
from taskgist.facts.values import NEGLIGIBLE, UNKNOWN, ScoreAttribute, Unknown, score_bins
from taskgist.learning.estimate import canonical_key
from taskgist.settings import DEFAULT, Settings

MOST_VALUES = 6
"""A node of more values than this, of which no ladder is made, has no literal that leaves out one of them."""
LADDERS = (v.REACH_EFFORTS, v.SEE_EFFORTS)
"""Declared values that are in order, from the least effort to the greatest."""


@dataclass(frozen=True)
class SetLiteral:
    """A set of values of one node.

    Args:
        node: Name of the node.
        title: Its title.
        values: The values in the set, in canonical order; where ``but`` is true, those outside it, which is one value
            in what is learned, and may be more in what was told.
        but: Whether the set is all values but those given.
        bound: How an interval of a ladder is told: "≤", "≥" or "to"; empty for all other sets.
        bits: Description length of the set, given its node.
        instant: 2 for a final state, None for a change.
    """

    node: str
    title: str
    values: tuple[str, ...]
    but: bool = False
    bound: str = ""
    bits: float = 0.0
    instant: Instant | None = None

    @property
    def is_value(self) -> bool:
        """Whether it is one value alone."""
        return len(self.values) == 1 and not self.but and not self.bound

    @property
    def value(self) -> str | None:
        """The one value that the node must have; None where it may have several."""
        return self.values[0] if self.is_value else None

    def __str__(self) -> str:
        return f"({self.title} {self.told})"

    @property
    def told(self) -> str:
        """The set in symbols: ``"= In_Hand"``, ``"≠ In_Hand"``, ``"≥ Whole_Body_Effort"``."""
        first, last = self.values[0], self.values[-1]
        equal = "≠" if self.but else "="
        if self.bound == "to":
            return f"{'outside' if self.but else '='} {first} to {last}"
        if self.bound and self.but:
            return f"> {last}" if self.bound == "≤" else f"< {first}"
        if self.bound:
            return f"{self.bound} {last if self.bound == '≤' else first}"
        if first == NEGLIGIBLE and len(self.values) == 1 and not self.but:
            return first
        return f"{equal} {' or '.join(self.values)}"

    @property
    def order(self) -> tuple[str, bool, tuple[str, ...]]:
        """Sort key: no two literals of a tree share it."""
        return (self.node, self.but, self.values)

    def holds(self, nodes: Nodes) -> bool | Unknown:
        """Whether it holds where the nodes are as given; unknown where its node is missing or unknown."""
        if self.node not in nodes or isinstance(value := nodes[self.node].value, Unknown):
            return UNKNOWN
        return self.admits(value)

    def admits(self, value: str) -> bool:
        """Whether a value of its node is in the set."""
        return (value in self.values) != self.but


@dataclass(frozen=True)
class Vocabulary:
    """Which literals a node may have.

    Args:
        node: The node.
        ladder: Its values in order, from least to greatest; empty where they have none.
    """

    node: Node
    ladder: tuple[str, ...] = ()

    @cached_property
    def values(self) -> tuple[str, ...]:
        """Its declared values, in canonical order."""
        return self.ladder or self.node.values

    def literals(self, seen: Mapping[str, int] | Set[str]) -> Iterator[SetLiteral]:
        """The literals that some of the seen values fulfil; intervals end at seen values, or with the ladder."""
        known = sorted(seen, key=lambda value: canonical_key(value, self.values))
        for value in known:
            yield self._literal((value,), bits=math.log2(len(self.values)))
        if self.ladder:
            yield from self._intervals([value for value in known if value in self.ladder])
        elif 3 <= len(self.values) <= MOST_VALUES and known:
            for value in self.values:
                if len(known) > 1 or value != known[0]:
                    yield self._literal((value,), but=True, bits=math.log2(len(self.values)))

    def _intervals(self, known: list[str]) -> Iterator[SetLiteral]:
        if not known:
            return
        last = len(self.ladder) - 1
        rungs = [self.ladder.index(value) for value in known]
        one_end, both_ends = math.log2(2 * last), 2 * math.log2(last)  # which side and where; where, twice
        for high in rungs:
            if 0 < high < last:
                yield self._literal(self.ladder[: high + 1], bound="≤", bits=one_end)
        for low in rungs:
            if 0 < low < last:
                yield self._literal(self.ladder[low:], bound="≥", bits=one_end)
        for at, low in enumerate(rungs):
            for high in rungs[at + 1 :]:
                if low > 0 and high < last:
                    yield self._literal(self.ladder[low : high + 1], bound="to", bits=both_ends)

    def literal(self, values: Iterable[str], *, but: bool = False) -> SetLiteral:
        """The literal of any set of values, such as a person names; it is told as an interval where it is one.

        Args:
            values: The values in the set; where ``but`` is true, those outside it.
            but: Whether the set is all values but those given.
        """
        named = tuple(sorted(set(values), key=lambda value: canonical_key(value, self.values)))
        if self.ladder and set(named) < set(self.ladder):
            inside = tuple(value for value in self.ladder if (value in named) != but)
            low, high = self.ladder.index(inside[0]), self.ladder.index(inside[-1])
            if len(inside) > 1 and high - low + 1 == len(inside):
                bound = "≤" if low == 0 else "≥" if high == len(self.ladder) - 1 else "to"
                return self._literal(inside, bound=bound, bits=math.log2(2 * (len(self.ladder) - 1)))
        return self._literal(named, but=but, bits=math.log2(max(2, len(self.values))))

    def complement(self, literal: SetLiteral) -> SetLiteral:
        """The literal that holds where this one of its node fails."""
        return self.literal(literal.values, but=not literal.but)

    def _literal(self, values: tuple[str, ...], *, bits: float, but: bool = False, bound: str = "") -> SetLiteral:
        return SetLiteral(self.node.name, self.node.title, values, but, bound, bits, self.node.instant)


@lru_cache(maxsize=8)
def vocabularies(tree: HypothesisTree, settings: Settings = DEFAULT) -> tuple[Vocabulary, ...]:
    """What literals may be about: the effects of a tree whose values are declared or binned, in canonical order.

    Args:
        tree: The hypothesis tree.
        settings: Give the bins of scores.
    """
    binned = {name for name, leaf in _leaves(tree) if isinstance(leaf.attribute, ScoreAttribute)}
    bins = score_bins(settings.vision) if binned else ()
    found = []
    for node in tree.nodes:
        if node.instant == 1:
            continue
        if node.name in binned:
            found.append(Vocabulary(node, bins))
        elif node.values:
            found.append(Vocabulary(node, node.values if node.values in LADDERS else ()))
    return tuple(found)


@lru_cache(maxsize=8)
def vocabulary_by_node(tree: HypothesisTree, settings: Settings = DEFAULT) -> FrozenMap[str, Vocabulary]:
    """The same by the name of the node."""
    return FrozenMap({each.node.name: each for each in vocabularies(tree, settings)})


def _leaves(tree: HypothesisTree) -> Iterator[tuple[str, Leaf]]:
    """Final nodes of level 3 by name, with what is observed there."""
    for subtree in tree.subtrees:
        leaves = [subtree.leaf] if subtree.leaf else []
        while leaves:
            leaf = leaves.pop()
            yield f"{subtree.name}.{leaf.part}.2", leaf
            leaves.extend(leaf.children)
