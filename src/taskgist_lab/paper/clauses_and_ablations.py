"""The learned clauses beside the paper's (Eq. 36–42), and what is lost without parts of the tree (Eq. 43, 44; 8.4)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from taskgist.common.frozen import Json
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.understanding import Clause, Understanding, clause_of
from taskgist_lab.paper.judging import Judged, understanding_of
from taskgist_lab.paper.published import (
    CLAUSES,
    SHORT_SHOW,
    WITHOUT_ABILITIES,
    Published,
    PublishedClause,
    Result,
    Section,
    Verdict,
    compared,
)

# --- Eq. 43, 44 and 8.4: what is lost without the target agent's abilities, and without single levels of the tree.

ABILITIES = ("reach", "grasp", "see", "visibility")
"""The subtrees that ask what the target agent can do (8.3)."""
TREES: Mapping[str, HypothesisTree] = {
    "without abilities": STANDARD_TREE.without(subtrees=ABILITIES),
    "without the action level": STANDARD_TREE.without(levels=["action"]),
    "without the nature level": STANDARD_TREE.without(levels=["nature"]),
}
ABLATIONS_ABOUT = "The same explanations, learned from with a smaller tree."

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
    return Section("ablations", "Smaller trees (Eq. 43, 44; 8.4)", results, ABLATIONS_ABOUT, changes)


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


# --- Eq. 36-42: the learned clauses beside the paper's, predicate by predicate.

ABSENT = None
"""Our value of a predicate that the learned clause does not have."""
CLAUSES_ABOUT = (
    "Learned from the recreated demonstrations of each task; a predicate of ours that the paper's clause lacks would "
    "stand here, too, and fail."
)


def clauses_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare the clause of every task.

    Args:
        judged: The judged demonstrations by task.
    """
    results: list[Result] = []
    for task, published in CLAUSES.items():
        clause = clause_of(understanding_of(task, judged[task]))
        results += compared_clause(published, clause)
        if task == SHORT_SHOW.task:
            results += compared_clause(SHORT_SHOW, clause)
    return Section("clauses", "The clauses, predicate by predicate (Eq. 36-42)", tuple(results), CLAUSES_ABOUT)


def compared_clause(published: PublishedClause, clause: Clause) -> Iterator[Result]:
    """A result for each predicate of either clause, the paper's first."""
    ours = {literal.node: literal for literal in clause.literals}
    for predicate in published.predicates:
        literal = ours.pop(predicate.node, ABSENT)
        yield _compared(published, predicate, literal.value if literal else ABSENT)
    for literal in ours.values():
        name = f"{published.task}: {literal.title}"
        yield Result(name, published.where, ABSENT, literal.value, Verdict.FAILS, "not in the paper's clause")


def _compared(published: PublishedClause, predicate: Published, value: str | None) -> Result:
    name = f"{published.task}: {STANDARD_TREE.node(predicate.node).title}"
    if value != predicate.value:
        problem = f"not in the learned clause; expected {predicate.value}" if value is ABSENT else ""
        return Result(name, published.where, predicate.printed or None, value, Verdict.FAILS, problem)
    verdict = Verdict.DIFFERS_EXPLAINED if predicate.reason else Verdict.EQUAL
    return Result(name, published.where, predicate.printed or None, value, verdict, predicate.reason)


# --- Fig. 15, 17, 18: what is understood of *show* after two, three and four demonstrations.

TASK = "show"
KEPT = (
    ("reach", 2, "Fig. 15, 16", True),
    ("reach", 3, "Fig. 17, Table 4", False),
    ("placement", 3, "Table 2", True),
    ("placement", 4, "Fig. 18, Table 2", False),
)
"""Subtrees, after how many demonstrations, where the paper says it, and whether they still are understood to matter."""
DEEPEST = (
    ("posture", 3, "Fig. 17, 18", ("value.1", "value.2")),
    ("posture", 4, "Fig. 18", ("class",)),
)
"""The same for the deepest nodes that are kept of a subtree."""
FIGURES_ABOUT = (
    "The third demonstration prunes the subtree of reaching; the fourth, the first one of people who stand, lifts the "
    "posture by a level and prunes where the object ends. So much does the paper's text tell of its figures."
)


def figures_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare the understanding of *show* while it grows.

    Args:
        judged: The judged demonstrations by task.
    """
    grown = {count: understanding_of(TASK, judged[TASK][:count]) for count in (2, 3, 4)}
    kept = (
        compared(f"{subtree} is kept after {count}", where, paper, bool(nodes_kept(grown[count], subtree)))
        for subtree, count, where, paper in KEPT
    )
    deepest = (
        compared(f"deepest of {subtree} after {count}", where, paper, deepest_kept(grown[count], subtree))
        for subtree, count, where, paper in DEEPEST
    )
    nodes = {str(count): [each.node.name for each in understood.kept] for count, understood in grown.items()}
    return Section("figures", "Show after 2, 3 and 4 demonstrations", (*kept, *deepest), FIGURES_ABOUT, {"kept": nodes})


def nodes_kept(understanding: Understanding, subtree: str) -> list[str]:
    """Names of the nodes of a subtree that are kept, in canonical order."""
    return [each.node.name for each in understanding.kept if each.node.name.partition(".")[0] == subtree]


def deepest_kept(understanding: Understanding, subtree: str) -> Sequence[str]:
    """Those of them that have no kept node below, without the subtree's name."""
    names = nodes_kept(understanding, subtree)
    above = {understanding.tree.node(name).parent for name in names}
    return [name.partition(".")[2] for name in names if name not in above]
