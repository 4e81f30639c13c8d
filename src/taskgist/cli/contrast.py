"""What tells one known task from another: ``taskgist explain TASK --contrast OTHER``, ``recognise --contrast A,B``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.text import Text

from taskgist.cli.common import about, console, task_named
from taskgist.errors import KnowledgeError
from taskgist.facts.tree import HypothesisTree, Nodes, TreeOf
from taskgist.facts.values import UNKNOWN, Unknown
from taskgist.language.clauses import contrasted_reason, decided, likelier, weighed_reason
from taskgist.language.phrases import phrase_of
from taskgist.learning.contrast import Contrast, Contrasted, contrast_of
from taskgist.learning.understanding import literal_to_json

if TYPE_CHECKING:  # with MuJoCo
    from taskgist.learning.knowledge import Knowledge


def contrast_between(
    known: Knowledge, where: str, first: str, second: str, tree: HypothesisTree, of: TreeOf
) -> Contrast:
    """What tells two tasks apart, however they are spelled; errors name where the knowledge is kept.

    Raises:
        UnknownNameError: One of them is not known.
        KnowledgeError: They are the same, or not known in the trees of the same agents.
    """
    with about(where, {"contrast": "--contrast", "of": "--of"}):
        return contrast_of(known, task_named(known, first), task_named(known, second), tree, of)


def two_tasks(names: str) -> tuple[str, str]:
    """The names in ``"hide,put away"``.

    Raises:
        KnowledgeError: These are not two.
    """
    tasks = [name.strip() for name in names.split(",")]
    if len(tasks) != 2 or not all(tasks):
        hint = 'give two, with a comma between them: --contrast "hide,put away"'
        raise KnowledgeError("not two tasks", field="--contrast", value=names, hint=hint)
    return tasks[0], tasks[1]


def print_contrast(between: Contrast, tree: HypothesisTree) -> None:
    """Print what tells two tasks apart, in their demonstrations."""
    console.print(Text(f"{between.first} or {between.second}?", "bold"))
    for each in between.literals:
        console.print(Text(f"  {contrasted_reason(each, between)}"))
        console.print(Text(f"    {phrase_of(tree.node(each.literal.node), each.literal)}", "italic"))
        for told in likelier(each, between):
            console.print(Text(f"    {told}"))
    if not between.literals:
        console.print("nothing that is known tells them apart: their demonstrations do not differ")


def print_contrast_in(between: Contrast, nodes: Nodes, tree: HypothesisTree) -> None:
    """Print which of two tasks an episode is the more like, and what decides that."""
    weighed = between.weigh(nodes)
    console.print(Text(f"{between.first} or {between.second}? {decided(between, weighed, tree)}", "bold"))
    for each in weighed:
        console.print(Text(f"  {weighed_reason(each, between)}"))


def contrast_document(between: Contrast, tree: HypothesisTree) -> dict[str, Any]:
    """What tells two tasks apart, as plain data."""
    return {
        "first": between.first,
        "second": between.second,
        "of": between.of,
        "literals": [
            {**_literal(each, tree), "weight_if_holds": each.weight(True), "weight_if_fails": each.weight(False)}
            for each in between.literals
        ],
    }


def contrast_document_in(between: Contrast, nodes: Nodes, tree: HypothesisTree) -> dict[str, Any]:
    """Which of two tasks an episode is the more like, as plain data."""
    weighed = between.weigh(nodes)
    return {
        "first": between.first,
        "second": between.second,
        "decided": decided(between, weighed, tree),
        "literals": [
            {**_literal(each.contrasted, tree), "holds": truth(each.holds), "weight": each.weight} for each in weighed
        ],
    }


def _literal(each: Contrasted, tree: HypothesisTree) -> dict[str, Any]:
    counts = {"in_first": each.first, "in_second": each.second}
    return {
        **literal_to_json(each.literal),
        "plainly": phrase_of(tree.node(each.literal.node), each.literal),
        **{name: dict(zip(("k", "n"), count, strict=True)) for name, count in counts.items()},
    }


def truth(holds: bool | Unknown) -> bool | None:
    """Whether something holds, as JSON says it."""
    return None if holds is UNKNOWN else bool(holds)
