"""What must not hold: in what demonstrations that were done wrong differ from those that were done right.

**The roles exchanged.** The learner of clauses asks what a task's demonstrations have in common that others have not.
Asked of the wrong ones, compared with the right ones alone, it tells what makes them wrong. What holds in right ones,
too, is no reason; neither is what happens elsewhere: that a thing is seen without effort is usual in the world, and
still what must not be when it was to be hidden.

**Single literals.** *Not this and that together* is no goal that a planner can take. So reasons are single literals,
one for each node at most: the one that is told most briefly, which is the value that was seen, and no larger set.

**How sure.** Each literal has odds against chance, as clauses have: those that it holds in so many wrong ones because
it is what was wrong, and not because it happens so often in right ones. One wrong demonstration beside nine right ones
makes them even at best; three make them more than a hundred to one. Reasons below even odds are not told.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

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
    evidence = Evidence.of({_WRONG: wrong, _RIGHT: right})
    if not all(kind.count for kind in evidence.kinds.values()):
        return ()
    found: dict[str, MustNot] = {}
    for clause in learn_clauses(evidence, _WRONG, tree, most_literals=1).clauses:
        if clause.score <= 0 or not clause.literals:
            continue
        (literal,) = clause.literals
        in_wrong, in_right = (_counted(evidence, literal, name) for name in (_WRONG, _RIGHT))
        if in_right[1] and in_right[0] <= ALMOST_NEVER * in_right[1]:
            found.setdefault(literal.node, MustNot(literal, in_wrong, in_right, math.exp(clause.score)))
    return tuple(found.values())


def _counted(evidence: Evidence, literal: SetLiteral, name: str) -> tuple[int, int]:
    kind = evidence.kind(name)
    true, false = (kind.of(bits).bit_count() for bits in evidence.truth(literal))
    return true, true + false
