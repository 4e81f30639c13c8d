"""What follows from what: literals as sets of possible worlds, so that questions and answers can be compared exactly.

*Becomes_Difficult* says that the nature is *Not_Supportive*; that the thing ends on a support says that it ends in no
hand. Nobody wrote that down: it follows from the functions by which the tree makes classes and natures of what is
observed. So each subtree is played through once, with every initial and final value of its attribute, and a literal is
the set of those *worlds* in which it holds. One literal entails another if its worlds lie in those of the other. A
score is played at several points of each bin, and hands by both sides.

What holds between subtrees, such as that nobody holds what lies on a support, is not known here: they count as
independent. A node of which nobody has declared what its attribute may be stands for itself, each value a world.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

from taskgist.facts.tree import HypothesisTree, Subtree
from taskgist.facts.values import (
    SIDES,
    Attribute,
    Observation,
    Raw,
    ScoreAttribute,
    SidedAttribute,
    Unknown,
    score_bins,
)
from taskgist.learning.literals import SetLiteral, vocabularies
from taskgist.settings import DEFAULT, Settings, Vision

POINTS = 3
"""Scores that are played in each bin: enough that two of one bin may differ by more than the tolerance, or less."""


@dataclass(frozen=True)
class Worlds:
    """Worlds of one subtree, as bits.

    Args:
        space: The subtree, or the node that stands for itself.
        bits: The worlds.
    """

    space: str
    bits: int


class Entailment:
    """The worlds of all literals of a tree."""

    def __init__(self, tree: HypothesisTree, settings: Settings = DEFAULT) -> None:
        self._space: dict[str, str] = {}
        self._having: dict[str, dict[str, int]] = {}
        self._all: dict[str, int] = {}
        for subtree in tree.subtrees:
            self._play(subtree, settings)
        for vocabulary in vocabularies(tree, settings):
            if vocabulary.node.name not in self._space:
                self._stand_alone(vocabulary.node.name, vocabulary.values)

    def _play(self, subtree: Subtree, settings: Settings) -> None:
        raws = tuple(_raws(subtree.attribute, settings.vision))
        if not raws:
            return
        worlds = list(product(raws, raws))
        name = subtree.attribute.name
        self._all[subtree.name] = (1 << len(worlds)) - 1
        for index, (initial, final) in enumerate(worlds):
            start, end = {name: Observation(initial)}, {name: Observation(final)}
            for node, observed in subtree.instantiate(start, end, settings).items():
                if not isinstance(observed.value, Unknown):
                    values = self._having.setdefault(node, {})
                    values[observed.value] = values.get(observed.value, 0) | 1 << index
                    self._space[node] = subtree.name

    def _stand_alone(self, node: str, values: tuple[str, ...]) -> None:
        self._space[node] = node
        self._having[node] = {value: 1 << index for index, value in enumerate(values)}
        self._all[node] = (1 << len(values)) - 1

    def worlds(self, literal: SetLiteral) -> Worlds:
        """The worlds in which a literal holds; of a value that no world has, none."""
        space, having = self._space.get(literal.node, literal.node), self._having.get(literal.node, {})
        named = 0
        for value in literal.values:
            named |= having.get(value, 0)
        return Worlds(space, self._all.get(space, 0) & ~named if literal.but else named)

    def space(self, node: str) -> str:
        """The subtree of a node, or the node where it stands for itself."""
        return self._space.get(node, node)

    def all(self, space: str) -> int:
        """All worlds of a subtree."""
        return self._all.get(space, 0)

    def together(self, literals: Iterable[SetLiteral]) -> Mapping[str, int]:
        """The worlds in which a conjunction holds, by subtree; those that it does not speak of are left out."""
        found: dict[str, int] = {}
        for worlds in map(self.worlds, literals):
            found[worlds.space] = found.get(worlds.space, self.all(worlds.space)) & worlds.bits
        return found


@lru_cache(maxsize=8)
def entailment_of(tree: HypothesisTree, settings: Settings = DEFAULT) -> Entailment:
    """The worlds of a tree's literals, made once."""
    return Entailment(tree, settings)


def _raws(attribute: Attribute, vision: Vision) -> Iterator[Raw]:
    """What an attribute may be observed as; nothing where it may be any text."""
    if isinstance(attribute, ScoreAttribute):
        yield 0.0
        for step in range((len(score_bins(vision)) - 1) * POINTS):
            score = vision.negligible_score * 2.0 ** ((step + 0.5) / POINTS / vision.bins_per_doubling)
            if score <= 1.0:
                yield score
    elif isinstance(attribute, SidedAttribute):
        for statuses in product(attribute.values, repeat=len(SIDES)):
            yield dict(zip(SIDES, statuses, strict=True))
    else:
        yield from attribute.values
