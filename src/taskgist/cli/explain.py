"""``taskgist explain``: what a task means, and why."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.actions import explain_actions
from taskgist.cli.clauses import explain_clauses
from taskgist.cli.common import (
    KNOWLEDGE,
    JsonOption,
    KnowledgeOption,
    RuleOption,
    about,
    command,
    console,
    print_json,
    task_named,
)
from taskgist.cli.contrast import contrast_between, contrast_document, print_contrast
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts.predicates import with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, Node, TreeOf, tree_of
from taskgist.language.phrases import listed
from taskgist.language.sentences import asked, indifference, meaning, why
from taskgist.learning.estimate import Verdict
from taskgist.learning.explanation import Context
from taskgist.learning.task_clauses import BAYES, BY_RULE, RULES, rule_for
from taskgist.learning.understanding import PAPER, Judgement, Understanding, clause_of, questions_of
from taskgist.settings import BANDS, DEFAULT, Learning

if TYPE_CHECKING:  # with MuJoCo
    from taskgist.learning.knowledge import Knowledge

STYLES = {
    Verdict.RELEVANT: "green",
    Verdict.IRRELEVANT: "dim",
    Verdict.CONFUSING: "yellow",
    Verdict.UNOBSERVED: "dim italic",
}


def print_understanding(understanding: Understanding, *, whole_tree: bool = True) -> None:
    """Print the meaning, the clause in the paper's words, the tree with its figures, and open questions."""
    clause = clause_of(understanding)
    count = len(understanding.experience.explanations)
    console.print(Text(meaning(understanding), style="bold"))
    if told := indifference(understanding):
        console.print(told)
    console.print()
    how = f"{BY_RULE[PAPER]}, from {count} demonstration{'s' if count != 1 else ''}"
    console.print(f"{clause.head} ←   {how}")
    for title, literals in (("effects", clause.effects), ("preconditions", clause.preconditions)):
        for number, literal in enumerate(literals):
            console.print(Text(f"  {title if number == 0 else '':14}{literal}"))
    if whole_tree:
        console.print()
        print_tree(understanding)
    for question in questions_of(understanding):
        console.print(Text("question ", style="yellow") + Text(asked(question)))


def print_tree(understanding: Understanding) -> None:
    """Print every node: best value, count, m-estimate Q, consistency factor CF and verdict; kept nodes stand out."""
    rows = [
        row
        for root in understanding.tree.nodes
        if root.parent is None
        for row in _rows(understanding, root, first="", rest="")
    ]
    width = max(len(text) for text, _ in rows)
    console.print(f"{'● node = best value':{width}}  n/N      Q      CF  verdict")
    for text, judgement in rows:
        console.print(Text(f"{text:{width}}  ", style="bold" if judgement.kept else "") + _figures(judgement))
    console.print("●: kept, as it and all above it are relevant; Q: m-estimate of the value; CF: consistency factor")


def _rows(understanding: Understanding, node: Node, *, first: str, rest: str) -> Iterator[tuple[str, Judgement]]:
    """A node and all below it, each as text with its guides, and its judgement."""
    judgement = understanding.judgements[node.name]
    mark = "●" if judgement.kept else "·"
    yield f"{first}{mark} {node.title} = {judgement.value or 'unknown'}", judgement
    children = understanding.tree.children(node.name)
    for child in children:
        last = child is children[-1]
        yield from _rows(
            understanding, child, first=f"{rest}{'└ ' if last else '├ '}", rest=f"{rest}{'  ' if last else '│ '}"
        )


def _figures(judgement: Judgement) -> Text:
    estimate = judgement.estimate
    share = f"{judgement.counts.get(judgement.value or '', 0)}/{estimate.N}"
    numbers = f"{_decimal(estimate.Q):>5}  {_decimal(estimate.CF):>6}" if judgement.counts else " " * 13
    answered = ", by answer" if judgement.answer else ""
    return Text(f"{share:>4}  {numbers}  ") + Text(judgement.verdict.value + answered, STYLES[judgement.verdict])


def _decimal(value: Fraction) -> str:
    return f"{float(value):.3f}"


def understanding_document(understanding: Understanding) -> dict[str, Any]:
    """The same as plain data; fractions are given exactly, as text, and as numbers."""
    clause = clause_of(understanding)
    return {
        "task": understanding.task,
        "of": clause.tree_of,
        "rule": PAPER,
        "meaning": meaning(understanding),
        "indifference": indifference(understanding),
        "demonstrations": [
            {"name": each.demonstration, "digest": each.digest, "source": each.source}
            for each in sorted(
                understanding.experience.explanations.values(), key=lambda e: (e.demonstration, e.digest)
            )
        ],
        "clause": {
            "text": str(clause),
            "effects": [{"node": c.node, "title": c.title, "value": c.value} for c in clause.effects],
            "preconditions": [{"node": c.node, "title": c.title, "value": c.value} for c in clause.preconditions],
            "each_of": list(clause.each_of),
        },
        "nodes": {name: _node_document(judgement) for name, judgement in understanding.judgements.items()},
        "questions": [
            {
                "node": question.node.name,
                "text": asked(question),
                "choices": [
                    {
                        "value": choice.value,
                        "demonstrations": list(choice.demonstrations),
                        "targets": [{"target": who, "demonstration": name} for who, name in choice.targets],
                    }
                    for choice in question.choices
                ],
            }
            for question in questions_of(understanding)
        ],
    }


def _node_document(judgement: Judgement) -> dict[str, Any]:
    estimate = judgement.estimate
    exact = {"Q": estimate.Q, "NRE": estimate.NRE, "CF": estimate.CF, "d1": estimate.d1, "d2": estimate.d2}
    return {
        "title": judgement.node.title,
        "level": judgement.node.level,
        "value": judgement.value,
        "counts": dict(judgement.counts),
        "N": estimate.N,
        **{key: {"exact": str(value), "value": float(value)} for key, value in exact.items()},
        "divided": [each.demonstration for each in judgement.divided],
        "verdict": judgement.verdict.value,
        "kept": judgement.kept,
    }


def understood(
    known: Knowledge,
    where: str,
    task: str,
    tree: HypothesisTree,
    settings: Learning = DEFAULT.learning,
    of: TreeOf = "target",
) -> Understanding:
    """What is known of a task, however its name is spelled; errors name where the knowledge is kept."""
    with about(where, {"of": "--of"}):
        return known.understand(task_named(known, task), tree, settings, of)


@command
def explain(
    task: Annotated[str | None, typer.Argument(help="The task; without one, the known tasks are listed.")] = None,
    knowledge: KnowledgeOption = KNOWLEDGE,
    node: Annotated[str | None, typer.Option("--why", help="Only: why this node counts or not (see.class).")] = None,
    of: Annotated[
        str, typer.Option(help="Whose tree: target (what changes for the target agent) or performer (for itself).")
    ] = "target",
    band: Annotated[
        str | None,
        typer.Option(
            help=f"Confusion band of the paper's rule: {', '.join(BANDS)} (default: {DEFAULT.learning.band})."
        ),
    ] = None,
    rule: RuleOption = None,
    other: Annotated[
        str | None, typer.Option("--contrast", help="Only: what tells the task from this other one.")
    ] = None,
    actions: Annotated[
        bool, typer.Option("--actions", help="Only: what is done in it, in which order (learn --actions).")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Explain what a task means, and why.

    Prints one sentence; the conjunction that the demonstrations have in common, and other tasks and neutral
    manipulations have not; how often each part of it holds here and by chance; what is nearly as good; which
    demonstrations look odd; and what is usual. It learns from the first demonstration on, bears wrong ones, and gets
    better with each further task.

    With --rule paper: what all demonstrations agree in, the tree with each node's figures, and open questions, as in
    Pandey and Alami's paper. So also with --why or --band, and where there is nothing to compare with.

    With --of performer: how it changes what the performing agent can do, where that was learned (learn --of performer).
    A task that is performed for nobody else has that tree alone, which is shown without the option, too.

    With --contrast: what tells the task from another one, as in "why is this a hide, and no put away?": which parts of
    their effects hold in how many of the demonstrations of either, and how much that says.

    Example: taskgist explain give -k knowledge.db

    Example: taskgist explain give --rule paper

    Example: taskgist explain give --of performer

    Example: taskgist explain give --why see.class

    Example: taskgist explain hide --contrast "put away"

    Example: taskgist explain give --actions
    """
    whose = tree_of(of)
    if band is not None and band not in BANDS:
        raise UnknownNameError("band", band, BANDS)
    if rule is not None and rule not in RULES:
        raise UnknownNameError("rule", rule, RULES)
    _check_together(
        task, rule, {"--why": node, "--contrast": other, "--actions": "" if actions else None, "--band": band}
    )
    tree = with_predicates(STANDARD_TREE)
    from taskgist.store.address import shown  # with sqlalchemy, which only knowledge should wait for
    from taskgist.store.database import load

    known = load(knowledge, expected=Context.of(DEFAULT, tree))
    if task is None:
        _list_tasks(known, as_json=as_json)
        return
    if other is not None:
        between = contrast_between(known, shown(knowledge), task, other, tree, whose)
        print_json(contrast_document(between, tree)) if as_json else print_contrast(between, tree)
        return
    if actions:
        explain_actions(known, shown(knowledge), task, whose, as_json=as_json)
        return
    if rule is None and node is None and band is None:
        with about(shown(knowledge), {"of": "--of"}):
            rule = rule_for(known, task_named(known, task), whose)
    if rule == BAYES:
        explain_clauses(known, shown(knowledge), task, tree, whose, as_json=as_json)
        return
    understanding = understood(
        known, shown(knowledge), task, tree, replace(DEFAULT.learning, band=band or DEFAULT.learning.band), whose
    )
    if node is not None:
        sentence = why(understanding, node)
        head = {"task": understanding.task, "of": understanding.experience.tree_of, "rule": PAPER}
        document = {**head, "node": node, "why": sentence}
        print_json(document) if as_json else console.print(f"By the paper's rule: {sentence}")
    elif as_json:
        print_json(understanding_document(understanding))
    else:
        print_understanding(understanding)


def _check_together(task: str | None, rule: str | None, asked: Mapping[str, str | None]) -> None:
    """Refuse options that ask for different things, or for something of no task."""
    wanted = {option: value for option, value in asked.items() if value is not None}
    for option, value in wanted.items():
        if task is None:
            hint = f"taskgist explain TASK {option} {'' if option == '--actions' else 'NAME'}".rstrip()
            raise KnowledgeError("of which task?", field=option, value=value or None, hint=hint)
    answers = [option for option in wanted if option != "--band"]
    if len(answers) > 1:
        first, second, *_ = answers
        hint = f"leave out one of {first} and {second}: each is an answer of its own"
        raise KnowledgeError("asks for something else", field=first, value=wanted[first], hint=hint)
    chosen = {"--rule": rule, "--band": wanted.get("--band")}
    for given, choice in chosen.items():
        if choice is not None and answers and answers != ["--why"]:
            hint = f"leave it out, or {answers[0]}, which no rule decides"
            raise KnowledgeError("makes no difference here", field=given, value=choice, hint=hint)
    for option in ("--why", "--band"):
        if rule == BAYES and option in wanted:
            hint = f"leave out --rule, or {option}: each part of a clause is told with what speaks for it"
            raise KnowledgeError("is about the paper's rule", field=option, value=wanted[option], hint=hint)


def _list_tasks(known: Knowledge, *, as_json: bool) -> None:
    if as_json:
        print_json(list(known.tasks))
        return
    for task in known.tasks:
        told = "   (--of performer, too)" if len(known.trees_of(task)) > 1 else ""
        console.print(f"{task}{told}")
    if not known.tasks:
        wrong = sorted({task for task, _ in known.wrong})
        told = (
            f"only demonstrations that were done wrong are known, of {listed(wrong)}"
            if wrong
            else "nothing learned yet"
        )
        console.print(told)
