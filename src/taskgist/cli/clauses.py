"""``taskgist explain --rule bayes``: what a task means by whole clauses, compared with all else that is known."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.text import Text

from taskgist.cli.common import about, console, print_json
from taskgist.common.text import clean_name
from taskgist.facts.tree import HypothesisTree, TreeOf
from taskgist.language.clauses import compared, oddness, supported
from taskgist.learning.background import NEUTRAL
from taskgist.learning.clauses import ClausePosterior, LiteralSupport, Support, WeighedClause
from taskgist.learning.literals import SetLiteral
from taskgist.learning.task_clauses import Odd, learn_task, odd_demonstrations

if TYPE_CHECKING:  # with MuJoCo
    from taskgist.learning.knowledge import Knowledge

ALTERNATIVES, NEARLY = 3, 0.5
"""Further clauses that are told, at most; and their posterior probability as a share of the best one's, at least."""


def explain_clauses(
    known: Knowledge, where: str, task: str, tree: HypothesisTree, of: TreeOf, *, as_json: bool
) -> None:
    """Print what a task means by whole clauses, however it is spelled; errors name where the knowledge is kept."""
    with about(where, {"of": "--of"}):
        learned = learn_task(known, task if task in known.tasks else clean_name(task), tree, of)
    odd = odd_demonstrations(known, learned, tree, of)
    whose = known.experience(learned.task, of).tree_of
    if as_json:
        print_json(clauses_document(learned, odd, whose))
    else:
        print_clauses(learned, odd, whose)


def print_clauses(learned: ClausePosterior, odd: tuple[Odd, ...], of: TreeOf) -> None:
    """Print the best clause with what speaks for each literal, its alternatives, usual circumstances, odd ones."""
    best = learned.best
    whose = ", for the performing agent" if of == "performer" else ""
    console.print(Text(f"Task({learned.task}{whose}) ←   by whole clauses, {compared(learned)}", style="bold"))
    _print_literals(learned.alone)
    if len(best.literals) != 1:
        console.print(f"  {'together' if best.literals else 'nothing in common'}: {supported(best.support)}")
    for title, lines in (
        ("nearly as good", [f"{each}   {supported(each.support)}" for each in alternatives(learned)]),
        ("odd demonstrations", [oddness(each) for each in odd]),
    ):
        if lines:
            console.print(f"{title}:")
            for line in lines:
                console.print(Text(f"  {line}"))
    if learned.usual:
        console.print("usual circumstances, which were always so but usually are:")
        _print_literals(learned.usual)


def _print_literals(literals: tuple[LiteralSupport, ...]) -> None:
    width = max((len(str(each.literal)) for each in literals), default=0)
    for each in literals:
        console.print(Text(f"  {each.literal!s:{width}}   {supported(each.support)}"))


def alternatives(learned: ClausePosterior) -> tuple[WeighedClause, ...]:
    """The clauses that are nearly as good as the best one."""
    first, *others = learned.clauses
    return tuple(each for each in others if each.weight >= NEARLY * first.weight)[:ALTERNATIVES]


def clauses_document(learned: ClausePosterior, odd: tuple[Odd, ...], of: TreeOf) -> dict[str, Any]:
    """The same as plain data."""
    return {
        "task": learned.task,
        "of": of,
        "rule": "bayes",
        "clause": {**_clause(learned.best), "literals": [_literal(each) for each in learned.alone]},
        "alternatives": [_clause(each) for each in alternatives(learned)],
        "usual": [_literal(each) for each in learned.usual],
        "compared": {
            "tasks": {name: n for name, n in sorted(learned.compared.items()) if not name.startswith(NEUTRAL)},
            "neutral": {
                name.removeprefix(NEUTRAL): n
                for name, n in sorted(learned.compared.items())
                if name.startswith(NEUTRAL)
            },
        },
        "odd": [
            {
                "name": each.explanation.demonstration,
                "digest": each.explanation.digest,
                "probability": each.probability,
                "looks_like": list(each.looks_like),
            }
            for each in odd
        ],
    }


def _clause(clause: WeighedClause) -> dict[str, Any]:
    return {"text": str(clause), **_support(clause.support), "score": clause.score, "probability": clause.weight}


def _literal(each: LiteralSupport) -> dict[str, Any]:
    return {**literal_document(each.literal), **_support(each.support)}


def literal_document(literal: SetLiteral) -> dict[str, Any]:
    """A literal: its node, how it is told, and its values."""
    named = {"node": literal.node, "title": literal.title, "text": str(literal)}
    return {**named, "values": list(literal.values), "but": literal.but}


def _support(support: Support) -> dict[str, Any]:
    return {"k": support.k, "n": support.n, "chance": support.chance}
