"""Reading and writing what commands name on the command line."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

import typer

from taskgist.errors import InputError, RecordingError
from taskgist.recording import Recording, read

RecordingArgument = Annotated[Path, typer.Argument(help="A recording (.mcap).", show_default=False)]
RecordingsArgument = Annotated[list[Path], typer.Argument(help="Recordings (.mcap), or folders of them.")]
KnowledgeOption = Annotated[
    str, typer.Option("--knowledge", "-k", help="The knowledge file, or the URL of a shared database.")
]
KNOWLEDGE = "knowledge.db"
NO_OPTIONS: Mapping[str, str] = MappingProxyType({})


def read_all(paths: list[Path]) -> dict[Path, Recording]:
    """Read recordings, or folders of them, by path and in order: all of them, before any long work.

    Raises:
        RecordingError: One cannot be read, or a folder holds none.
    """
    return {path: read(path) for given in paths for path in _recordings_in(given)}


def _recordings_in(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    inside = sorted(path.rglob("*.mcap"))
    if not inside:
        raise RecordingError(
            "no recordings (*.mcap) in this folder", where=path, hint="name a recording, or a folder that holds some"
        )
    return inside


@contextmanager
def about(path: Path | str, options: Mapping[str, str] = NO_OPTIONS) -> Iterator[None]:
    """Let errors from inside name the file, and the command's option in place of the library's field.

    Args:
        path: The file that was named on the command line.
        options: Options by the fields that they set.
    """
    try:
        yield
    except InputError as error:
        if str(path) not in (error.where or ""):
            error.where = f"{path}: {error.where}" if error.where else str(path)
        error.field = options.get(error.field or "", error.field)
        raise


def make_folder(folder: Path, option: str) -> None:
    """Make a folder unless it is there, before any long work.

    Raises:
        InputError: It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"cannot be made: {error.strerror}", where=folder, field=option, hint="name a folder"
        ) from error


def check_target(path: Path, option: str) -> None:
    """Refuse a file that could not be written, before any long work.

    Raises:
        InputError: Its folder does not exist or may not be written to, or it is a folder itself.
    """
    folder = path.parent
    if path.is_dir():
        problem = "cannot be written: it is a folder"
    elif not folder.is_dir():
        problem = f"cannot be written: there is no folder {str(folder)!r}"
    elif not os.access(folder, os.W_OK):
        problem = f"cannot be written: the folder {str(folder)!r} is read-only"
    else:
        return
    raise InputError(problem, where=path, field=option, hint="name a file in a folder that you may write to")
