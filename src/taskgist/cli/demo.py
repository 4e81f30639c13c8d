"""``taskgist demo``: the main job, on the recordings that come with taskgist."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import JsonOption, ReplaceOption, command, console, make_folder, print_json, progress_bar
from taskgist.cli.explain import print_understanding, understanding_document
from taskgist.cli.perform import outcome_document, print_outcome
from taskgist.cli.performance_files import write_files
from taskgist.errors import InputError
from taskgist.facts.predicates import with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.language.phrases import listed
from taskgist.learning.explanation import Explanation
from taskgist.learning.knowledge import Knowledge
from taskgist.learning.understanding import clause_of
from taskgist.pipeline.explain import explain_all, label_of
from taskgist.pipeline.performing import perform, planners
from taskgist.pipeline.shipped import shipped_recordings, shipped_room
from taskgist.planning.requests import Request
from taskgist.recording.mcap import read
from taskgist.recording.recording import Recording
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage

PERFORMED = "hide"
"""The task that a robot performs in the end."""
RULE = "─" * 80
TASKS = {
    "give": "five real handovers between people (KTH, MIT licence)",
    "show": "four simulated demonstrations (no public recordings exist)",
    "hide": "three simulated demonstrations (no public recordings exist)",
}


@command
def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for pictures and knowledge; made if new.")] = Path(
        "taskgist-demo"
    ),
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Learn from the shipped recordings, and let a robot act.

    Prints what give, show and hide mean and how that was found, and saves pictures of what the target agents see. In
    the end a robot performs hide, learned a moment before, in a room that no demonstration showed.

    Example: taskgist demo -o /tmp/demo
    """
    make_folder(out, "--out", replace=replace)
    from taskgist.store.database import update  # with sqlalchemy, which only knowledge should wait for

    update(out / "knowledge.db")  # what lies there must be usable, before any long work
    knowledge, documents = Knowledge(), {}
    for task, source in TASKS.items():
        recordings = [read(path) for path in shipped_recordings(task)]
        with progress_bar(quiet=as_json) as progress:
            explanations = list(explain_all(recordings, progress=progress))
            progress("drawing", 1.0)
            picture = _picture(recordings[0], out / f"{task}.png")
        knowledge = knowledge.add(*explanations)
        documents[task] = _report(knowledge, task, source, explanations, picture, as_json=as_json)
    update(out / "knowledge.db", knowledge.explanations)
    performed = _perform(knowledge, out, replace=replace, as_json=as_json)
    if as_json:
        print_json({"knowledge": str(out / "knowledge.db"), "tasks": documents, "performed": performed})
    else:
        console.print(f"knowledge kept in {out / 'knowledge.db'}; try: taskgist explain show -k {out / 'knowledge.db'}")


def _report(
    knowledge: Knowledge, task: str, source: str, explanations: list[Explanation], picture: Path, *, as_json: bool
) -> dict[str, Any]:
    tree = with_predicates(STANDARD_TREE)
    understanding = knowledge.understand(task, tree)
    if not as_json:
        console.print(Text.assemble((task, "bold"), f": {source}\n{RULE}"))
        names = ", ".join(explanation.demonstration for explanation in explanations)
        console.print(f"demonstrations: {names}")
        console.print()
        print_understanding(understanding)
        console.print(f"picture: {picture}")
        console.print()
    return {**understanding_document(understanding), "picture": str(picture)}


def _perform(knowledge: Knowledge, out: Path, *, replace: bool, as_json: bool) -> dict[str, Any] | None:
    """Let the robot of the shipped room hide the cup, if that was learned and OMPL is there."""
    if PERFORMED not in knowledge.tasks:
        return None
    try:
        planners()
    except InputError as error:
        if not as_json:
            console.print(f"{PERFORMED} is not performed: {error}")
        return None
    tree, scene = with_predicates(STANDARD_TREE), Scene.load(shipped_room())
    clause = clause_of(knowledge.understand(PERFORMED, tree))
    with progress_bar(quiet=as_json) as progress:
        outcome = perform(scene, Request(clause, "Jido", "P2", "cup"), tree=tree, progress=progress)
    if not as_json:
        console.print(Text.assemble((PERFORMED, "bold"), f": performed by a robot in a room that it never saw\n{RULE}"))
    name = out / f"{PERFORMED}_performed"
    asked = {"--out": name.with_suffix(".mcap"), "--picture": name.with_suffix(".png")}
    with progress_bar(quiet=as_json) as progress:
        written = write_files(asked, outcome.performances, replace=replace, progress=progress)
    if not as_json:
        print_outcome(outcome, written)
        console.print()
    return outcome_document(outcome, written)


def _picture(recording: Recording, path: Path) -> Path:
    label = label_of(recording)
    states = (recording.at(label.start_s), recording.at(label.end_s))
    agents, things = listed(label.watched), listed(label.target_objects)
    title = f"{label.task}: {label.performing_agent} → {agents}, {things} ({recording.name})"
    from taskgist.view.scene import before_after_picture  # with matplotlib, which only pictures should wait for

    return before_after_picture(Stage(recording.scene), states, label, path, title=title)
