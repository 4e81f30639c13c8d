"""``taskgist import``: motion capture becomes a recording, by a mapping or as its own format says."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from taskgist.cli.common import JsonOption, ReplaceOption, check_target, command, console, print_json, progress_bar
from taskgist.common.files import writing
from taskgist.errors import MappingError
from taskgist.importing.build import import_recording
from taskgist.importing.looking import Proposal, look, mapping_text, summary
from taskgist.importing.mapping_file import load_mapping
from taskgist.importing.tables import input_files
from taskgist.recording.mcap import write
from taskgist.recording.recording import Recording


@command
def import_(
    source: Annotated[
        Path,
        typer.Argument(
            help="A file of motion capture (.c3d, .bvh, .trc, .csv, ...), or a mapping file (.toml).",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="The recording to write (.mcap); default: named as the source, here."),
    ] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of the tables; default: the mapping's own.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Value of a {parameter} of the mapping: NAME=VALUE.")
    ] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Turn tracked motion into a recording.

    Fits human bodies to it. A file of motion capture is looked into: what it holds is told, and a mapping that says
    what is what is written beside the recording. Where nothing is open it is imported at once; else fill in the mapping
    and import that. Plain tables (CSV, NPZ) come in by a mapping of your own; docs/howto/import.md explains it.

    Example: taskgist import take.c3d

    Example: taskgist import mapping.toml --data tables -o handover.mcap
    """
    out = Path(f"{source.stem}.mcap") if out is None else out
    mapping = source
    if source.suffix.lower() != ".toml":
        mapping = _written_mapping(source, out, replace=replace, quiet=as_json)
    parameters = dict(_parameter(text) for text in set_ or [])
    loaded = load_mapping(mapping, data_dir=data, parameters=parameters)
    check_target(out, "--out", replace=replace, suffix=".mcap", what="recordings", inputs=input_files(loaded))
    with progress_bar(quiet=as_json) as progress:
        recording = import_recording(loaded, progress)
    write(recording, out, replace=replace)
    if as_json:
        print_json({"recording": str(out), "mapping": str(mapping), **_document(recording)})
    else:
        _print(recording, out)


def _written_mapping(take: Path, out: Path, *, replace: bool, quiet: bool) -> Path:
    """The mapping of a file of motion capture, written beside the recording.

    Raises:
        MappingError: The file cannot be read, or leaves something open.
    """
    mapping = out.with_suffix(".toml")
    if mapping.exists() and not replace:
        hint = f"taskgist import {mapping} -o {out}; to write it anew, add --replace"
        raise MappingError("the mapping is there already: import that", where=mapping, hint=hint)
    proposal = look(take)
    check_target(out, "--out", replace=replace, suffix=".mcap", what="recordings", inputs=[take])
    check_target(mapping, "--out", replace=replace, inputs=[take])
    text = mapping_text(proposal, os.path.relpath(take, mapping.parent))
    with writing(mapping, replace=replace, error=MappingError) as stream:
        stream.write(text.encode())
    if not quiet:
        _print_found(proposal, mapping)
    if proposal.open:
        hint = f"fill in what {mapping} calls open, then: taskgist import {mapping} -o {out}"
        raise MappingError("not imported yet: " + "; ".join(proposal.open), where=take, hint=hint)
    return mapping


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
    if proposal.things:
        console.print(f"things: {', '.join(proposal.things)}")
    if proposal.loose:
        console.print(f"points of nobody: {', '.join(proposal.loose)}")
    for note in proposal.take.notes:
        console.print(f"note: {note}")
    console.print(f"wrote {mapping}, the mapping")


def _parameter(text: str) -> tuple[str, str]:
    name, separator, value = text.partition("=")
    if not separator or not name:
        raise MappingError("not a parameter", field="--set", value=text, hint="write NAME=VALUE")
    return name, value


def _document(recording: Recording) -> dict[str, Any]:
    return {
        "frames": len(recording.times_s),
        "seconds": float(recording.times_s[-1] - recording.times_s[0]),
        "agents": list(recording.scene.agents),
        "objects": list(recording.scene.objects),
        "notes": list(recording.provenance.notes),
        "fit": recording.provenance.as_dict()["fit"],
    }


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
