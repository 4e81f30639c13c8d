"""What ``taskgist recognise`` prints of recordings without a label, and of tasks that are under way (``--at``)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.text import Text

from taskgist.cli.common import FAILED, OK, about, console, moment_s, print_json, print_left_out
from taskgist.errors import InputError
from taskgist.language.phrases import listed
from taskgist.language.recognition import foreseen_sentence, named, percent
from taskgist.learning.understanding import literal_to_json
from taskgist.pipeline.recognise import RecognisedEpisode, TaskRecogniser
from taskgist.pipeline.under_way import UnderWay, foresee_recording
from taskgist.recording.mcap import read

TOLD = 0.05
"""Tasks that are less probable than this are not printed of what is under way."""


def print_list(found: Sequence[RecognisedEpisode]) -> None:
    """Print episodes, a line each: ``12.3-15.1 s  P1 for P2 with cup  hide (94 %)``."""
    rows = [(f"{each.label.start_s:.1f}-{each.label.end_s:.1f} s", _roles(each)) for each in found]
    widths = [max(len(row[column]) for row in rows) for column in (0, 1)]
    for (times, roles), each in zip(rows, found, strict=True):
        style = "bold" if each.recognised.best else "dim"
        console.print(Text(f"{times:>{widths[0]}}  {roles:{widths[1]}}  {named(each.recognised)}", style))


def _roles(found: RecognisedEpisode) -> str:
    label = found.label
    targets = f" for {listed(label.target_agents)}" if label.target_agents else ""
    return f"{label.performing_agent}{targets} with {listed(label.target_objects)}"


def foresee_at(paths: Sequence[Path], at: str, recogniser: TaskRecogniser, where: str, *, as_json: bool) -> int:
    """Tell what is under way in a recording at a time; the exit code.

    Args:
        paths: The recording; one.
        at: When: seconds, or percent of the labelled time.
        recogniser: What is known.
        where: The knowledge that it is known from.
        as_json: Whether to print JSON.

    Raises:
        InputError: There are several recordings, or it is no time.
    """
    if len(paths) > 1:
        raise InputError("asks about one recording", field="--at", value=len(paths), hint="name one")
    (path,) = paths
    with about(path, {"at": "--at", "time_s": "--at"}):
        recording = read(path)
        time_s = moment_s(recording, at)
        found = foresee_recording(recogniser, recording, time_s)
    if as_json:
        told, left_out = [_document(each) for each in found], [task for task, _ in recogniser.left_out]
        print_json({"recording": str(path), "at_s": time_s, "under_way": told, "left_out": left_out})
    else:
        for each in found:
            _print(each)
        print_left_out(recogniser.left_out, where)
    return OK if any(each.foreseen and each.foreseen.best for each in found) else FAILED


def _print(found: UnderWay) -> None:
    moment = found.moment
    head = f"{moment.performing_agent}, for {moment.target_agent}, with {moment.thing}"
    console.print(Text(f"{head}, since {moment.start_s:.2f} s, at {moment.time_s:.2f} s", "bold"))
    console.print(Text(f"  {foreseen_sentence(found.foreseen)}"))
    if found.foreseen is None:
        return
    for task, probability in found.foreseen.tasks:
        if probability >= TOLD:
            console.print(Text(f"  {percent(probability):>6}  {task}"))
    console.print(Text(f"  {percent(found.foreseen.none):>6}  none of these"))


def _document(found: UnderWay) -> dict[str, Any]:
    moment, foreseen = found.moment, found.foreseen
    return {
        "performing_agent": moment.performing_agent,
        "target_agent": moment.target_agent,
        "target_object": moment.thing,
        "start_s": moment.start_s,
        "best": foreseen.best if foreseen else None,
        "tasks": [{"task": task, "probability": each} for task, each in foreseen.tasks] if foreseen else [],
        "none": foreseen.none if foreseen else None,
        "missing": [literal_to_json(each) for each in foreseen.missing] if foreseen else [],
        "told": foreseen_sentence(foreseen),
    }
