"""Reading and writing what commands name on the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taskgist.errors import RecordingError
from taskgist.recording import Recording, read

RecordingArgument = Annotated[Path, typer.Argument(help="A recording (.mcap).", show_default=False)]
RecordingsArgument = Annotated[list[Path], typer.Argument(help="Recordings (.mcap), or folders of them.")]


def recordings_in(paths: list[Path]) -> list[Path]:
    """The recordings that paths name; a folder stands for the recordings in it.

    Raises:
        RecordingError: A folder holds none.
    """
    found: list[Path] = []
    for path in paths:
        inside = sorted(path.rglob("*.mcap")) if path.is_dir() else [path]
        if not inside:
            raise RecordingError("no recordings (*.mcap) in this folder", where=path)
        found += inside
    return found


def read_all(paths: list[Path]) -> list[Recording]:
    """Read recordings, or folders of them."""
    return [read(path) for path in recordings_in(paths)]
