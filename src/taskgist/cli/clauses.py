"""``taskgist explain``: what a task means by whole clauses, compared with all else that is known."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

from rich.text import Text

from taskgist.cli.common import about, console, print_json, task_named
from taskgist.facts.tree import HypothesisTree, TreeOf
from taskgist.language.asking import against_all, answer_text
from taskgist.language.clauses import against, compared, oddness, supported
from taskgist.language.sentences import clause_meaning
from taskgist.learning.answers import Answer
from taskgist.learning.background import NEUTRAL
from taskgist.learning.clauses import ClausePosterior, LiteralSupport, MustNot, Support, WeighedClause
from taskgist.learning.task_clauses import (
    BAYES,
    BY_RULE,
    WRONG,
    Odd,
    answers_against_all,
    clause_of_posterior,
    learn_task,
    odd_demonstrations,
)
from taskgist.learning.understanding import literal_to_json

if TYPE_CHECKING:  # with MuJoCo
    from taskgist.learning.knowledge import Knowledge

ALTERNATIVES, NEARLY = 3, 0.5
"""Further clauses that are told, at most; and their posterior probability as a share of the best one's, at least."""


def explain_clauses(
    known: Knowledge, where: str, task: str, tree: HypothesisTree, of: TreeOf, *, as_json: bool
) -> None:
    """Print what a task means by whole clauses, however it is spelled; errors name where the knowledge is kept."""
    with about(where, {"of": "--of"}):
        learned = learn_task(known, task_named(known, task), tree, of)
    odd = odd_demonstrations(known, learned, tree, of)
    own = known.experience(learned.task, of)
    contrary = answers_against_all(known, own.task, tree, own.tree_of)
    meaning = clause_meaning(clause_of_posterior(own, learned, tree), tree)
    if as_json:
        print_json(clauses_document(learned, meaning, odd, contrary, own.tree_of))
        return
    doubts = ("odd demonstrations", [oddness(each) for each in odd])
    if contrary:
        title = f"what was answered {against_all(len(own.explanations))}"
        doubts = (title, [answer_text(each, tree) for each in contrary])
    print_clauses(learned, meaning, doubts, own.tree_of, where)
    if not learned.must_not and (wrong := known.wrong.get((own.task, own.tree_of))):
        count = len(wrong.explanations)
        told, them = f"{count} demonstration{'s' * (count != 1)} done wrong", "it" if count == 1 else "them"
        console.print(f"{told}: what sets {them} apart from right ones may still be chance, so nothing is told of it")


def print_clauses(
    learned: ClausePosterior, meaning: str, doubts: tuple[str, list[str]], of: TreeOf, where: str
) -> None:
    """Print what the best clause says, what speaks for each literal, alternatives, doubts, circumstances, ways on."""
    best = learned.best
    if best.literals:
        console.print(Text(meaning, style="bold"))
        console.print()
    whose = ", for the performing agent" if of == "performer" else ""
    console.print(Text(f"Task({learned.task}{whose}) ←   {BY_RULE[BAYES]}, {compared(learned)}"))
    print_literals(learned.alone)
    if not learned.compared:
        console.print(
            "  learn another task, to compare it with; or let the paper's rule speak, which compares with nothing"
        )
    elif len(best.literals) != 1:
        console.print(f"  {'together' if best.literals else 'nothing in common'}: {supported(best.support)}")
    for title, lines in (
        ("must not", [f"{each.literal}   {against(each)}" for each in learned.must_not]),
        ("nearly as good", [f"{each}   {supported(each.support)}" for each in alternatives(learned)]),
        doubts,
    ):
        if lines:
            console.print(f"{title}:")
            for line in lines:
                console.print(Text(f"  {line}"))
    for title, literals in (
        ("usual circumstances, which were always so but usually are", learned.usual),
        ("always so as well, but not in the clause", learned.always),
    ):
        if literals and learned.compared:
            console.print(f"{title}:")
            print_literals(literals)
    options = f"-k {where}{' --of performer' if of == 'performer' else ''}"
    console.print(f"what it leaves open: taskgist ask {shlex.quote(learned.task)} {options}")
    console.print("with --rule paper: what all demonstrations agree in, and the whole tree with its figures")


def print_literals(literals: tuple[LiteralSupport, ...]) -> None:
    """Print literals, each with what speaks for it."""
    width = max((len(str(each.literal)) for each in literals), default=0)
    for each in literals:
        console.print(Text(f"  {each.literal!s:{width}}   {supported(each.support)}"))


def alternatives(learned: ClausePosterior) -> tuple[WeighedClause, ...]:
    """The clauses that are nearly as good as the best one."""
    first, *others = learned.clauses
    return tuple(each for each in others if each.weight >= NEARLY * first.weight)[:ALTERNATIVES]


def clauses_document(
    learned: ClausePosterior, meaning: str, odd: tuple[Odd, ...], contrary: tuple[Answer, ...], of: TreeOf
) -> dict[str, Any]:
    """The same as plain data."""
    return {
        "task": learned.task,
        "of": of,
        "rule": BAYES,
        "meaning": meaning,
        "clause": clause_document(learned),
        "alternatives": [_clause(each) for each in alternatives(learned)],
        "usual": [_literal(each) for each in learned.usual],
        "always": [_literal(each) for each in learned.always],
        "must_not": [_must_not(each) for each in learned.must_not],
        "compared": compared_document(learned),
        "odd": [
            {
                "name": each.explanation.demonstration,
                "digest": each.explanation.digest,
                "probability": each.probability,
                "looks_like": list(each.looks_like),
            }
            for each in odd
        ],
        "against_all": [answer_document(each) for each in contrary],
    }


def clause_document(learned: ClausePosterior) -> dict[str, Any]:
    """The best clause, and what speaks for each of its literals."""
    return {**_clause(learned.best), "literals": [_literal(each) for each in learned.alone]}


def compared_document(learned: ClausePosterior) -> dict[str, Any]:
    """What a task was compared with: how many demonstrations of which tasks, and neutral manipulations by kind."""
    compared = {name: n for name, n in sorted(learned.compared.items()) if name != WRONG}
    return {
        "tasks": {name: n for name, n in compared.items() if not name.startswith(NEUTRAL)},
        "neutral": {name.removeprefix(NEUTRAL): n for name, n in compared.items() if name.startswith(NEUTRAL)},
    }


def answer_document(answer: Answer) -> dict[str, Any]:
    """What somebody said of a task."""
    said = answer.reply or answer.verdict
    return {
        "question": answer.about,
        "answer": said.value if said else None,
        "value": answer.value,
        "author": answer.author,
        "time": answer.time,
    }


def _clause(clause: WeighedClause) -> dict[str, Any]:
    return {"text": str(clause), **_support(clause.support), "score": clause.score, "probability": clause.weight}


def _literal(each: LiteralSupport) -> dict[str, Any]:
    return {**literal_to_json(each.literal), **_support(each.support)}


def _must_not(each: MustNot) -> dict[str, Any]:
    counts = {name: {"k": k, "n": n} for name, (k, n) in (("wrong", each.in_wrong), ("right", each.in_right))}
    return {**literal_to_json(each.literal), **counts, "odds": each.odds}


def _support(support: Support) -> dict[str, Any]:
    return {"k": support.k, "n": support.n, "chance": support.chance}
