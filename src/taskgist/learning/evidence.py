"""Evidence: the effects of many demonstrations as bits, so that a conjunction is tested on all of them at once.

Each demonstration is a bit. A value of a node is a whole number in which the bits of those demonstrations are set that
had it; a conjunction of values is an *and* of such numbers, and counting is counting bits. The demonstrations of one
kind, which is a task or the neutral manipulations, lie side by side.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from taskgist.common.frozen import FrozenMap
from taskgist.errors import UnknownNameError
from taskgist.facts.values import Unknown
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Explanation
from taskgist.learning.literals import SetLiteral

Effects = Mapping[str, str]
"""Values of the nodes that are known in one demonstration."""

_NONE: FrozenMap[str, int] = FrozenMap()


@dataclass(frozen=True)
class Kind:
    """Where the demonstrations of one kind lie.

    Args:
        start: Their first bit.
        count: How many there are.
    """

    start: int
    count: int

    def of(self, bits: int) -> int:
        """The bits of this kind alone, from bit 0 on."""
        return (bits >> self.start) & ((1 << self.count) - 1)


@dataclass(frozen=True)
class Evidence:
    """Demonstrations of several kinds, as bits."""

    kinds: FrozenMap[str, Kind]
    """By name: that of a task, or of neutral manipulations."""
    having: FrozenMap[str, FrozenMap[str, int]]
    """By node and value: the demonstrations that had it."""
    known: FrozenMap[str, int]
    """By node: the demonstrations in which it was known."""

    @staticmethod
    def of(kinds: Mapping[str, Iterable[Effects]]) -> Evidence:
        """The evidence of demonstrations by kind; the order within a kind changes no count."""
        placed: dict[str, Kind] = {}
        having: dict[str, dict[str, list[int]]] = {}
        end = 0
        for name in sorted(kinds):
            start = end
            for effects in kinds[name]:
                for node, value in effects.items():
                    having.setdefault(node, {}).setdefault(value, []).append(end)
                end += 1
            placed[name] = Kind(start, end - start)
        masks = {node: {value: _bits(found, end) for value, found in each.items()} for node, each in having.items()}
        return Evidence(
            FrozenMap(placed),
            FrozenMap({node: FrozenMap(values) for node, values in masks.items()}),
            FrozenMap({node: sum(values.values()) for node, values in masks.items()}),
        )

    @property
    def size(self) -> int:
        """How many demonstrations there are."""
        return sum(kind.count for kind in self.kinds.values())

    def kind(self, name: str) -> Kind:
        """The kind of this name.

        Raises:
            UnknownNameError: There is none.
        """
        if name not in self.kinds:
            raise UnknownNameError("task", name, self.kinds)
        return self.kinds[name]

    def seen(self, node: str, name: str) -> frozenset[str]:
        """The values that a node had in demonstrations of one kind."""
        kind = self.kind(name)
        return frozenset(value for value, bits in self.having.get(node, _NONE).items() if kind.of(bits))

    def effects(self, number: int) -> Effects:
        """The known values of one demonstration, by its bit."""
        return {
            node: value for node, values in self.having.items() for value, bits in values.items() if bits >> number & 1
        }

    def truth(self, literal: SetLiteral) -> tuple[int, int]:
        """The demonstrations in which a literal holds, and those in which it fails; it is unknown in the others."""
        having, known = self.having.get(literal.node, _NONE), self.known.get(literal.node, 0)
        named = sum(having.get(value, 0) for value in literal.values)  # no demonstration has two values of a node
        return (known & ~named, named) if literal.but else (named, known & ~named)

    def together(self, literals: Iterable[SetLiteral]) -> tuple[int, int]:
        """The same of a conjunction: it holds where all do, and fails where one does."""
        true, false = (1 << self.size) - 1, 0
        for literal in literals:
            holds, fails = self.truth(literal)
            true, false = true & holds, false | fails
        return true, false


def effects_of(explanation: Explanation) -> dict[str, str]:
    """The known values of an explanation."""
    return {name: node.value for name, node in explanation.nodes.items() if not isinstance(node.value, Unknown)}


def evidence_of(
    experiences: Iterable[Experience], background: Mapping[str, Iterable[Effects]] | None = None
) -> Evidence:
    """The evidence of what has been seen of several tasks, beside kinds that belong to no task.

    Args:
        experiences: One for each task.
        background: Further demonstrations by kind, such as the neutral manipulations that are shipped.
    """
    kinds: dict[str, Iterable[Effects]] = dict(background or {})
    for experience in experiences:
        ordered = sorted(experience.explanations)
        kinds[experience.task] = [effects_of(experience.explanations[digest]) for digest in ordered]
    return Evidence.of(kinds)


def _bits(positions: Iterable[int], size: int) -> int:
    """The number in which these bits are set, made in time that grows with their number alone."""
    row = bytearray(size // 8 + 1)
    for at in positions:
        row[at >> 3] |= 1 << (at & 7)
    return int.from_bytes(row, "little")
