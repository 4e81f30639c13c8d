"""How an understanding is printed: clause, tree, meaning, questions; and the same as JSON."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from rich.tree import Tree

from taskgist.cli.output import console
from taskgist.facts import Node
from taskgist.language import asked, indifference, meaning
from taskgist.learning import Judgement, Understanding, Verdict, clause_of, questions_of

TREE_WIDTH = 200
"""Columns of the printed tree: the same in every terminal, so that no figure is cut off."""
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
    console.print(f"[bold]{meaning(understanding)}[/]")
    console.print(indifference(understanding))
    console.print()
    console.print(f"Task({clause.task}) ←   learned from {count} demonstration{'s' if count != 1 else ''}")
    for title, literals in (("effects", clause.effects), ("preconditions", clause.preconditions)):
        for number, literal in enumerate(literals):
            console.print(f"  {title if number == 0 else '':14}{literal}")
    if whole_tree:
        console.print()
        print_tree(understanding)
    for question in questions_of(understanding):
        console.print(f"[yellow]question[/] {asked(question)}")


def print_tree(understanding: Understanding) -> None:
    """Print every node: best value, count, m-estimate Q, consistency factor CF and verdict; kept nodes stand out."""
    console.print("node = best value   n/N  Q: m-estimate  CF: consistency factor  verdict (●: kept)")
    for root in (node for node in understanding.tree.nodes if node.parent is None):
        console.print(_branch(understanding, root), width=TREE_WIDTH, no_wrap=True, crop=False)


def _branch(understanding: Understanding, node: Node) -> Tree:
    tree = Tree(_line(understanding.judgements[node.name]), guide_style="dim")
    for child in understanding.tree.children(node.name):
        tree.add(_branch(understanding, child))
    return tree


def _line(judgement: Judgement) -> str:
    estimate, style = judgement.estimate, STYLES[judgement.verdict]
    mark = "●" if judgement.kept else " "
    value = (judgement.value or "unknown").replace("[", r"\[")
    figures = f"{judgement.counts.get(judgement.value or '', 0)}/{estimate.N}"
    if judgement.counts:
        figures += f"  Q={_decimal(estimate.Q)} CF={_decimal(estimate.CF)}"
    title = f"[bold]{judgement.node.title}[/]" if judgement.kept else judgement.node.title
    answered = " (answered)" if judgement.answer else ""
    return f"{mark} {title} = {value}  {figures}  [{style}]{judgement.verdict.value}{answered}[/]"


def _decimal(value: Fraction) -> str:
    return f"{float(value):.3f}"


def understanding_document(understanding: Understanding) -> dict[str, Any]:
    """The same as plain data; fractions are given exactly, as text, and as numbers."""
    clause = clause_of(understanding)
    return {
        "task": understanding.task,
        "meaning": meaning(understanding),
        "indifference": indifference(understanding),
        "demonstrations": [
            {"name": each.demonstration, "digest": each.digest, "source": each.source}
            for each in understanding.experience.explanations.values()
        ],
        "clause": {
            "text": str(clause),
            "effects": [{"node": c.node, "title": c.title, "value": c.value} for c in clause.effects],
            "preconditions": [{"node": c.node, "title": c.title, "value": c.value} for c in clause.preconditions],
        },
        "nodes": {name: _node_document(judgement) for name, judgement in understanding.judgements.items()},
        "questions": [
            {
                "node": question.node.name,
                "text": asked(question),
                "choices": [{"value": c.value, "demonstrations": list(c.demonstrations)} for c in question.choices],
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
        "verdict": judgement.verdict.value,
        "kept": judgement.kept,
    }
