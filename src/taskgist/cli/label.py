"""``taskgist label``: show, set or propose what a recording demonstrates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import typer
from rich.text import Text

from taskgist.cli.common import FAILED, OK, JsonOption, RecordingsArgument, about, command, console, print_json
from taskgist.cli.found import files
from taskgist.cli.many import Outcome, Refused, exit_code, one_by_one, print_table
from taskgist.common.text import one_or_list
from taskgist.errors import LabelError
from taskgist.language.phrases import listed
from taskgist.observe.observer import Observer
from taskgist.recognition.label_proposal import propose_label
from taskgist.recording.mcap import read, relabel
from taskgist.recording.recording import Label, Recording, label_of_fields

OPTIONS = MappingProxyType(
    {
        "task": "--task",
        "performing_agent": "--performer",
        "target_agent": "--target",
        "target_object": "--object",
        "start_s": "--start",
        "end_s": "--end",
    }
)
"""Which option sets which field of a label."""


@command
def label(
    recordings: RecordingsArgument,
    task: Annotated[str | None, typer.Option(help="Name of the task.")] = None,
    performer: Annotated[str | None, typer.Option(help="The agent that performs it.")] = None,
    target: Annotated[list[str] | None, typer.Option(help="The agent for whom; once for each of several.")] = None,
    object: Annotated[  # noqa: A002
        list[str] | None, typer.Option("--object", help="The object with which; once for each of several.")
    ] = None,
    start: Annotated[float | None, typer.Option(help="Start, seconds.")] = None,
    end: Annotated[float | None, typer.Option(help="End, seconds.")] = None,
    propose: Annotated[bool, typer.Option("--propose", help="Fill in what is not given from the facts.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show the label without writing it.")] = False,
    as_json: JsonOption = False,
) -> int:
    """Show, set or propose what recordings demonstrate.

    That is its label: task, agents, objects, start and end. Without options it is shown (exit code 1 if there is none).
    With options it is set, what is not given stays. With --propose the facts fill in the rest: who has the object
    when, what moves, when it changes hands or comes to rest, and how sure that is. Where too little speaks for it,
    nothing is proposed, with the reason (exit code 2). All else in the file stays byte for byte, whoever wrote it.

    What is done for several agents at once, or with several objects, names each of them: every object is then meant
    for every target agent. Who is alone needs no target agent: what changes for the performer itself is then learned.

    Example: taskgist label handover.mcap --propose --task give

    Example: taskgist label recordings --propose --task give

    Example: taskgist label handover.mcap --start 1.2 --end 3.45

    Example: taskgist label hidden.mcap --target P2 --target P3
    """
    given = {
        "task": task,
        "performing_agent": performer,
        "target_agent": one_or_list(target) if target else None,
        "target_object": one_or_list(object) if object else None,
        "start_s": start,
        "end_s": end,
    }
    wanted = Wanted({key: value for key, value in given.items() if value is not None}, propose, dry_run)
    paths = files(recordings, suffix=".mcap")
    if len(paths) == 1:
        return _show(wanted.label_of(paths[0]), as_json=as_json)
    outcomes = [*one_by_one(paths, lambda number: wanted.label_of(paths[number]), "labelling", quiet=as_json)]
    if as_json:
        print_json([_document(outcome) for outcome in outcomes])
    else:
        print_table(
            outcomes,
            ("task", "performer", "for", "with", "start", "end"),
            _cells,
            "shown" if wanted.shows else "labelled",
        )
    return exit_code(outcomes, good=lambda found: found is not None)


@dataclass(frozen=True)
class Wanted:
    """What is wanted of the labels of recordings.

    Attributes:
        changes: Fields that are set, and their values.
        propose: Whether facts fill in the others.
        dry_run: Whether nothing is written.
    """

    changes: Mapping[str, Any]
    propose: bool
    dry_run: bool

    @property
    def shows(self) -> bool:
        """Whether the labels are only looked at."""
        return not self.changes and not self.propose

    def label_of(self, path: Path) -> Label | None:
        """The label of a recording, after it was changed.

        Raises:
            InputError: The recording cannot be read or written, the label cannot be, or too little speaks for one.
        """
        with about(path, OPTIONS):
            if self.shows:
                return read(path).label
            if not self.dry_run:
                return relabel(path, self._changed)
            opened = read(path)
            new = self._changed(opened)
            opened.with_label(new)
            return new

    def _changed(self, recording: Recording) -> Label:
        base = _proposed(recording, self.changes) if self.propose else recording.label
        return _changed(base, self.changes, alone=len(recording.scene.agents) == 1)


def _proposed(recording: Recording, given: Mapping[str, Any]) -> Label:
    return propose_label(
        recording,
        Observer(recording.scene, recording),
        task=given.get("task"),
        performing_agent=given.get("performing_agent"),
        target_agents=given.get("target_agent", ()),
        target_objects=given.get("target_object", ()),
        start_s=given.get("start_s"),
        end_s=given.get("end_s"),
    )


def _changed(base: Label | None, changes: Mapping[str, object], *, alone: bool) -> Label:
    """A label with some fields set by hand; how the others were set is kept.

    A label for nobody else stays one; who is ``alone`` in a recording needs no target agent.
    """
    fields = {**(base.as_dict() if base else dict.fromkeys(OPTIONS)), **changes}
    optional = {"target_agent"} if alone or base else set()
    missing = [OPTIONS[key] for key, value in fields.items() if value is None and key not in optional]
    if missing:
        raise LabelError(f"missing: {', '.join(missing)}", field="label", hint="give them, or add --propose")
    return label_of_fields({**fields, "how": _how(base.how if base else "", changes)})


BY_HAND = "by hand: "


def _how(before: str, changes: Mapping[str, object]) -> str:
    """How each field was set: one clause for all that was set by hand, the others as they were."""
    clauses = [clause for clause in before.split("; ") if clause]
    hands = [clause.removeprefix(BY_HAND).split(", ") for clause in clauses if clause.startswith(BY_HAND)]
    by_hand = sorted({*changes, *(field for fields in hands for field in fields)})
    others = [clause for clause in clauses if not clause.startswith(BY_HAND)]
    return "; ".join([*others, *([BY_HAND + ", ".join(by_hand)] if by_hand else [])])


def _document(outcome: Outcome[Label | None]) -> dict[str, Any]:
    if isinstance(outcome, Refused):
        return outcome.document()
    return {"recording": str(outcome.path), "label": outcome.result.as_dict() if outcome.result else None}


def _cells(found: Label | None) -> list[str | Text]:
    if found is None:
        return ["no label"]
    times = (f"{time_s:.2f} s" for time_s in (found.start_s, found.end_s))
    return [found.task, found.performing_agent, listed(found.target_agents), listed(found.target_objects), *times]


def _show(shown: Label | None, *, as_json: bool) -> int:
    if as_json:
        print_json(shown.as_dict() if shown else None)
    elif shown is None:
        console.print("no label; set one with --task, --performer, --target, --object, --start, --end, or --propose")
    else:
        console.print(f"task              {shown.task}")
        console.print(f"performing agent  {shown.performing_agent}")
        for title, names in (("target agent", shown.target_agents), ("target object", shown.target_objects)):
            told = ", ".join(names) or f"none: it is {shown.performing_agent}'s own"
            console.print(f"{title if len(names) < 2 else title + 's':18}{told}")
        console.print(f"start, end        {shown.start_s:.3f} s, {shown.end_s:.3f} s")
        console.print(f"how               {shown.how}")
    return OK if shown else FAILED
