"""Eq. 36-42: the learned clauses beside the paper's, predicate by predicate."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from taskgist.facts import STANDARD_TREE
from taskgist.learning import Clause, clause_of
from taskgist.study.paper.demonstrations import Judged, understanding_of
from taskgist.study.paper.published import CLAUSES, SHORT_SHOW, Published, PublishedClause
from taskgist.study.paper.result import Result, Section, Verdict

ABSENT = None
"""Our value of a predicate that the learned clause does not have."""
ABOUT = (
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
    return Section("clauses", "The clauses, predicate by predicate (Eq. 36-42)", tuple(results), ABOUT)


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
