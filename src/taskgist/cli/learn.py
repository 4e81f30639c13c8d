"""``taskgist learn``: demonstrations into a knowledge file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.common import (
    KNOWLEDGE,
    JsonOption,
    KnowledgeOption,
    about,
    check_target,
    command,
    console,
    print_json,
    progress_bar,
    read_all,
)
from taskgist.cli.explain import print_understanding, understanding_document
from taskgist.errors import KnowledgeError, RecordingError
from taskgist.facts.elsewhere import read_facts
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.explanation import Context, Explanation, explain
from taskgist.learning.knowledge import Knowledge
from taskgist.pipeline.explain import explain_all, label_of
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT


@command
def learn(
    demonstrations: Annotated[
        list[Path] | None,
        typer.Argument(help="Labelled recordings (.mcap), folders of them, or files of facts from elsewhere (.json)."),
    ] = None,
    knowledge: KnowledgeOption = KNOWLEDGE,
    replace: Annotated[
        bool, typer.Option("--replace", help="Forget what a recording taught under another label or other times.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Learn what tasks mean from labelled demonstrations.

    They are added to what the knowledge file holds; one that it knows already changes nothing.

    A recording that was learned from with another label is refused, unless --replace says to forget that.

    Example: taskgist learn give_1.mcap give_2.mcap -k knowledge.db

    Example: taskgist learn facts.json
    """
    if not demonstrations:
        raise RecordingError(
            "no demonstrations to learn from", hint="name at least one labelled recording or facts file"
        )
    predicates = known_predicates()
    tree = with_predicates(STANDARD_TREE, predicates)
    _check_knowledge(knowledge, tree)
    explanations = [_from_facts(path, tree) for path in demonstrations if path.suffix == ".json"]
    recordings = _labelled([path for path in demonstrations if path.suffix != ".json"])
    if recordings:
        with progress_bar(quiet=as_json) as progress:
            explanations += explain_all(recordings, predicates=predicates, progress=progress)
    known = _kept(knowledge, explanations, replace=replace)
    tasks = sorted({explanation.task for explanation in explanations})
    if as_json:
        learned = {task: understanding_document(known.understand(task, tree)) for task in tasks}
        print_json({"knowledge": str(knowledge), "tasks": learned})
        return
    for task in tasks:
        print_understanding(known.understand(task, tree), whole_tree=False)
        console.print()
    console.print(f"kept in {knowledge}; for the whole tree: taskgist explain TASK -k {knowledge}")


def _check_knowledge(knowledge: str, tree: HypothesisTree) -> None:
    """Refuse knowledge that cannot be added to before the long work, not after it."""
    from taskgist.store.database import file_of, load, update  # with sqlalchemy, which only knowledge should wait for

    path = file_of(knowledge)
    if path is None:
        update(knowledge)
    elif path.is_file():
        load(knowledge, expected=Context.of(DEFAULT, tree))
    else:
        check_target(path, "--knowledge", replace=True)


def _kept(knowledge: str, explanations: list[Explanation], *, replace: bool) -> Knowledge:
    """Add to the knowledge; nobody is counted twice because a label was moved.

    Raises:
        KnowledgeError: A recording was learned from already, with another label.
    """
    from taskgist.store.database import update

    known = update(knowledge)
    older = [each for explanation in explanations for each in known.rivals(explanation)]
    if older and not replace:
        raise KnowledgeError(
            "was learned from already, with another label",
            where=older[0].demonstration,
            field="source",
            value=older[0].source,
            hint="add --replace to forget that",
        )
    return update(knowledge, explanations, forget=[each.digest for each in older])


def _labelled(paths: list[Path]) -> list[Recording]:
    recordings = read_all(paths)
    for path, recording in recordings.items():
        with about(path):
            label_of(recording)
    return list(recordings.values())


def _from_facts(path: Path, tree: HypothesisTree) -> Explanation:
    return explain(read_facts(path, tree), tree, DEFAULT)
