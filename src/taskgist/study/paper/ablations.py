"""Eq. 43, 44 and 8.4: what is lost without the target agent's abilities, and without single levels of the tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from taskgist.facts import STANDARD_TREE, HypothesisTree, Json
from taskgist.facts import vocabulary as v
from taskgist.learning import Clause, clause_of
from taskgist.study.paper.demonstrations import Judged, understanding_of
from taskgist.study.paper.published import CLAUSES, WITHOUT_ABILITIES
from taskgist.study.paper.result import Result, Section, compared

ABILITIES = ("reach", "grasp", "see", "visibility")
"""The subtrees that ask what the target agent can do (8.3)."""
TREES: Mapping[str, HypothesisTree] = {
    "without abilities": STANDARD_TREE.without(subtrees=ABILITIES),
    "without the action level": STANDARD_TREE.without(levels=["action"]),
    "without the nature level": STANDARD_TREE.without(levels=["nature"]),
}
ABOUT = "The same explanations, learned from with a smaller tree."

Clauses = Mapping[str, Clause]


def ablations_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare what the paper says of smaller trees, and list what each task loses.

    Args:
        judged: The judged demonstrations by task.
    """
    whole = _clauses(judged, STANDARD_TREE)
    smaller = {name: _clauses(judged, tree) for name, tree in TREES.items()}
    results = (
        *_opposites(smaller["without abilities"]),
        *_without_action(smaller["without the action level"]),
        *_without_nature(smaller["without the nature level"]),
    )
    changes: dict[str, Json] = {name: _changes(whole, clauses) for name, clauses in smaller.items()}
    return Section("ablations", "Smaller trees (Eq. 43, 44; 8.4)", results, ABOUT, changes)


def _clauses(judged: Mapping[str, tuple[Judged, ...]], tree: HypothesisTree) -> Clauses:
    return {task: clause_of(understanding_of(task, judged[task], tree=tree)) for task in CLAUSES}


def _opposites(clauses: Clauses) -> Iterator[Result]:
    for published in WITHOUT_ABILITIES:
        theirs = {predicate.node: predicate.value for predicate in published.predicates}
        ours = {literal.node: literal.value for literal in clauses[published.task].literals}
        yield compared(f"{published.task} without abilities", published.where, theirs, ours)
    first, second = (clauses[published.task].literals for published in WITHOUT_ABILITIES)
    yield compared("the two opposite tasks become one", "Eq. 43, 44", True, first == second)


def _without_action(clauses: Clauses) -> Iterator[Result]:
    for task, value in (("show", v.BECOMES_EASIER), ("hide", v.BECOMES_DIFFICULT)):
        yield compared(f"{task} without actions: effort to see", "8.4", value, _value(clauses[task], "see.class"))


def _without_nature(clauses: Clauses) -> Iterator[Result]:
    see = [literal.title for literal in clauses["make accessible"].literals if literal.node.startswith("see.")]
    yield compared("make accessible without natures: seeing", "8.4", [], see)


def _value(clause: Clause, node: str) -> str | None:
    return next((literal.value for literal in clause.literals if literal.node == node), None)


def _changes(whole: Clauses, smaller: Clauses) -> Json:
    return {
        task: {
            "lost": [str(each) for each in whole[task].literals if each not in smaller[task].literals],
            "instead": [str(each) for each in smaller[task].literals if each not in whole[task].literals],
        }
        for task in whole
    }
