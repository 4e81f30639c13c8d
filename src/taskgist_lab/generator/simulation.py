"""Simulating: the demonstration of a number, and many of them on all cores."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np

from taskgist.common.workers import Progress, in_order, silent
from taskgist.errors import InputError, RecordingError, SceneError, UnknownNameError
from taskgist.recording.mcap import write
from taskgist.recording.recording import Recording
from taskgist_lab.generator.handling import INSPECT, POUR, STACK, TIDY, TURN
from taskgist_lab.generator.moving_about import MOVE
from taskgist_lab.generator.other_tasks import DROP, DUMP, LIFT, TAP, THROW
from taskgist_lab.generator.outcomes import check_motion, check_room
from taskgist_lab.generator.several_targets import GIVE_BOTH, HIDE_FROM_BOTH, SHOW_TO_BOTH
from taskgist_lab.generator.tasks_that_offer import GIVE, MAKE_ACCESSIBLE, SHOW
from taskgist_lab.generator.tasks_that_remove import HIDE, HIDE_AWAY, PUT_AWAY
from taskgist_lab.generator.way import Way
from taskgist_lab.simulator.demonstration import demonstrate

# --- All ways, by task.

ALL = (
    *(SHOW, HIDE, MAKE_ACCESSIBLE, GIVE, PUT_AWAY, HIDE_AWAY),
    *(LIFT, TAP, DROP, DUMP, THROW, MOVE, TURN, STACK, POUR, INSPECT, TIDY),
)
WAYS: Mapping[str, tuple[Way, ...]] = MappingProxyType({ways[0].task: ways for ways in ALL})
"""The ways of each task."""
TASKS = tuple(WAYS)
"""Names of the tasks, in order."""
SEVERAL: Mapping[str, tuple[Way, ...]] = MappingProxyType(
    {ways[0].task: ways for ways in (SHOW_TO_BOTH, HIDE_FROM_BOTH, GIVE_BOTH)}
)
"""Ways with several target agents or objects. They are taken by name only, so that a seed draws what it always drew."""


def ways_of(task: str, means: str | None = None) -> tuple[Way, ...]:
    """The ways of a task; the one of that name, where one is given.

    Raises:
        UnknownNameError: There is no such task, or it has no such means.
    """
    if task not in WAYS:
        raise UnknownNameError("task", task, WAYS)
    if means is None:
        return WAYS[task]
    by_name = {way.name: way for way in (*WAYS[task], *SEVERAL.get(task, ()))}
    if means not in by_name:
        raise UnknownNameError(f"means to {task}", means, by_name)
    return (by_name[means],)


MOST_ATTEMPTS = 100
"""Rooms that are tried for a demonstration: in many the performer finds no way."""


def simulate(task: str, *, seed: int, number: int, means: str | None = None) -> Recording:
    """The demonstration of a number: it follows from the arguments alone.

    Args:
        task: Name of a task of ``WAYS``.
        seed: Seed of a series of demonstrations.
        number: Which one of the series, from 0 on.
        means: Name of the means; None chooses one of ``WAYS``, evenly.

    Returns:
        The recording, labelled; its notes name the means, the seed, the number and the attempt.

    Raises:
        UnknownNameError: There is no such task or means.
        InputError: The seed or the number is negative.
        SceneError: The performer finds no way in any of the rooms that were tried.
    """
    ways = ways_of(task, means)
    check_least("seed", seed, 0)
    check_least("number", number, 0)
    way = ways[int(_rng(seed, number, task).integers(len(ways)))]
    problem = ""
    for attempt in range(MOST_ATTEMPTS):
        try:
            return attempted(way, seed, number, attempt)
        except SceneError as error:
            problem = str(error)
    raise SceneError(
        f"no way to {task} ({way.name}) in {MOST_ATTEMPTS} rooms; the last one: {problem}",
        where=name_of(task, seed, number),
        hint="take another number",
    )


@dataclass(frozen=True)
class Series:
    """The demonstrations of a task that follow from a seed: task, seed and means as in ``simulate``."""

    task: str
    seed: int
    means: str | None = None

    def __post_init__(self) -> None:
        ways_of(self.task, self.means)
        check_least("seed", self.seed, 0)

    def __call__(self, number: int) -> Recording:
        """The demonstration of a number."""
        return simulate(self.task, seed=self.seed, number=number, means=self.means)


def simulate_all(
    task: str,
    *,
    count: int,
    seed: int,
    means: str | None = None,
    processes: int | None = None,
    progress: Progress = silent,
) -> Iterator[Recording]:
    """The first demonstrations of a series, in order, made on all cores.

    Args:
        task: Name of a task of ``WAYS``.
        count: How many.
        seed: Seed of the series.
        means: Name of the means; None chooses them.
        processes: How many processes; None: one for each core.
        progress: Told how far it is.

    Raises:
        UnknownNameError: There is no such task or means.
        InputError: The count, the seed or the number of processes cannot be.
        SceneError: As ``simulate``.
    """
    check_least("count", count, 1)
    return _simulation_reported(in_order(Series(task, seed, means), count, processes), count, progress)


def check_least(field: str, value: int, least: int) -> None:
    """Refuse a number that is too small.

    Raises:
        InputError: It is.
    """
    if value < least:
        raise InputError("too small", field=field, value=value, hint=f"give a whole number from {least} on")


def name_of(task: str, seed: int, number: int) -> str:
    """Name of a recording, such as "hide-7-000012"."""
    return f"{task.replace(' ', '-')}-{seed}-{number:06d}"


def attempted(way: Way, seed: int, number: int, attempt: int) -> Recording:
    """Furnish a room, play the demonstration in it, and look at the outcome.

    Raises:
        SceneError: There is no room for something, or the performer finds no way.
    """
    rng = _rng(seed, number, way.task, way.name, attempt)
    setting = way.stage(rng)
    name = name_of(way.task, seed, number)
    scene = replace(setting.room, name=name).scene()
    check_room(scene)
    script = way.means(setting)(scene)
    recording = demonstrate(script, scene, seed=int(rng.integers(2**31)), name=name)
    check_motion(recording)
    way.check(recording)
    notes = (f"means: {way.name}", f"in words: {script.means}", f"seed: {seed}", f"number: {number}")
    provenance = replace(recording.provenance, notes=(*notes, f"attempt: {attempt}"))
    return replace(recording, provenance=provenance)


def _rng(seed: int, number: int, *words: object) -> np.random.Generator:
    return np.random.default_rng([seed, number, *(zlib.crc32(str(word).encode()) for word in words)])


def _simulation_reported(made: Iterator[Recording], count: int, progress: Progress) -> Iterator[Recording]:
    for number, recording in enumerate(made, start=1):
        progress(recording.name, number / count)
        yield recording


# --- Simulated demonstrations as files, written by the processes that make them.


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
    return _files_reported(written, count, progress)


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


def _files_reported(written: Iterator[Written], count: int, progress: Progress) -> Iterator[Written]:
    for number, each in enumerate(written, start=1):
        progress(each.path.stem, number / count)
        yield each
