"""``taskgist check``: is a recording fit to learn from?"""

from __future__ import annotations

from dataclasses import asdict

from rich.text import Text

from taskgist.cli.common import (
    FAILED,
    OK,
    JsonOption,
    RecordingsArgument,
    command,
    console,
    print_json,
    progress_bar,
    read_all,
)
from taskgist.pipeline.checkup import check as check_recording
from taskgist.pipeline.findings import Checkup

STYLES = {"unfit": "bold red", "warning": "yellow", "note": "cyan"}


@command
def check(recordings: RecordingsArgument, as_json: JsonOption = False) -> int:
    """Say whether recordings are fit to learn from.

    Looks for labels that what happens contradicts, things that travel alone or end in the air, trackers whose frames
    do not agree, lost trackers that go on, people off the floor, gaps, jumps, lost parts, sizes in another unit,
    overlapping bodies, and facts that are unknown at the label's ends. Each comes with figures and what to do about it.
    The exit code is 1 if any recording is not fit.

    Example: taskgist check handover.mcap
    """
    results: dict[str, Checkup] = {}
    for path, recording in read_all(recordings).items():
        with progress_bar(quiet=as_json) as progress:
            results[str(path)] = check_recording(recording, progress=progress)
        if not as_json:
            _print(str(path), results[str(path)])
    if as_json:
        print_json([{"recording": name, "fit": result.fit, **asdict(result)} for name, result in results.items()])
    return OK if all(result.fit for result in results.values()) else FAILED


def _print(name: str, result: Checkup) -> None:
    verdict = ("fit to learn from", "green") if result.fit else ("not fit to learn from", "bold red")
    console.print(Text.assemble(f"{name}: ", verdict))
    for finding in result.findings:
        remedy = f" → {finding.remedy}" if finding.remedy else ""
        severity = (f"{finding.severity:8}", STYLES[finding.severity])
        console.print(Text.assemble("  ", severity, f" {finding.about}: {finding.problem}{remedy}"))
