"""``taskgist import``: motion capture given as tables becomes a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from taskgist.cli.common import JsonOption, ReplaceOption, check_target, command, console, print_json, progress_bar
from taskgist.errors import MappingError
from taskgist.importing.build import import_recording
from taskgist.importing.mapping_file import load_mapping
from taskgist.importing.tables import input_files
from taskgist.recording.mcap import write
from taskgist.recording.recording import Recording


@command
def import_(
    mapping: Annotated[Path, typer.Argument(help="The mapping file (.toml).", show_default=False)],
    out: Annotated[Path, typer.Option("--out", "-o", help="The recording to write (.mcap).", show_default=False)],
    data: Annotated[Path | None, typer.Option(help="Folder of the tables; default: the mapping's own.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", help="Value of a {parameter} of the mapping: NAME=VALUE.")
    ] = None,
    replace: ReplaceOption = False,
    as_json: JsonOption = False,
) -> None:
    """Turn tracked motion (CSV, NPZ tables) into a recording.

    Fits human bodies to it. The mapping, a TOML file, says which columns are which points of whom; docs/howto/import.md
    explains it.

    Example: taskgist import mapping.toml --data tables -o handover.mcap
    """
    parameters = dict(_parameter(text) for text in set_ or [])
    loaded = load_mapping(mapping, data_dir=data, parameters=parameters)
    check_target(out, "--out", replace=replace, suffix=".mcap", what="recordings", inputs=input_files(loaded))
    with progress_bar(quiet=as_json) as progress:
        recording = import_recording(loaded, progress)
    write(recording, out, replace=replace)
    if as_json:
        print_json({"recording": str(out), **_document(recording)})
    else:
        _print(recording, out)


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
