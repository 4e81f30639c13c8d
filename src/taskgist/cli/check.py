"""``taskgist check``: is a recording fit to learn from?"""

from __future__ import annotations

from collections import Counter
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.text import Text

from taskgist.cli.common import FAILED, OK, JsonOption, RecordingsArgument, command, console, print_json, progress_bar
from taskgist.cli.found import files
from taskgist.cli.many import Done, Outcome, Refused, exit_code, one_by_one, print_table
from taskgist.common.workers import Progress, silent
from taskgist.pipeline.checkup import check as check_recording
from taskgist.pipeline.findings import Checkup
from taskgist.recording.mcap import read

STYLES = {"unfit": "bold red", "warning": "yellow", "note": "cyan"}


@command
def check(recordings: RecordingsArgument, as_json: JsonOption = False) -> int:
    """Say whether recordings are fit to learn from.

    Looks for labels that what happens contradicts, things that travel alone or end in the air, trackers whose frames
    do not agree, lost trackers that go on, people off the floor, gaps, jumps, lost parts, sizes in another unit,
    overlapping bodies, and facts that are unknown at the label's ends. Each comes with figures and what to do about it.
    The exit code is 1 if any recording is not fit. Of several recordings a table is printed after what was found; those
    that cannot be read stand there with the reason, and the exit code is 2.

    Example: taskgist check handover.mcap

    Example: taskgist check recordings "more/take_*.mcap"
    """
    paths = files(recordings, suffix=".mcap")
    if len(paths) == 1:
        return _check_one(paths[0], quiet=as_json)
    outcomes: list[Outcome[Checkup]] = []
    for outcome in one_by_one(paths, lambda number: _checked(paths[number]), "checking", quiet=as_json):
        outcomes.append(outcome)
        if not as_json and isinstance(outcome, Done) and outcome.result.findings:
            _print(str(outcome.path), outcome.result)
    if as_json:
        print_json([_document(outcome) for outcome in outcomes])
    else:
        print_table(outcomes, ("verdict", *STYLES), _cells, "checked")
    return exit_code(outcomes, good=lambda result: result.fit)


def _check_one(path: Path, *, quiet: bool) -> int:
    with progress_bar(quiet=quiet) as progress:
        result = _checked(path, progress)
    if quiet:
        print_json([_document(Done(path, result))])
    else:
        _print(str(path), result)
    return OK if result.fit else FAILED


def _checked(path: Path, progress: Progress = silent) -> Checkup:
    return check_recording(read(path), progress=progress)


def _document(outcome: Outcome[Checkup]) -> dict[str, Any]:
    if isinstance(outcome, Refused):
        return outcome.document()
    return {"recording": str(outcome.path), "fit": outcome.result.fit, **asdict(outcome.result)}


def _verdict(result: Checkup) -> tuple[str, str]:
    return ("fit to learn from", "green") if result.fit else ("not fit to learn from", "bold red")


def _cells(result: Checkup) -> list[str | Text]:
    counts = Counter[str](finding.severity for finding in result.findings)
    return [Text(*_verdict(result)), *(str(counts[severity] or "") for severity in STYLES)]


def _print(name: str, result: Checkup) -> None:
    console.print(Text.assemble(f"{name}: ", _verdict(result)))
    for finding in result.findings:
        remedy = f" → {finding.remedy}" if finding.remedy else ""
        severity = (f"{finding.severity:8}", STYLES[finding.severity])
        console.print(Text.assemble("  ", severity, f" {finding.about}: {finding.problem}{remedy}"))
