"""What must not hold: in what demonstrations that were done wrong differ from those that were done right.

**The roles exchanged.** The learner of clauses asks what a task's demonstrations have in common that others have not.
Asked of the wrong ones, compared with the right ones alone, it tells what makes them wrong. What holds in right ones,
too, is no reason; neither is what happens elsewhere: that a thing is seen without effort is usual in the world, and
still what must not be when it was to be hidden.

**Single literals.** *Not this and that together* is no goal that a planner can take. So reasons are single literals,
one for each subtree at most: the one that is told most briefly. That an effort is lower now, that this is supportive,
and which effort it is now, is one reason and not three.

**Several mistakes.** One drops the thing, another lets it be seen. Demonstrations in which no reason holds that was
found are looked at once more by themselves, until nothing is found.

**How sure.** Each literal has odds against chance, as clauses have: those that it holds in so many wrong ones because
it is what was wrong, and not because it happens so often in right ones. One wrong demonstration beside nine right ones
makes them even at best; three make them more than a hundred to one. Reasons below even odds are not told.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.clauses import MustNot, learn_clauses
from taskgist.learning.evidence import Effects, Evidence
from taskgist.learning.literals import SetLiteral

ALMOST_NEVER = 0.1
"""What holds in a greater share of the right demonstrations is no reason."""
_RIGHT, _WRONG = "right", "wrong"


def learn_must_not(
    wrong: Iterable[Effects], right: Iterable[Effects], tree: HypothesisTree = STANDARD_TREE
) -> tuple[MustNot, ...]:
    """What wrong demonstrations have in common, and right ones have not; the surest first.

    Args:
        wrong: Known values of demonstrations that were done wrong; none: nothing is learned.
        right: Those of the same task that were done right; none: nothing is learned.
        tree: Whose effects it may be.
    """
    left, right = list(wrong), list(right)
    evidence = Evidence.of({_WRONG: left, _RIGHT: right})
    found: list[MustNot] = []
    while left and right:
        fresh = [
            MustNot(literal, _counted(evidence, literal, _WRONG), _counted(evidence, literal, _RIGHT), odds)
            for literal, odds in _reasons(left, right, tree)
        ]
        unexplained = [each for each in left if not any(_holds(one.literal, each) for one in fresh)]
        if len(unexplained) == len(left):
            break
        found += fresh  # none of those before holds in what was left
        left = unexplained
    return tuple(sorted(found, key=lambda each: (-round(math.log(each.odds or 1.0), 9), each.literal.order)))


def _reasons(
    wrong: Sequence[Effects], right: Sequence[Effects], tree: HypothesisTree
) -> Iterator[tuple[SetLiteral, float]]:
    """What holds in most of the wrong ones and hardly ever in right ones, one for each subtree, and its odds."""
    evidence = Evidence.of({_WRONG: wrong, _RIGHT: right})
    told: set[str] = set()
    for clause in learn_clauses(evidence, _WRONG, tree, most_literals=1).clauses:
        if clause.score <= 0 or not clause.literals:
            continue
        (literal,) = clause.literals
        subtree = literal.node.partition(".")[0]
        holds, known = _counted(evidence, literal, _RIGHT)
        if subtree not in told and known > 0 and holds <= ALMOST_NEVER * known:
            told.add(subtree)
            yield literal, math.exp(clause.score)


def _holds(literal: SetLiteral, effects: Effects) -> bool:
    return literal.node in effects and literal.admits(effects[literal.node])


def _counted(evidence: Evidence, literal: SetLiteral, name: str) -> tuple[int, int]:
    kind = evidence.kind(name)
    true, false = (kind.of(bits).bit_count() for bits in evidence.truth(literal))
    return true, true + false
