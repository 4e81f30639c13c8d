"""Actions: of a recording (``taskgist facts --actions``), and of a task (``taskgist explain --actions``)."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rich.text import Text

from taskgist.cli.clauses import clause_document, compared_document, print_literals
from taskgist.cli.common import about, console, print_json, progress_bar, task_named
from taskgist.facts.tree import TreeOf
from taskgist.language.clauses import by_chance, compared
from taskgist.learning.actions import LearnedActions, learn_actions

if TYPE_CHECKING:  # with numpy and MuJoCo
    from taskgist.learning.knowledge import Knowledge
    from taskgist.recognition.actions import Action
    from taskgist.recording.recording import Recording


def tell_actions(recording: Recording, agent: str | None, name: str | None, *, quiet: bool) -> dict[str, Any]:
    """Print what was done, a line for each action.

    Args:
        recording: The recording.
        agent: Only what this agent did.
        name: Only what was done with this object.
        quiet: Print nothing.

    Returns:
        The document that says the same.

    Raises:
        UnknownNameError: There is no such agent or object.
    """
    from taskgist.observe.observer import Observer
    from taskgist.recognition.actions import actions_of

    if agent is not None:
        recording.scene.agent(agent)
    observer = Observer(recording.scene, recording)
    with progress_bar(quiet=quiet) as progress:
        found = actions_of(recording, observer, names=None if name is None else (name,), progress=progress)
    own = [each for each in found if agent in (None, each.agent)]
    if not quiet:
        for each in own:
            console.print(Text(f"  {_when(each):>17}  {each}"))
        if not own:
            console.print("nothing that could be told: was nothing done, or were hands and things not tracked?")
    return {"actions": [_document(each) for each in own]}


def _when(action: Action) -> str:
    if action.start_s == action.end_s:
        return f"{action.start_s:6.2f} s"
    return f"{action.start_s:6.2f} - {action.end_s:6.2f} s"


def _document(action: Action) -> dict[str, Any]:
    times = {"start_s": round(action.start_s, 4), "end_s": round(action.end_s, 4)}
    return {**asdict(action), **times}


def explain_actions(known: Knowledge, where: str, task: str, of: TreeOf, *, as_json: bool) -> None:
    """Print what is done in a task, however it is spelled; errors name where the knowledge is kept."""
    with about(where, {"of": "--of"}):
        learned = learn_actions(known, task_named(known, task), of)
    if as_json:
        print_json(_learned_document(learned, known.experience(learned.posterior.task, of).tree_of))
        return
    posterior = learned.posterior
    console.print(Text(f"What is done in a {posterior.task!r}, {compared(posterior)}", style="bold"))
    k, n = learned.support
    chance = "" if learned.chance is None else f"; by chance in {by_chance(learned.chance)}"
    order = "in this order" if k else "done in most, each by itself; in this order"
    console.print(f"{order}, in {k} of {n}{chance}:")
    for number, name in enumerate(learned.sequence, start=1):
        console.print(f"  {number}. {name}")
    if posterior.best.literals:
        sure = posterior.best.score > 0.0
        console.print(f"what other tasks have {'not' if sure else 'less often, which may be chance'}:")
        print_literals(posterior.alone)


def _learned_document(learned: LearnedActions, of: TreeOf) -> dict[str, Any]:
    k, n = learned.support
    posterior = learned.posterior
    return {
        "task": posterior.task,
        "of": of,
        "actions": {"sequence": list(learned.sequence), "k": k, "n": n, "chance": learned.chance},
        "compared": compared_document(posterior),
        "clause": clause_document(posterior),
    }
