"""``taskgist explain``: what a task means, and why."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated

import typer

from taskgist.cli.files import KNOWLEDGE, KnowledgeOption, about
from taskgist.cli.output import JsonOption, command, console, print_json
from taskgist.cli.understanding import print_understanding, understanding_document
from taskgist.errors import KnowledgeError, UnknownNameError
from taskgist.facts import STANDARD_TREE, with_predicates
from taskgist.language import why
from taskgist.learning import Context
from taskgist.settings import BANDS, DEFAULT


@command
def explain(
    task: Annotated[str | None, typer.Argument(help="The task; without one, the known tasks are listed.")] = None,
    knowledge: KnowledgeOption = KNOWLEDGE,
    node: Annotated[str | None, typer.Option("--why", help="Only: why this node counts or not (see.class).")] = None,
    band: Annotated[str, typer.Option(help=f"Confusion band: {', '.join(BANDS)}.")] = DEFAULT.learning.band,
    as_json: JsonOption = False,
) -> None:
    """Explain what a task means, and why.

    Prints one sentence, the clause, the tree with each node's figures, and open questions.

    Example: taskgist explain give -k knowledge.db

    Example: taskgist explain give --why see.class
    """
    if band not in BANDS:
        raise UnknownNameError("band", band, BANDS)
    tree = with_predicates(STANDARD_TREE)
    from taskgist.store import load  # with sqlalchemy, which only knowledge should wait for

    if node is not None and task is None:
        raise KnowledgeError("of which task?", field="--why", value=node, hint="taskgist explain TASK --why NODE")
    known = load(knowledge, expected=Context.of(DEFAULT, tree))
    if task is None:
        _list_tasks(known.tasks, as_json=as_json)
        return
    with about(knowledge):
        understanding = known.understand(task, tree, replace(DEFAULT.learning, band=band))
    if node is not None:
        sentence = why(understanding, node)
        print_json({"task": task, "node": node, "why": sentence}) if as_json else console.print(sentence)
    elif as_json:
        print_json(understanding_document(understanding))
    else:
        print_understanding(understanding)


def _list_tasks(tasks: tuple[str, ...], *, as_json: bool) -> None:
    if as_json:
        print_json(list(tasks))
    else:
        console.print("\n".join(tasks) or "nothing learned yet")
