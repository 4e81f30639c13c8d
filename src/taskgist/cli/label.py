"""``taskgist label``: show, set or propose what a recording demonstrates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from types import MappingProxyType
from typing import Annotated

import typer

from taskgist.cli.common import (
    FAILED,
    OK,
    JsonOption,
    RecordingArgument,
    about,
    command,
    console,
    print_json,
)
from taskgist.errors import LabelError
from taskgist.observe.observer import Observer
from taskgist.recognition.label_proposal import propose_label
from taskgist.recording.mcap import read, relabel
from taskgist.recording.recording import Label, Recording

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
    recording: RecordingArgument,
    task: Annotated[str | None, typer.Option(help="Name of the task.")] = None,
    performer: Annotated[str | None, typer.Option(help="The agent that performs it.")] = None,
    target: Annotated[list[str] | None, typer.Option(help="The agent for whom.")] = None,
    object: Annotated[list[str] | None, typer.Option("--object", help="The object with which.")] = None,  # noqa: A002
    start: Annotated[float | None, typer.Option(help="Start, seconds.")] = None,
    end: Annotated[float | None, typer.Option(help="End, seconds.")] = None,
    propose: Annotated[bool, typer.Option("--propose", help="Fill in what is not given from the facts.")] = False,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Show the label without writing it.")] = False,
    as_json: JsonOption = False,
) -> int:
    """Show, set or propose what a recording demonstrates.

    That is its label: task, agents, object, start and end. Without options it is shown (exit code 1 if there is none).
    With options it is set, what is not given stays. With --propose the facts fill in the rest: who holds the object
    when, what moves, when it comes to rest. All else in the file stays byte for byte, whoever wrote it.

    Example: taskgist label handover.mcap --propose --task give

    Example: taskgist label handover.mcap --start 1.2 --end 3.45
    """
    with about(recording, OPTIONS):
        given = {
            "task": task,
            "performing_agent": performer,
            "target_agent": _single(target, "target_agent"),
            "target_object": _single(object, "target_object"),
            "start_s": start,
            "end_s": end,
        }
        changes = {key: value for key, value in given.items() if value is not None}
        if not changes and not propose:
            return _show(read(recording).label, as_json=as_json)

        def changed(opened: Recording) -> Label:
            return _changed(_proposed(opened, changes) if propose else opened.label, changes)

        if dry_run:
            opened = read(recording)
            new = changed(opened)
            opened.with_label(new)
        else:
            new = relabel(recording, changed)
    return _show(new, as_json=as_json)


def _proposed(recording: Recording, given: Mapping[str, object]) -> Label:
    names = {key: str(value) for key, value in given.items() if key not in ("start_s", "end_s")}
    return propose_label(recording, Observer(recording.scene, recording), **names)


def _changed(base: Label | None, changes: Mapping[str, object]) -> Label:
    """A label with some fields set by hand; how the others were set is kept."""
    fields = {**(asdict(base) if base else dict.fromkeys(OPTIONS)), **changes}
    missing = [OPTIONS[key] for key, value in fields.items() if value is None]
    if missing:
        raise LabelError(f"missing: {', '.join(missing)}", field="label", hint="give them, or add --propose")
    return Label(**{**fields, "how": _how(base.how if base else "", changes)})


BY_HAND = "by hand: "


def _how(before: str, changes: Mapping[str, object]) -> str:
    """How each field was set: one clause for all that was set by hand, the others as they were."""
    clauses = [clause for clause in before.split("; ") if clause]
    hands = [clause.removeprefix(BY_HAND).split(", ") for clause in clauses if clause.startswith(BY_HAND)]
    by_hand = sorted({*changes, *(field for fields in hands for field in fields)})
    others = [clause for clause in clauses if not clause.startswith(BY_HAND)]
    return "; ".join([*others, *([BY_HAND + ", ".join(by_hand)] if by_hand else [])])


def _single(values: list[str] | None, field: str) -> str | None:
    if values and len(values) > 1:
        raise LabelError(
            "several values are not supported yet",
            field=field,
            value=values,
            hint="label one; copy the recording for each other",
        )
    return values[0] if values else None


def _show(shown: Label | None, *, as_json: bool) -> int:
    if as_json:
        print_json(asdict(shown) if shown else None)
    elif shown is None:
        console.print("no label; set one with --task, --performer, --target, --object, --start, --end, or --propose")
    else:
        console.print(f"task              {shown.task}")
        console.print(f"performing agent  {shown.performing_agent}")
        console.print(f"target agent      {shown.target_agent}")
        console.print(f"target object     {shown.target_object}")
        console.print(f"start, end        {shown.start_s:.3f} s, {shown.end_s:.3f} s")
        console.print(f"how               {shown.how}")
    return OK if shown else FAILED
