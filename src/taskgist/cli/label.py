"""``taskgist label``: show, set or propose what a recording demonstrates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.files import RecordingArgument
from taskgist.cli.output import FAILED, OK, JsonOption, command, console, print_json, progress_bar
from taskgist.errors import LabelError
from taskgist.recording import Label, read, write
from taskgist.study import observe_recording, propose_label


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
    """Show, set or propose the label of a recording: task, agents, object, start and end.

    Without options the label is shown (exit code 1 if there is none). With options it is set, what is not given
    stays. With --propose the facts fill in the rest: who holds the object when, what moves, when it comes to rest.

    Example: taskgist label handover.mcap --propose --task give

    Example: taskgist label handover.mcap --start 1.2 --end 3.45
    """
    read_in = read(recording)
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
        return _show(read_in.label, as_json=as_json)
    if propose:
        names = {key: str(value) for key, value in changes.items() if key not in ("start_s", "end_s")}
        with progress_bar(quiet=as_json) as progress:
            observer = observe_recording(read_in, progress=progress)
        base = asdict(propose_label(read_in, observer, **names))
    else:
        base = asdict(read_in.label) if read_in.label else dict.fromkeys(given)
    new = _label({**base, **changes, "how": _how(base.get("how"), changes, propose=propose)}, recording)
    labelled = read_in.with_label(new)
    if not dry_run:
        write(labelled, recording)
    return _show(new, as_json=as_json)


def _single(values: list[str] | None, field: str) -> str | None:
    if values and len(values) > 1:
        raise LabelError(
            "several values are not supported yet",
            field=field,
            value=values,
            hint="label one; copy the recording for each other",
        )
    return values[0] if values else None


def _label(fields: Mapping[str, object], where: Path) -> Label:
    missing = [key for key, value in fields.items() if value is None]
    if missing:
        raise LabelError(f"missing: {', '.join(missing)}", where=where, hint="give them, or add --propose")
    return Label(**fields)  # type: ignore[arg-type]


def _how(before: object, changes: Mapping[str, object], *, propose: bool) -> str:
    by_hand = f"by hand: {', '.join(sorted(changes))}" if changes else ""
    return "; ".join(text for text in ((str(before or "") if propose else ""), by_hand) if text)


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
