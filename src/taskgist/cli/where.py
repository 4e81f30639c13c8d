"""What commands are asked about: a scene, or a moment of a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from taskgist.cli.files import about
from taskgist.errors import RecordingError
from taskgist.recording import read
from taskgist.world import Scene, Stage

WhereArgument = Annotated[Path, typer.Argument(help="A scene (.toml) or a recording (.mcap).", show_default=False)]
AtOption = Annotated[float | None, typer.Option(help="Time in a recording, seconds; default: its start.")]


def open_stage(where: Path, at: float | None) -> Stage:
    """A scene as it is placed, or as it was at a time of a recording.

    Raises:
        SceneError: The scene cannot be read.
        RecordingError: The recording cannot be read or does not have that time, or a scene is asked for one.
    """
    with about(where, {"time_s": "--at"}):
        if where.suffix.lower() == ".toml":
            if at is not None:
                raise RecordingError("a scene has no time", where=where, field="--at", value=at, hint="leave --at out")
            return Stage(Scene.load(where))
        recording = read(where)
        return Stage(recording.scene, recording.at(float(recording.times_s[0]) if at is None else at))
