"""``taskgist recognise``: which of the known tasks was performed in a recording?"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import (
    FAILED,
    KNOWLEDGE,
    OK,
    JsonOption,
    KnowledgeOption,
    RecordingsArgument,
    about,
    command,
    console,
    print_json,
    print_left_out,
    progress_bar,
)
from taskgist.cli.contrast import contrast_between, contrast_document_in, print_contrast_in, truth, two_tasks
from taskgist.cli.episodes import foresee_at, print_list
from taskgist.cli.found import files
from taskgist.cli.many import Outcome, Refused, exit_code, one_by_one, print_table
from taskgist.common.text import one_or_list
from taskgist.common.workers import Progress, silent
from taskgist.errors import InputError
from taskgist.facts.predicates import known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree, tree_of
from taskgist.language.clauses import truth_of
from taskgist.language.phrases import listed
from taskgist.language.recognition import circumstance_reason, literal_reason, named, nothing_handled, percent
from taskgist.learning.contrast import Contrast
from taskgist.learning.explanation import Context
from taskgist.learning.understanding import literal_to_json
from taskgist.pipeline.episodes import recognise_handlings, untracked_hands
from taskgist.pipeline.recognise import RecognisedEpisode, TaskRecogniser
from taskgist.recognition.tasks import Recognised, TaskProbability
from taskgist.recording.mcap import read
from taskgist.settings import DEFAULT


@dataclass(frozen=True)
class Found:
    """What was recognised in a recording, and which hands, by agent and side, are tracked in no frame of it."""

    episodes: tuple[RecognisedEpisode, ...]
    untracked: tuple[tuple[str, str], ...]


TOLD = 0.01
"""Tasks that are less probable than this, and than "none of these", are not printed."""


@command
def recognise(
    recordings: RecordingsArgument,
    knowledge: KnowledgeOption = KNOWLEDGE,
    why: Annotated[bool, typer.Option("--why", help="Tell what speaks for and against each task.")] = False,
    contrasted: Annotated[
        str | None, typer.Option("--contrast", help="What decides between two tasks there, such as hide,show.")
    ] = None,
    of: Annotated[
        str, typer.Option(help="For whom: target, or performer (by the performing agent's own tree).")
    ] = "target",
    episodes: Annotated[
        bool, typer.Option("--episodes", help="Find each time that a thing is handled, whatever the label says.")
    ] = False,
    at: Annotated[
        str | None, typer.Option(help="Foresee what it will be, from what is seen until then: seconds, or 50%.")
    ] = None,
    as_json: JsonOption = False,
) -> int:
    """Say which known tasks are performed in recordings.

    For whom, with which thing, and how probable each task is: several may be right at once, as who hides a thing away
    hides it, and it may be none of the known ones. The label tells when, who and what; the task that it names plays no
    part. Without a label, or with --episodes, each time that a thing is handled is found, and what it was is told for
    each agent for whom it may have been done: a day becomes a list of tasks. The exit code is 1 if in any recording
    nothing known is recognised. Of several recordings a table is printed; those that cannot be read
    stand there with the reason, and the exit code is 2. A task whose answers contradict each other is left out.

    With --contrast: which literals decide between two tasks in this recording, and how often each holds in the
    demonstrations of either.

    With --at: what a task that is under way will be, and what of it does not hold yet. Nothing after that time is
    looked at; percent are those of the labelled time, or of a recording without a label.

    Example: taskgist recognise handover.mcap -k knowledge.db

    Example: taskgist recognise recordings -k knowledge.db

    Example: taskgist recognise hidden.mcap --why

    Example: taskgist recognise hidden.mcap --contrast "hide,put away"

    Example: taskgist recognise day.mcap --episodes

    Example: taskgist recognise handover.mcap --at 50%
    """
    whose = tree_of(of)
    if at is not None:
        _check_alone({"--why": why, "--contrast": contrasted, "--episodes": episodes, "--of": whose != "target"})
    predicates = known_predicates()
    tree = with_predicates(STANDARD_TREE, predicates)
    from taskgist.store.address import shown  # with sqlalchemy, which only knowledge should wait for
    from taskgist.store.database import load

    known = load(knowledge, expected=Context.of(DEFAULT, tree), evidence=False)
    between = None
    if contrasted is not None:
        between = contrast_between(known, shown(knowledge), *two_tasks(contrasted), tree, whose)
    with about(shown(knowledge)):
        recogniser = TaskRecogniser.of(known, tree)
    paths = files(recordings, suffix=".mcap", each_by_itself=True)
    if len(paths) > 1 and not as_json:
        _check_of_one({"--why": why, "--contrast": contrasted}, len(paths))

    def recognised(number: int, progress: Progress = silent) -> Found:
        with about(paths[number], {"of": "--of"}):
            recording = read(paths[number])
            untracked = untracked_hands(recording)
            if recording.label is None or episodes:
                handlings = recognise_handlings(
                    recogniser, recording, of=whose, predicates=predicates, progress=progress
                )
                told = (each for handling in handlings for each in handling.told or handling.readings[:1])
                return Found(tuple(told), untracked)
            return Found(recogniser.recognise(recording, of=whose, predicates=predicates, progress=progress), untracked)

    if at is not None:
        return foresee_at(paths, at, recogniser, shown(knowledge), as_json=as_json)
    left_out = [task for task, _ in recogniser.left_out]
    if len(paths) == 1:
        with progress_bar(quiet=as_json) as progress:
            found = recognised(0, progress)
        if as_json:
            print_json(_document(paths[0], found, left_out, between, tree))
        else:
            _print_all(found, between, tree, why=why)
            print_left_out(recogniser.left_out, shown(knowledge))
        return OK if _any_known(found) else FAILED
    outcomes: list[Outcome[Found]] = [*one_by_one(paths, recognised, "recognising", quiet=as_json)]
    if as_json:
        print_json(
            [
                each.document()
                if isinstance(each, Refused)
                else _document(each.path, each.result, left_out, between, tree)
                for each in outcomes
            ]
        )
    else:
        print_table(outcomes, ("for", "with", "start", "end", "recognised", "labelled"), _cells, "looked at")
        print_left_out(recogniser.left_out, shown(knowledge))
    return exit_code(outcomes, good=_any_known)


def _check_alone(given: Mapping[str, object]) -> None:
    """Refuse options that say nothing of what is under way."""
    for option in (option for option, value in given.items() if value):
        hint = f"leave out {option}, or --at: what is under way is foreseen for target agents, by its probability"
        raise InputError("does not go with --at", field=option, hint=hint)


def _check_of_one(given: Mapping[str, object], count: int) -> None:
    """Refuse options for which a table has no room."""
    for option in (option for option, value in given.items() if value):
        raise InputError("tells of one recording", field=option, value=count, hint="name one, or add --json")


def _any_known(found: Found) -> bool:
    return any(each.recognised.best is not None for each in found.episodes)


def _cells(found: Found) -> list[str | Text]:
    """The cells of a recording: those of its first episode, and how many more there are."""
    if not found.episodes:
        return ["", "", "", "", nothing_handled(found.untracked), "no label"]
    first, *more = found.episodes
    label = first.label
    told = named(first.recognised) + (f"; {len(more)} further episode{'s' * (len(more) > 1)}" if more else "")
    times = (f"{time_s:.2f} s" for time_s in (label.start_s, label.end_s))
    said = (first.named or "no label") + (", learned from" if first.learned_from else "")
    return [listed(label.watched), listed(label.target_objects), *times, told, said]


def _print_all(found: Found, between: Contrast | None, tree: HypothesisTree, *, why: bool) -> None:
    """Print all episodes of a recording: a line each, unless there is one, or more is asked for."""
    if not found.episodes:
        console.print(nothing_handled(found.untracked))
    elif len(found.episodes) > 1 and not why and between is None:
        print_list(found.episodes)
    else:
        for each in found.episodes:
            _print(each, between, tree, why=why)


def _print(found: RecognisedEpisode, between: Contrast | None, tree: HypothesisTree, *, why: bool) -> None:
    label = found.label
    targets = f", for {listed(label.target_agents)}" if label.target_agents else ""
    said = "no label: proposed from the facts" if found.proposed else f"labelled {label.task}"
    head = f"{label.performing_agent}{targets}, with {listed(label.target_objects)}"
    console.print(Text(f"{head}, {label.start_s:.2f} s to {label.end_s:.2f} s", "bold") + Text(f"   ({said})"))
    if found.learned_from:
        console.print("note: the knowledge was learned from this very recording", style="dim")
    recognised = found.recognised
    for each in recognised.tasks:
        if each.probability >= TOLD or each is recognised.tasks[0]:
            style = "bold" if each is recognised.best else ""
            console.print(Text(f"  {percent(each.probability):>6}  {each.task}", style))
            if why:
                _print_why(each)
    style = "bold" if recognised.best is None else ""
    console.print(Text(f"  {percent(recognised.none):>6}  none of these", style))
    if between is not None:
        print_contrast_in(between, found.explanation.nodes, tree)


def _print_why(each: TaskProbability) -> None:
    console.print(Text(f"          what it is about {truth_of(each.holds)}:"))
    for literal in each.literals:
        console.print(Text(f"            {literal_reason(literal)}"))
    if each.least_typical:
        console.print(Text(f"          least typical: {circumstance_reason(each.least_typical)}"))
    if each.entailed_by:
        console.print(Text(f"          who does {each.entailed_by!r} does this as well, by their demonstrations"))


# --- The same as plain data.


def _document(
    path: Path, found: Found, left_out: list[str], between: Contrast | None, tree: HypothesisTree
) -> dict[str, Any]:
    return {
        "recording": str(path),
        "episodes": [_episode(each, between, tree) for each in found.episodes],
        "untracked_hands": [{"agent": agent, "side": side} for agent, side in found.untracked],
        "left_out": left_out,
    }


def _episode(found: RecognisedEpisode, between: Contrast | None, tree: HypothesisTree) -> dict[str, Any]:
    label = found.label
    return {
        "performing_agent": label.performing_agent,
        "target_agent": one_or_list(label.target_agents) if label.target_agents else None,
        "target_object": one_or_list(label.target_objects),
        "start_s": label.start_s,
        "end_s": label.end_s,
        "proposed": found.proposed,
        "labelled": found.named,
        "learned_from": found.learned_from,
        **recognised_document(found.recognised),
        **({"contrast": contrast_document_in(between, found.explanation.nodes, tree)} if between else {}),
    }


def recognised_document(recognised: Recognised) -> dict[str, Any]:
    """The probability of each task and of none of them, with what decides."""
    return {
        "best": recognised.best.task if recognised.best else None,
        "tasks": [_task(each) for each in recognised.tasks],
        "none": recognised.none,
    }


def _task(each: TaskProbability) -> dict[str, Any]:
    return {
        "task": each.task,
        "probability": each.probability,
        "meaning": each.meaning,
        "holds": truth(each.holds),
        "literals": [
            {**literal_to_json(one.literal), "holds": truth(one.holds), "weight": one.weight} for one in each.literals
        ],
        "least_typical": asdict(each.least_typical) if each.least_typical else None,
        "entailed_by": each.entailed_by,
    }
