"""The inversion: which final values of an attribute will do, found by trying all of them.

For each attribute that literals speak of, all final values that a performer can bring about are enumerated (effort
ladders, placements, statuses of hands; of a score all that it can be, in spans), the subtree is instantiated from the
start and each of them, and those remain for which the literals hold.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.tree import Nodes
from taskgist.facts.values import UNKNOWN, Observation, Raw, ScoreAttribute, SidedAttribute, SymbolAttribute
from taskgist.learning.understanding import AnyLiteral
from taskgist.planning.wanted import (
    HANDS,
    MOTION,
    Aspect,
    Final,
    Given,
    Impossible,
    Span,
    Truth,
    Unjudged,
    Wanted,
    given,
    truths_with,
)
from taskgist.settings import Vision


def inverted(aspect: Aspect, at_rest: Nodes) -> Iterator[Given | Wanted | Impossible | Unjudged]:
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
            yield given(literal, at_rest)
        else:
            yield Impossible(aspect.attribute.name, (literal,), aspect.initial)
    if not kept:
        return
    rows = {final: tuple(row[number] for number in kept) for final, row in table.items()}
    rest = aspect.of(aspect.literals[number] for number in kept)
    wanted = Wanted(rest, FrozenMap(rows))
    yield wanted if wanted.values else Impossible(aspect.attribute.name, rest.literals, aspect.initial)


def _unknown_at_the_start(literal: AnyLiteral, aspect: Aspect) -> Unjudged:
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
