"""What is wanted of one attribute: the literals that speak of it, and the final values with which they hold.

A literal of a clause is given, wanted, impossible or not to be judged; which of these is found by trying final values
(``inversion``), and a ``Goal`` is what comes of all literals.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import cast

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.tree import Nodes, Snapshot, Subtree
from taskgist.facts.values import NOT_OBSERVED, UNKNOWN, Attribute, Observation, Raw, Unknown, Value
from taskgist.learning.understanding import AnyLiteral
from taskgist.perspective.effort import NO_KNOWN_ACTION, NO_KNOWN_LEVEL
from taskgist.settings import Settings

HANDS, MOTION = "hands", "motion"

Truth = bool | Unknown


@dataclass(frozen=True)
class Given:
    """A literal that nobody searches for: it was so at the start or not, and stays so.

    Attributes:
        literal: The literal.
        holds: Whether it holds while the target agent does nothing.
        found: What its node is then.
    """

    literal: AnyLiteral
    holds: Truth
    found: Value


def given(literal: AnyLiteral, at_rest: Nodes) -> Given:
    """A literal with what its node is if nothing happens."""
    return Given(literal, literal.holds(at_rest), at_rest[literal.node].value)


@dataclass(frozen=True)
class Impossible:
    """Literals on one attribute that no final value of it makes true from this start.

    Attributes:
        attribute: Name of the attribute.
        literals: One that never holds; or several that never hold together.
        start: What the attribute is at the start.
        reason: A sentence why, where it is not that.
    """

    attribute: str
    literals: tuple[AnyLiteral, ...]
    start: Raw
    reason: str = ""

    @property
    def why(self) -> str:
        """A sentence: what is so at the start, and what therefore cannot be."""
        if self.reason:
            return self.reason
        aspect, level = self.attribute.partition(".")[0], v.EFFORT_LEVELS.get(str(self.start))
        wanted = " and ".join(map(str, self.literals))
        if self.attribute == MOTION:
            return f"what is performed ends at rest: {wanted} cannot be"
        now = f"{self.attribute} is {_shown(self.start)}" if level is None else f"{aspect} is at level {level}"
        end = {v.BECOMES_DIFFICULT: "it cannot become more difficult", v.BECOMES_EASIER: "it cannot become easier"}
        return f"{now} already: {end.get(self.literals[0].value or '', f'{wanted} cannot come about')}"


def _shown(raw: Raw) -> str:
    if isinstance(raw, Mapping):
        return ", ".join(f"{side}: {status or 'unknown'}" for side, status in sorted(raw.items()))
    return f"{raw:.2g}" if isinstance(raw, float) else str(raw)


@dataclass(frozen=True)
class Unjudged:
    """A literal that cannot be judged here, and a sentence why."""

    literal: AnyLiteral
    why: str


@dataclass(frozen=True)
class Dropped:
    """A circumstance that is not asked for, because it cannot be had here, and a sentence why."""

    literal: AnyLiteral
    why: str


@dataclass(frozen=True, order=True)
class Span:
    """Scores from ``low`` to ``high``, both among them; fractions of the image."""

    low: float
    high: float

    def __contains__(self, score: float) -> bool:
        return self.low <= score <= self.high


Final = str | FrozenMap[str, str | None] | Span
"""A final value of an attribute: a symbol, a status by side, or a span of scores."""


@dataclass(frozen=True)
class Aspect:
    """An attribute with those subtrees that compare it, and the literals that speak of them.

    Attributes:
        attribute: The attribute.
        subtrees: The subtrees.
        literals: The literals, in the order of the clause.
        start: What is known at the start.
        settings: Bins and tolerances of the scores.
    """

    attribute: Attribute
    subtrees: tuple[Subtree, ...]
    literals: tuple[AnyLiteral, ...]
    start: Snapshot = field(repr=False)
    settings: Settings = field(repr=False)

    @property
    def initial(self) -> Raw:
        """What the attribute is at the start."""
        return self.start.get(self.attribute.name, NOT_OBSERVED).value

    def nodes(self, found: Snapshot) -> Nodes:
        """The subtrees' nodes where the end is as found; attributes that were not looked at are unknown."""
        nodes: dict[str, Observation[Value]] = {}
        for subtree in self.subtrees:
            nodes |= subtree.instantiate(self.start, found, self.settings)
        return nodes

    def truths(self, found: Snapshot) -> tuple[Truth, ...]:
        """Whether each of the literals holds where the end is as found."""
        nodes = self.nodes(found)
        return tuple(literal.holds(nodes) for literal in self.literals)

    def of(self, literals: Iterable[AnyLiteral]) -> Aspect:
        """The same for other literals on it."""
        return Aspect(self.attribute, self.subtrees, tuple(literals), self.start, self.settings)


@dataclass(frozen=True)
class Wanted:
    """Literals that the performer is to make true by one attribute's final value.

    Attributes:
        aspect: What they speak of.
        truths: By each final value that the performer can bring about, in canonical order: whether each literal holds
            then; unknown where an effort's state or action decides. None where any text is a value, so that only
            trying tells.
    """

    aspect: Aspect
    truths: FrozenMap[Final, tuple[Truth, ...]] | None

    @property
    def attribute(self) -> str:
        """Name of the attribute."""
        return self.aspect.attribute.name

    @property
    def literals(self) -> tuple[AnyLiteral, ...]:
        """The literals, in the order of the clause."""
        return self.aspect.literals

    @cached_property
    def values(self) -> tuple[Final, ...] | None:
        """The final values with which none of the literals surely fails; None where any text is a value."""
        if self.truths is None:
            return None
        return tuple(final for final, truths in self.truths.items() if False not in truths)

    @property
    def levels(self) -> tuple[int, ...]:
        """The effort levels among these, ascending; none for other attributes."""
        if not is_effort(self.aspect.attribute):
            return ()
        return tuple(v.EFFORT_LEVELS[str(value)] for value in self.values or ())

    @cached_property
    def decisive_level(self) -> int | None:
        """The greatest level of which it matters whether it is this one or more: −1 if none; None for no effort."""
        if self.truths is None or not is_effort(self.aspect.attribute):
            return None
        steps = enumerate(itertools.pairwise(self.truths.values()))
        return max((level for level, (truths, more) in steps if truths != more), default=-1)

    @cached_property
    def spans(self) -> tuple[Span, ...]:
        """The spans of scores among the final values, ascending; none for other attributes."""
        return tuple(value for value in self.values or () if isinstance(value, Span))

    def truths_of(self, found: Raw) -> tuple[Truth, ...]:
        """Whether each literal holds with a final value of the attribute."""
        if self.truths is not None:
            if isinstance(found, float):
                return next(truths for final, truths in self.truths.items() if found in cast(Span, final))
            if found in self.truths:
                return self.truths[cast(Final, found)]
        return truths_with(self.aspect, found)

    def missed_by(self, found: Raw) -> float | None:
        """How far a final value is from the nearest that will do: in effort levels, or as a fraction of the image.

        Returns:
            0 where it will do, and None where that is no matter of degree, or unknown.
        """
        if isinstance(found, float):
            return min((max(span.low - found, found - span.high, 0.0) for span in self.spans), default=None)
        if self.levels and found in v.EFFORT_LEVELS:
            return float(min(abs(v.EFFORT_LEVELS[str(found)] - level) for level in self.levels))
        return None


def truths_with(aspect: Aspect, raw: Raw) -> tuple[Truth, ...]:
    """Whether each literal holds with a final value of the attribute; unknown where that leaves it open."""
    found: Snapshot = {aspect.attribute.name: Observation(raw)}
    if not is_effort(aspect.attribute) or raw is UNKNOWN:
        return aspect.truths(found)
    action = f"{aspect.attribute.name.partition('.')[0]}.action"
    ends = [aspect.truths({**found, action: Observation(text)}) for text in _actions(aspect, v.EFFORT_LEVELS[str(raw)])]
    return tuple(each[0] if len(set(each)) == 1 else UNKNOWN for each in zip(*ends, strict=True))


# --- Efforts: a ladder of levels, of which the ends say by what action.


def is_effort(attribute: Attribute) -> bool:
    """Whether an attribute is an effort type."""
    return attribute.values in (v.REACH_EFFORTS, v.SEE_EFFORTS)


ANOTHER_ACTION = "another"
"""Stands for all actions that a clause does not name."""


def _actions(aspect: Aspect, level: int) -> Sequence[str]:
    """The actions that may give an effort level, as far as the literals can tell them apart."""
    ends = {0: v.NO_ACTION, NO_KNOWN_LEVEL: NO_KNOWN_ACTION}
    if level in ends:
        return [ends[level]]
    named = {value for literal in aspect.literals for value in literal.values} - set(ends.values())
    return [*sorted(named), ANOTHER_ACTION]
