"""Learning from many draws: those that agree and dissent alike are learned from but once.

Each node is judged by how often each of its values was observed, and with so few demonstrations any dissent makes it
irrelevant (6.4): which values dissent, and in which demonstration, does not matter then. So a draw is reduced to a
*pattern*, which keeps what all demonstrations agree on and says of the rest only how often it was observed. Hundreds of
draws have few patterns, and learning from a pattern gives the very clause of the draw.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from functools import cache

from taskgist.facts import STANDARD_TREE, UNKNOWN, Observation, Unknown, Value
from taskgist.learning import Context, Experience, Explanation, clause_of, understand
from taskgist.study.paper.draws import Draw

MOST_DEMONSTRATIONS = 6
"""With so many, one that dissents makes a node irrelevant: CF = 1/2 lies below d1 = 21/40."""

Values = Mapping[str, str]
"""What a clause says, by node."""


def learned_clauses(draws: Iterable[Draw]) -> Iterator[Values]:
    """The clause of each draw of which all demonstrations could be played.

    Args:
        draws: Draws of one task.
    """
    for draw in draws:
        outcomes = [outcome for outcome in draw if not isinstance(outcome, str)]
        if len(outcomes) == len(draw):
            assert len(draw) <= MOST_DEMONSTRATIONS, "a dissent might not matter"
            yield _clause(tuple(_pattern(column) for column in zip(*outcomes, strict=True)))


def _pattern(column: tuple[Value, ...]) -> tuple[Value, ...]:
    """Values of one node: as they are where they agree, else as numbers, the most frequent one first."""
    known = [value for value in column if not isinstance(value, Unknown)]
    counts = Counter(known)
    if len(counts) > 1:
        known = [f"value {rank}" for rank, (_, count) in enumerate(counts.most_common(), 1) for _ in range(count)]
    return (*known, *[UNKNOWN] * (len(column) - len(known)))


@cache
def _clause(columns: tuple[tuple[Value, ...], ...]) -> Values:
    explanations = [
        Explanation(
            task="any",
            demonstration=f"{number}",
            performing_agent="",
            target_agent="",
            target_object="",
            source=f"{number}",
            context=Context.of(),
            nodes={node.name: Observation(value) for node, value in zip(STANDARD_TREE.nodes, outcome, strict=True)},
        )
        for number, outcome in enumerate(zip(*columns, strict=True), start=1)
    ]
    clause = clause_of(understand(Experience.of("any", explanations)))
    return {literal.node: literal.value for literal in clause.literals}
