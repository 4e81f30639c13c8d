"""The goal: what must become true in a scene so that a learned clause holds there (9.1, 9.4).

**The problem.** A clause says how the end of a demonstration compares with its start: *seeing becomes difficult*,
*the final placement is On_Support*. Whoever performs the task in a new scene needs it the other way round: from what is
known at the start, which final values will do? If P2 sees the tape after turning the head (level 1), *becomes
difficult* asks for the levels 2 to 5; if P2 could not see it anyway (level 5), nothing can make that true, and the
performer should hear so before it searches.

**The way.** The tree's own functions are inverted by trying (``inversion``). For each attribute that a literal speaks
of, all final values are enumerated (effort ladders, placements, statuses of hands; of a score all that it can be, in
spans), the subtree is instantiated from the start and each of them, and those remain for which the literals hold. So
whatever a comparison or nature means, also a user's own, its inversion means the same.

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

**Circumstances** of a clause, usual ones and what else was always so, are wanted like its literals, one after the
other, as far as this start admits them beside those and the ones before. One that it rules out is dropped, and told;
one that is not the performer's to decide is not asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.tree import HypothesisTree, Nodes, Snapshot, Subtree
from taskgist.learning.understanding import AnyLiteral, Clause
from taskgist.planning.inversion import inverted
from taskgist.planning.wanted import (
    HANDS,
    MOTION,
    Aspect,
    Dropped,
    Given,
    Impossible,
    Span,
    Truth,
    Unjudged,
    Wanted,
    given,
)
from taskgist.settings import DEFAULT, Settings

__all__ = ["Dropped", "Given", "Goal", "Impossible", "Span", "Truth", "Unjudged", "Wanted", "is_taken"]

POSTURE = "posture"
Found = Given | Wanted | Impossible | Unjudged
"""What may become of a literal."""
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


@dataclass(frozen=True)
class Goal:
    """What must become true in a scene for a clause to hold there.

    Attributes:
        clause: The clause.
        given: Literals that nobody searches for, each with its truth.
        wanted: What the performer is to bring about, the cheapest to judge first.
        impossible: What cannot be brought about from this start.
        unjudged: Literals that cannot be judged here.
        circumstances: Those that are wanted, too; they stand in ``wanted`` beside the literals.
        dropped: Circumstances that this start rules out.
    """

    clause: Clause
    given: tuple[Given, ...]
    wanted: tuple[Wanted, ...]
    impossible: tuple[Impossible, ...]
    unjudged: tuple[Unjudged, ...]
    circumstances: tuple[AnyLiteral, ...] = ()
    dropped: tuple[Dropped, ...] = ()

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
        known = FrozenMap({name: start[name] for name in tree.attributes if name in start})
        at_rest = tree.instantiate(known, known, settings)  # every node if nothing happens
        found = _sorted_out(clause.literals, known, at_rest, tree, settings)
        kept, dropped = list[AnyLiteral](), list[Dropped]()
        for literal in clause.circumstances:
            more = _sorted_out((*clause.literals, *kept, literal), known, at_rest, tree, settings)
            against = next((each for each in more if isinstance(each, Impossible) and literal in each.literals), None)
            if against is not None:
                dropped.append(Dropped(literal, against.why))
            elif any(isinstance(each, Wanted) and literal in each.literals for each in more):
                kept.append(literal)
                found = more
        return cls(
            clause,
            given=tuple(each for each in found if isinstance(each, Given)),
            wanted=tuple(each for each in found if isinstance(each, Wanted)),
            impossible=tuple(each for each in found if isinstance(each, Impossible)),
            unjudged=tuple(each for each in found if isinstance(each, Unjudged)),
            circumstances=tuple(kept),
            dropped=tuple(dropped),
        )

    @property
    def controllable(self) -> tuple[AnyLiteral, ...]:
        """All literals of the clause that the performer is to make true, each once, in the order of ``wanted``."""
        wanted = dict.fromkeys(literal for wanted in self.wanted for literal in wanted.literals)
        return tuple(literal for literal in wanted if literal not in self.circumstances)

    def wants(self, attribute: str) -> Wanted | None:
        """What is wanted of an attribute; None if nothing is."""
        return next((each for each in self.wanted if each.attribute == attribute), None)


def _sorted_out(
    literals: Sequence[AnyLiteral], known: Snapshot, at_rest: Nodes, tree: HypothesisTree, settings: Settings
) -> list[Found]:
    """What becomes of each literal: given, wanted, impossible or not to be judged, the cheapest to judge first."""
    owners = {node.name: subtree for subtree in tree.subtrees for node in subtree.nodes()}
    found: list[Found] = []
    by_attribute: dict[str, list[AnyLiteral]] = {}
    for literal in literals:
        subtree = owners.get(literal.node)
        if subtree is None:
            found.append(Unjudged(literal, f"the tree has no node {literal.node}"))
        elif (name := _attribute_of(subtree, literal.node)) not in known:
            found.append(Unjudged(literal, f"nobody observes {name} in a state"))
        elif literal.instant == 1 or name == POSTURE:
            found.append(given(literal, at_rest))
        else:
            by_attribute.setdefault(subtree.attribute.name, []).append(literal)
    for name in sorted(by_attribute, key=_order):
        subtrees = tuple(subtree for subtree in tree.subtrees if subtree.attribute.name == name)
        aspect = Aspect(tree.attributes[name], subtrees, tuple(by_attribute[name]), known, settings)
        found += inverted(aspect, at_rest)
    if is_taken(found):
        found = [one for each in found for one in _left_to_the_taker(each, at_rest)]
    return found


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


def is_taken(found: Iterable[Found]) -> bool:
    """Whether the target agent is to hold the thing in the end, whatever final value of its hands is chosen."""
    hands = next((each for each in found if isinstance(each, Wanted) and each.attribute == HANDS), None)
    values = () if hands is None else hands.values or ()
    return bool(values) and all(isinstance(each, Mapping) and v.HOLDING_OBJECT in each.values() for each in values)


def _left_to_the_taker(found: Found, at_rest: Nodes) -> Iterable[Found]:
    """What was found; but that the thing moves in the other's hand is up to that one, and not impossible."""
    if isinstance(found, Impossible) and found.attribute == MOTION:
        return [given(literal, at_rest) for literal in found.literals]
    return [found]
