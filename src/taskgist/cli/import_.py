"""``taskgist import``: motion capture becomes a recording, by a mapping or as its own format says."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table
from rich.text import Text

from taskgist.cli.common import OK, JsonOption, ReplaceOption, command, console, print_json, progress_bar
from taskgist.cli.found import files
from taskgist.cli.import_jobs import Job, imported, parameter, several
from taskgist.cli.many import Refused, exit_code, one_by_one, print_table
from taskgist.importing.looking import Proposal, summary
from taskgist.recording.recording import Recording


@command
def import_(
    sources: Annotated[
        list[Path],
        typer.Argument(
            help="Files of motion capture (.c3d, .bvh, .trc, .csv, ...), patterns such as takes/*.c3d, "
            "or mapping files (.toml).",
            metavar="SOURCE",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="The recording to write (.mcap), or a folder for several; default: named as the source, here.",
        ),
    ] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of the tables; default: the mapping's own.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Value of a {parameter} of the mapping: NAME=VALUE.")
    ] = None,
    each: Annotated[
        str | None,
        typer.Option(help="One recording for each file or folder of the tables that matches: NAME=PATTERN."),
    ] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> int:
    """Turn tracked motion into recordings.

    Fits human bodies to it. A file of motion capture is looked into: what it holds is told, and a mapping that says
    what is what is written beside the recording. Where nothing is open it is imported at once; else fill in the mapping
    and import that. Plain tables (CSV, NPZ) come in by a mapping of your own; docs/howto/import.md explains it.

    Several sources come in at once, on all cores, and so do all takes of one set-up by one mapping (--each): what each
    became is told in a table, and what could not be imported with the reason (exit code 2).

    Example: taskgist import take.c3d

    Example: taskgist import mapping.toml --data tables -o handover.mcap

    Example: taskgist import "takes/*.c3d" -o recordings

    Example: taskgist import take1.toml --each "file=takes/*.c3d" -o recordings
    """
    parameters = dict(parameter(text, "--set") for text in set_ or [])
    paths = files(sources)
    if each is None and paths == sources and len(paths) == 1:
        out = Path(f"{paths[0].stem}.mcap") if out is None else out
        return _import_one(Job(paths[0], out, parameters, data, replace), quiet=as_json)
    jobs = several(paths, each, parameters, data, out, replace=replace)
    takes = [job.named for job in jobs]
    outcomes = [*one_by_one(takes, lambda number: jobs[number].document(), "importing", quiet=as_json)]
    if as_json:
        print_json([each.document("source") if isinstance(each, Refused) else each.result for each in outcomes])
    else:
        print_table(outcomes, ("recording", "frames", "seconds", "people", "things", "notes"), _cells, "imported")
    return exit_code(outcomes, good=bool)


def _import_one(job: Job, *, quiet: bool) -> int:
    mapping = job.mapping() if quiet else job.mapping(_print_found)
    with progress_bar(quiet=quiet) as progress:
        recording = job.recording(mapping, progress)
    if quiet:
        print_json(imported(recording, job.out, mapping))
    else:
        _print(recording, job.out)
    return OK


def _print_found(proposal: Proposal, mapping: Path) -> None:
    console.print(f"{proposal.file}: {summary(proposal.take)}")
    for choice in (proposal.unit, proposal.up):
        if choice.value:
            console.print(f"{'unit ' + choice.value + ': ' if choice is proposal.unit else ''}{choice.why}")
    if proposal.raised_m:
        console.print(f"raised by {proposal.raised_m} m: people stand on the floor")
    for subject in proposal.people:
        lacking = f", without {', '.join(subject.lacking)}" if subject.lacking else ""
        console.print(f"person {subject.name}: {len(subject.points)} points, skeleton {subject.skeleton}{lacking}")
    for name, base in proposal.robots.items():
        console.print(f"robot {name}: its joints are there, its base is {base or 'not known'}")
    if proposal.things:
        console.print(f"things: {', '.join(proposal.things)}")
    if proposal.loose:
        console.print(f"points of nobody: {', '.join(proposal.loose)}")
    for note in proposal.take.notes:
        console.print(f"note: {note}")
    console.print(f"wrote {mapping}, the mapping")


def _cells(document: Mapping[str, Any]) -> list[str | Text]:
    people, things = ", ".join(document["agents"]), ", ".join(document["objects"])
    frames, seconds = str(document["frames"]), f"{document['seconds']:.2f}"
    return [document["recording"], frames, seconds, people, things, str(len(document["notes"]) or "")]


def _print(recording: Recording, out: Path) -> None:
    seconds = recording.times_s[-1] - recording.times_s[0]
    console.print(f"wrote {out}: {len(recording.times_s)} frames, {seconds:.2f} s")
    for agent, report in recording.provenance.fit.items():
        table = Table(title=f"fit of {agent}", title_justify="left", box=None)
        for column in ("landmark or direction", "median", "95 %", "largest"):
            table.add_column(column, justify="left" if column.startswith("landmark") else "right")
        for kind, unit in (("points_cm", "cm"), ("directions_deg", "°")):
            for name, error in report[kind].items():
                table.add_row(name, *(f"{error[key]:.1f} {unit}" for key in ("median", "p95", "max")))
        console.print(table)
    for note in recording.provenance.notes:
        console.print(f"note: {note}")
