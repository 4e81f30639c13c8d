"""Simulating: the demonstration of a number, and many of them on all cores."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from taskgist.demonstrator.demonstration import demonstrate
from taskgist.demonstrator.generator.competence import check_motion, check_room
from taskgist.demonstrator.generator.way import Way
from taskgist.demonstrator.generator.ways import ways_of
from taskgist.errors import InputError, SceneError
from taskgist.recording import Progress, Recording, silent
from taskgist.workers import in_order

MOST_ATTEMPTS = 100
"""Rooms that are tried for a demonstration: in many the performer finds no way."""


def simulate(task: str, *, seed: int, number: int, means: str | None = None) -> Recording:
    """The demonstration of a number: it follows from the arguments alone.

    Args:
        task: Name of a task of ``WAYS``.
        seed: Seed of a series of demonstrations.
        number: Which one of the series, from 0 on.
        means: Name of the means; None draws one, evenly.

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
        means: Name of the means; None draws them.
        processes: How many processes; None: one for each core.
        progress: Told how far it is.

    Raises:
        UnknownNameError: There is no such task or means.
        InputError: The count, the seed or the number of processes cannot be.
        SceneError: As ``simulate``.
    """
    check_least("count", count, 1)
    return _reported(in_order(Series(task, seed, means), count, processes), count, progress)


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


def _reported(made: Iterator[Recording], count: int, progress: Progress) -> Iterator[Recording]:
    for number, recording in enumerate(made, start=1):
        progress(recording.name, number / count)
        yield recording
