"""The goal: what must become true in a scene so that a learned clause holds there (9.1, 9.4).

**The problem.** A clause says how the end of a demonstration compares with its start: *seeing becomes difficult*,
*the final placement is On_Support*. Whoever performs the task in a new scene needs it the other way round: from what is
known at the start, which final values will do? If P2 sees the tape after turning the head (level 1), *becomes
difficult* asks for the levels 2 to 5; if P2 could not see it anyway (level 5), nothing can make that true, and the
performer should hear so before it searches.

**The way.** The tree's own functions are inverted by trying. For each attribute that a literal speaks of, all final
values are enumerated (effort ladders, placements, statuses of hands; of a score all that it can be, in spans), the
subtree is instantiated from the start and each of them, and those remain for which the literals hold. So whatever a
comparison or nature means, also a user's own, its inversion means the same.

**An example.** *Hide*, at a start where P2 sees the tape at once (level 0) and sits with free hands::

    given       Initial_Posture = Sitting           true        nobody searches for it
                Final_Posture = Sitting             true
    wanted      placement         On_Support        of six placements
                motion            Static
                hands             Free_of_Object    the tape must not end in P2's hand
                visibility.score  0 ... 4.8e-08     "≈ 0"
                see.effort        levels 1 to 5     Becomes_Difficult
    impossible  nothing

**Who controls what.** The performer moves the thing. So it decides about placement, motion, visibility and efforts; of
the target agent's hands only about what it puts into them or takes out of them; of the target agent's posture nothing.
A literal that holds only if the target agent itself does something is *given*: told with its truth at the start.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import cast

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.tree import HypothesisTree, Nodes, Snapshot, Subtree
from taskgist.facts.values import (
    NOT_OBSERVED,
    UNKNOWN,
    Attribute,
    Observation,
    Raw,
    ScoreAttribute,
    SidedAttribute,
    SymbolAttribute,
    Unknown,
    Value,
)
from taskgist.learning.understanding import Clause, Literal, conjunction
from taskgist.perspective.effort import NO_KNOWN_ACTION, NO_KNOWN_LEVEL
from taskgist.settings import DEFAULT, Settings, Vision

POSTURE, HANDS, MOTION = "posture", "hands", "motion"
CHEAPEST_FIRST = (
    "placement",
    MOTION,
    HANDS,
    "visibility.score",
    "see.effort",
    "reach.effort",
    "grasp.effort",
)
"""Attributes in the order in which a state is judged; others, a user's own, come behind."""

Truth = bool | Unknown


@dataclass(frozen=True)
class Given:
    """A literal that nobody searches for: it was so at the start or not, and stays so.

    Attributes:
        literal: The literal.
        holds: Whether it holds while the target agent does nothing.
        found: What its node is then.
    """

    literal: Literal
    holds: Truth
    found: Value


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
    literals: tuple[Literal, ...]
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
        return f"{now} already: {end.get(self.literals[0].value, f'{wanted} cannot come about')}"


def _shown(raw: Raw) -> str:
    if isinstance(raw, Mapping):
        return ", ".join(f"{side}: {status or 'unknown'}" for side, status in sorted(raw.items()))
    return f"{raw:.2g}" if isinstance(raw, float) else str(raw)


@dataclass(frozen=True)
class Unjudged:
    """A literal that cannot be judged here, and a sentence why."""

    literal: Literal
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
    literals: tuple[Literal, ...]
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

    def of(self, literals: Iterable[Literal]) -> Aspect:
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
    def literals(self) -> tuple[Literal, ...]:
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


@dataclass(frozen=True)
class Goal:
    """What must become true in a scene for a clause to hold there.

    Attributes:
        clause: The clause.
        given: Literals that nobody searches for, each with its truth.
        wanted: What the performer is to bring about, the cheapest to judge first.
        impossible: What cannot be brought about from this start.
        unjudged: Literals that cannot be judged here.
    """

    clause: Clause
    given: tuple[Given, ...]
    wanted: tuple[Wanted, ...]
    impossible: tuple[Impossible, ...]
    unjudged: tuple[Unjudged, ...]

    @classmethod
    def of(cls, clause: Clause, start: Snapshot, tree: HypothesisTree, settings: Settings = DEFAULT) -> Goal:
        """The goal that a clause sets, from what is known at the start.

        Args:
            clause: The clause.
            start: What was observed at the start, by attribute. An attribute that is missing is one that nobody
                observes, at the end neither; one that is there and unknown was only not tracked.
            tree: What the clause was learned in, or more.
            settings: Bins and tolerances of the scores.

        Raises:
            FactsError: The start has a value that an attribute cannot take.
        """
        owners = {node.name: subtree for subtree in tree.subtrees for node in subtree.nodes()}
        known = {name: start[name] for name in tree.attributes if name in start}
        at_rest = tree.instantiate(known, known, settings)  # every node if nothing happens
        found: list[Given | Wanted | Impossible | Unjudged] = []
        by_attribute: dict[str, list[Literal]] = {}
        for literal in clause.literals:
            subtree = owners.get(literal.node)
            if subtree is None:
                found.append(Unjudged(literal, f"the tree has no node {literal.node}"))
            elif (name := _attribute_of(subtree, literal.node)) not in known:
                found.append(Unjudged(literal, f"nobody observes {name} in a state"))
            elif literal.instant == 1 or name == POSTURE:
                found.append(_given(literal, at_rest))
            else:
                by_attribute.setdefault(subtree.attribute.name, []).append(literal)
        for name in sorted(by_attribute, key=_order):
            subtrees = tuple(subtree for subtree in tree.subtrees if subtree.attribute.name == name)
            aspect = Aspect(tree.attributes[name], subtrees, tuple(by_attribute[name]), FrozenMap(known), settings)
            found += _inverted(aspect, at_rest)
        if _is_taken(found):
            found = [given for each in found for given in _left_to_the_taker(each, at_rest)]
        return cls(
            clause,
            given=tuple(each for each in found if isinstance(each, Given)),
            wanted=tuple(each for each in found if isinstance(each, Wanted)),
            impossible=tuple(each for each in found if isinstance(each, Impossible)),
            unjudged=tuple(each for each in found if isinstance(each, Unjudged)),
        )

    @property
    def controllable(self) -> tuple[Literal, ...]:
        """All literals that the performer is to make true, each once, in the order of ``wanted``."""
        return tuple(dict.fromkeys(literal for wanted in self.wanted for literal in wanted.literals))

    @property
    def given_hold(self) -> Truth:
        """Whether what is given is as the clause has it."""
        return conjunction(each.holds for each in self.given)

    def wants(self, attribute: str) -> Wanted | None:
        """What is wanted of an attribute; None if nothing is."""
        return next((each for each in self.wanted if each.attribute == attribute), None)


def _order(attribute: str) -> tuple[int, str]:
    """The cheapest first; what is not known to be cheap comes last."""
    known = attribute in CHEAPEST_FIRST
    return (CHEAPEST_FIRST.index(attribute) if known else len(CHEAPEST_FIRST), attribute)


def _attribute_of(subtree: Subtree, node: str) -> str:
    """Name of the attribute that a node shows; of those above level 3, the one that is compared."""
    leaves = [subtree.leaf] if subtree.leaf else []
    while leaves:
        leaf = leaves.pop()
        if node in (f"{subtree.name}.{leaf.part}.1", f"{subtree.name}.{leaf.part}.2"):
            return leaf.attribute.name
        leaves.extend(leaf.children)
    return subtree.attribute.name


def _is_taken(found: Iterable[Given | Wanted | Impossible | Unjudged]) -> bool:
    """Whether the target agent is to hold the thing in the end, whatever final value of its hands is chosen."""
    hands = next((each for each in found if isinstance(each, Wanted) and each.attribute == HANDS), None)
    values = () if hands is None else hands.values or ()
    return bool(values) and all(isinstance(each, Mapping) and v.HOLDING_OBJECT in each.values() for each in values)


def _left_to_the_taker(
    found: Given | Wanted | Impossible | Unjudged, at_rest: Nodes
) -> Iterable[Given | Wanted | Impossible | Unjudged]:
    """What was found; but that the thing moves in the other's hand is up to that one, and not impossible."""
    if isinstance(found, Impossible) and found.attribute == MOTION:
        return [_given(literal, at_rest) for literal in found.literals]
    return [found]


def _given(literal: Literal, at_rest: Nodes) -> Given:
    return Given(literal, literal.holds(at_rest), at_rest[literal.node].value)


# --- The inversion: which final values will do.


def _inverted(aspect: Aspect, at_rest: Nodes) -> Iterator[Given | Wanted | Impossible | Unjudged]:
    """What becomes of the literals on one attribute: each is wanted, given, impossible or not to be judged."""
    finals = _finals(aspect)
    if finals is None:
        compared = [literal for literal in aspect.literals if literal.instant is None and aspect.initial is UNKNOWN]
        yield from (_unknown_at_the_start(literal, aspect) for literal in compared)
        rest = aspect.of(literal for literal in aspect.literals if literal not in compared)
        if rest.literals:
            yield Wanted(rest, None)
        return
    table = {final: truths_with(aspect, raw) for final, raw in finals.items()}
    kept = list[int]()
    for number, literal in enumerate(aspect.literals):
        column = {row[number] for row in table.values()}
        if True in column or (UNKNOWN in column and literal.instant == 2):
            kept.append(number)  # where the value alone leaves it open, the action or the state below decides
        elif UNKNOWN in column:
            yield _unknown_at_the_start(literal, aspect)
        elif _up_to_the_agent(aspect.of([literal])):
            yield _given(literal, at_rest)
        else:
            yield Impossible(aspect.attribute.name, (literal,), aspect.initial)
    if not kept:
        return
    rows = {final: tuple(row[number] for number in kept) for final, row in table.items()}
    rest = aspect.of(aspect.literals[number] for number in kept)
    wanted = Wanted(rest, FrozenMap(rows))
    yield wanted if wanted.values else Impossible(aspect.attribute.name, rest.literals, aspect.initial)


def _unknown_at_the_start(literal: Literal, aspect: Aspect) -> Unjudged:
    return Unjudged(literal, f"what {aspect.attribute.name} was at the start is not known")


def _finals(aspect: Aspect) -> Mapping[Final, Raw] | None:
    """What the performer can make of an attribute, each with a raw value that stands for it; None if that is any text.

    What is performed ends at rest, and hands get the thing or lose it.
    """
    attribute, initial = aspect.attribute, aspect.initial
    if attribute.name == MOTION:
        return {v.STATIC: v.STATIC}
    match attribute:
        case SymbolAttribute(values=values) if values:
            return {symbol: symbol for symbol in values}
        case SidedAttribute() if isinstance(initial, Mapping):
            ends = {side: _ends_of_hand(status) for side, status in initial.items()}
            return {hands: hands for hands in _by_side(ends)}
        case ScoreAttribute():
            return _spans(aspect)
    return None


def _ends_of_hand(status: str | None) -> tuple[str | None, ...]:
    """What a performer can make of a hand of the target agent; one that is not tracked stays so."""
    match status:
        case v.FREE_OF_OBJECT | v.RESTING_ON_SUPPORT:
            return status, v.HOLDING_OBJECT
        case v.HOLDING_OBJECT:
            return status, v.FREE_OF_OBJECT
    return (status,)


def _by_side(statuses: Mapping[str, Sequence[str | None]]) -> Iterator[FrozenMap[str, str | None]]:
    """All combinations of some statuses of each hand."""
    for chosen in itertools.product(*statuses.values()):
        yield FrozenMap(dict(zip(statuses, chosen, strict=True)))


def _up_to_the_agent(aspect: Aspect) -> bool:
    """Whether literals would hold if the target agent itself did something else with its hands."""
    attribute, initial = aspect.attribute, aspect.initial
    if attribute.name != HANDS or not isinstance(attribute, SidedAttribute) or not isinstance(initial, Mapping):
        return False
    ends = _by_side(dict.fromkeys(initial, attribute.values))
    return any(set(truths_with(aspect, hands)) == {True} for hands in ends)


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
    named = {literal.value for literal in aspect.literals} - set(ends.values())
    return [*sorted(named), ANOTHER_ACTION]


# --- Scores: spans between the scores at which the truth of a literal changes.


def _spans(aspect: Aspect) -> Mapping[Final, Raw]:
    """The scores from 0 to 1 in spans throughout which each literal is true, or is not, with a score for each.

    They are tried on a grid so fine that no literal changes twice between two neighbours.
    """

    @cache
    def truths(score: float) -> tuple[Truth, ...]:
        return aspect.truths({aspect.attribute.name: Observation(score)})

    grid = _grid(aspect.initial, aspect.settings.vision)
    edges = [edge for low, high in itertools.pairwise(grid) for edge in _changes(truths, low, high)]
    begins, ends = [grid[0], *(after for _, after in edges)], [*(before for before, _ in edges), grid[-1]]
    return {Span(low, high): low for low, high in zip(begins, ends, strict=True)}


def _grid(initial: Raw, vision: Vision) -> list[float]:
    """Scores with two in each bin, the least and greatest, and that of the start, about which changes are judged."""
    halves = math.ceil(2 * vision.bins_per_doubling * -math.log2(vision.negligible_score))
    steps = {vision.negligible_score * 2.0 ** (step / (2 * vision.bins_per_doubling)) for step in range(halves)}
    own = {initial} if isinstance(initial, float) else set()
    return sorted({0.0, 1.0} | own | {score for score in steps if score < 1.0})


def _changes(truths: Callable[[float], tuple[Truth, ...]], low: float, high: float) -> Iterator[tuple[float, float]]:
    """Neighbouring numbers between which truths change, ascending, found by bisection."""
    if truths(low) == truths(high):
        return
    middle = (low + high) / 2
    if middle in (low, high):
        yield low, high
        return
    yield from _changes(truths, low, middle)
    yield from _changes(truths, middle, high)
