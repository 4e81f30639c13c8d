"""Simulated demonstrations as files, written by the processes that make them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from taskgist.demonstrator.generator.simulation import Series, check_least, name_of
from taskgist.errors import RecordingError
from taskgist.recording import Progress, Recording, silent, write
from taskgist.workers import in_order


@dataclass(frozen=True)
class Written:
    """A demonstration that has become a file.

    Attributes:
        path: The file.
        means: Name of the means.
        attempts: Rooms that were tried, the last one of which it was.
        duration_s: How long the recording lasts.
    """

    path: Path
    means: str
    attempts: int
    duration_s: float


@dataclass(frozen=True)
class _Writing:
    """Makes a demonstration and writes it."""

    series: Series
    folder: Path

    def __call__(self, number: int) -> Written:
        recording = self.series(number)
        path = self.folder / f"{recording.name}.mcap"
        write(recording, path)
        attempts = int(note(recording, "attempt")) + 1
        return Written(path, note(recording, "means"), attempts, recording.duration_s)


def simulate_files(
    series: Series,
    folder: Path,
    *,
    count: int,
    replace: bool = False,
    processes: int | None = None,
    progress: Progress = silent,
) -> Iterator[Written]:
    """Write the first demonstrations of a series into a folder, each as NAME.mcap, in order.

    Args:
        series: The series.
        folder: The folder; it is made if it is missing.
        count: How many demonstrations.
        replace: Whether files of these names may be there, and are replaced.
        processes: How many processes; None: one for each core.
        progress: Told how far it is.

    Raises:
        RecordingError: Files of these names are there and shall not be replaced, or cannot be written.
        InputError: The count or the number of processes cannot be.
        SceneError: As ``simulate``.
    """
    check_least("count", count, 1)
    written = in_order(_Writing(series, folder), count, processes)
    names = (name_of(series.task, series.seed, number) for number in range(count))
    there = [path for path in (folder / f"{name}.mcap" for name in names) if path.exists()]
    if there and not replace:
        raise RecordingError(
            f"is there already, as are {len(there) - 1} others" if len(there) > 1 else "is there already",
            where=there[0],
            hint="name another folder, or say that they may be replaced (--replace)",
        )
    _make(folder)
    return _reported(written, count, progress)


def note(recording: Recording, name: str) -> str:
    """What the notes of a simulated recording say of something: "means", "number", "attempt".

    Raises:
        RecordingError: They say nothing of it.
    """
    for line in recording.provenance.notes:
        field, _, value = line.partition(": ")
        if field == name:
            return value
    raise RecordingError(f"no note on its {name}", where=recording.name, hint="take one made by simulate")


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        hint = "name a folder that can be made"
        raise RecordingError("cannot be made", where=folder, value=error.strerror, hint=hint) from None


def _reported(written: Iterator[Written], count: int, progress: Progress) -> Iterator[Written]:
    for number, each in enumerate(written, start=1):
        progress(each.path.stem, number / count)
        yield each
