"""``taskgist learn``: demonstrations into a knowledge file."""

from __future__ import annotations

import shlex
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from taskgist.cli.common import (
    KNOWLEDGE,
    JsonOption,
    KnowledgeOption,
    about,
    command,
    console,
    print_json,
    progress_bar,
    read_all,
)
from taskgist.cli.explain import print_understanding, understanding_document
from taskgist.common.files import reading
from taskgist.errors import FactsError, InputError, KnowledgeError, RecordingError
from taskgist.facts.elsewhere import read_facts
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, TreeOf, tree_of
from taskgist.learning.explanation import Context, Explanation, explain
from taskgist.learning.knowledge import Knowledge
from taskgist.settings import DEFAULT

if TYPE_CHECKING:  # recordings bring numpy and MuJoCo, which facts from elsewhere do without
    from taskgist.recording.recording import Recording


@command
def learn(
    demonstrations: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Labelled recordings (.mcap), folders of them, files of facts from elsewhere (.json), "
            "or other knowledge files."
        ),
    ] = None,
    knowledge: KnowledgeOption = KNOWLEDGE,
    replace: Annotated[
        bool, typer.Option("--replace", help="Forget what a recording taught under another label or other times.")
    ] = False,
    of: Annotated[
        str, typer.Option(help="What they mean for whom: target, or performer (the performing agent's own tree).")
    ] = "target",
    wrong: Annotated[
        bool, typer.Option("--wrong", help="They show how their tasks must not be done: what must not hold is learned.")
    ] = False,
    actions: Annotated[
        bool,
        typer.Option("--actions", help="Learn from recordings what is done, and in which order, too; takes longer."),
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Learn what tasks mean from labelled demonstrations.

    They are added to what the knowledge file holds; one that it knows already changes nothing.

    A recording that was learned from with another label, or as done wrong, is refused, unless --replace says to forget
    that. What was explained until something fails is kept in a knowledge file of its own, to go on from.

    With --of performer: how the agent that performs prefers to do it, from its own reach, sight, hands and posture.
    That is kept in the same file, apart from what the task means for its target agents: one does not count for the
    other.

    Example: taskgist learn give_1.mcap give_2.mcap -k knowledge.db

    Example: taskgist learn give_1.mcap give_2.mcap --of performer

    With --wrong: demonstrations that somebody did wrong, with the label of what it should have been. They never count
    for the task. What they have in common, and right ones do not, is told as "must not" by explain TASK --rule bayes.

    With --actions: also what was done, such as reach, grasp, carry, hand over. That changes nothing of what the task
    means; explain TASK --actions tells it.

    Example: taskgist learn facts.json

    Example: taskgist learn --wrong spilled_1.mcap -k knowledge.db
    """
    whose = tree_of(of)
    if not demonstrations:
        raise RecordingError(
            "no demonstrations to learn from", hint="name at least one labelled recording or facts file"
        )
    from taskgist.store.address import shown  # with sqlalchemy, which only knowledge should wait for
    from taskgist.store.database import check, load, update

    predicates = known_predicates()
    tree = with_predicates(STANDARD_TREE, predicates)
    context = Context.of(DEFAULT, tree)
    check(knowledge, expected=context)
    databases = [path for path in demonstrations if _is_knowledge(path)]
    if wrong and databases:
        problem = "a knowledge file says itself which of its demonstrations were done wrong"
        raise KnowledgeError(problem, where=databases[0], field="--wrong", hint="learn from it without --wrong")
    stored = {path: load(path, expected=context) for path in databases}
    facts = {path: _from_facts(path, tree, whose) for path in demonstrations if path.suffix == ".json"}
    if wrong:
        facts = {path: each.marked_wrong() for path, each in facts.items()}
    recordings = _labelled([path for path in demonstrations if path.suffix != ".json" and path not in databases])
    named = [*_announced(recordings, whose, wrong=wrong), *facts.items()]
    named += [(path, each) for path, known in stored.items() for each in known.explanations]
    check(
        knowledge,
        added=[each for _, each in named],
        relabelled="replace" if replace else "refuse",
        names={each.digest: str(path) for path, each in named},
    )
    others, explanations = reduce(Knowledge.merge, stored.values(), Knowledge()), [*facts.values()]
    with _kept(others, explanations, knowledge):
        if recordings:
            from taskgist.pipeline.explain import explain_all

            with progress_bar(quiet=as_json) as progress:
                explained = explain_all(
                    recordings.values(), of=whose, predicates=predicates, actions=actions, progress=progress
                )
                explanations.extend(each.marked_wrong() if wrong else each for each in explained)
        added = others.add(*explanations)
        check(knowledge, tasks={each.task for each in added.explanations})  # all of them are shown afterwards
        update(knowledge, added.explanations, added.answers, relabelled="replace" if replace else "refuse")
    tasks = sorted({each.task for each in added.explanations})
    known = load(knowledge, tasks=tasks)
    done_wrong = {task: _wrong_of(known, task) for task in tasks}
    learned = {
        task: known.understand(task, tree, of=_shown_of(added if task in added.tasks else known, task, whose))
        for task in known.tasks
    }
    if as_json:
        documents = {task: understanding_document(each) for task, each in learned.items()}
        found = {task: count for task, count in done_wrong.items() if count}
        print_json({"knowledge": shown(knowledge), "tasks": documents, "wrong": found})
        return
    for each in learned.values():
        print_understanding(each, whole_tree=False)
        console.print()
    for task, count in done_wrong.items():
        if count:
            told = f"taskgist explain {shlex.quote(task)} --rule bayes -k {shown(knowledge)}"
            how = f"what must not hold: {told}" if task in known.tasks else "none that was done right is known yet"
            console.print(f"{task}: {count} demonstration{'s' * (count != 1)} done wrong; {how}")
    options = f"-k {shown(knowledge)}{' --of performer' if whose == 'performer' else ''}"
    console.print(f"kept in {shown(knowledge)}; compared with all else: taskgist explain TASK {options}")
    console.print("with --rule paper: the whole tree with its figures")


@contextmanager
def _kept(others: Knowledge, explanations: list[Explanation], knowledge: str) -> Iterator[None]:
    """If something is refused, keep what was explained, and was to be added with it, and say how to go on from it."""
    from taskgist.store.address import shown

    try:
        yield
    except InputError as error:
        path = _keep(others, explanations, knowledge) if explanations else None
        if path is not None:
            again = shlex.join(["taskgist", "learn", str(path), "-k", shown(knowledge)])
            told = f"what was explained is kept, to go on from: {again}"
            error.hint = f"{error.hint}; {told}" if error.hint else told
        raise


def _keep(others: Knowledge, explanations: list[Explanation], knowledge: str) -> Path | None:
    """A new knowledge file with these: beside the knowledge, else here, else among temporary files; None if nowhere."""
    from taskgist.store.address import file_of
    from taskgist.store.database import create

    path = file_of(knowledge)
    stem = path.stem if path else "knowledge"
    for folder in ([path.parent] if path else []) + [Path(), Path(tempfile.gettempdir())]:
        with suppress(InputError):
            for number in range(1, 1000):
                kept = folder / f"{stem}.explained{f'-{number}' if number > 1 else ''}.db"
                if create(kept, others.add(*explanations)):
                    return kept
    return None


def _is_knowledge(path: Path) -> bool:
    """Whether a file is a database, by its first bytes; what cannot be read is told by who needs it."""
    with suppress(KnowledgeError), reading(path, error=KnowledgeError) as stream:
        return stream.read(16) == b"SQLite format 3\0"
    return False


def _labelled(paths: list[Path]) -> dict[Path, Recording]:
    if not paths:
        return {}
    from taskgist.pipeline.explain import label_of

    recordings = read_all(paths)
    for path, recording in recordings.items():
        with about(path):
            label_of(recording)
    return recordings


def _announced(recordings: dict[Path, Recording], of: TreeOf, *, wrong: bool) -> list[tuple[Path, Explanation]]:
    """Recordings, each with what its explanation will be told by."""
    if not recordings:
        return []
    from taskgist.pipeline.explain import announced

    found = {path: announced(recording, of=of) for path, recording in recordings.items()}
    return [(path, each.marked_wrong() if wrong else each) for path, each in found.items()]


def _from_facts(path: Path, tree: HypothesisTree, of: TreeOf) -> Explanation:
    """The explanation of facts from elsewhere, which are those of the target agent.

    Raises:
        FactsError: Another agent's are asked for.
    """
    episode = read_facts(path, tree)
    if of == "performer":
        problem = f"its facts are those of the target agent, {episode.target_agent}"
        raise FactsError(problem, where=path, field="--of", value=of, hint="learn from it without --of")
    return explain(episode, tree, DEFAULT)


def _wrong_of(known: Knowledge, task: str) -> int:
    """How many demonstrations of a task were done wrong."""
    return sum(len(each.explanations) for (name, _), each in known.wrong.items() if name == task)


def _shown_of(added: Knowledge, task: str, of: TreeOf) -> TreeOf:
    """Which of a task's trees to show after learning: that which was asked for, if something was added to it."""
    known = added.trees_of(task)
    return of if of in known else known[0]
