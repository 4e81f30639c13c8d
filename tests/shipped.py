"""The shipped recordings: each read, observed and explained once per process."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from taskgist.learning import Explanation, Knowledge
from taskgist.observe import Observer
from taskgist.pipeline import explain_recording, label_of, shipped_recordings, shipped_study
from taskgist.recording import Label, Recording, read

TASKS = ("give", "show", "hide")
NAMES = tuple(path.stem for task in TASKS for path in shipped_recordings(task))
STUDY: dict[str, tuple[str, ...]] = {task: tuple(p.stem for p in paths) for task, paths in shipped_study().items()}
"""Names of the study's demonstrations by task; its *give* is simulated, that of ``TASKS`` is real."""
PATHS: dict[str, Path] = {
    path.stem: path for paths in (shipped_recordings("give"), *shipped_study().values()) for path in paths
}


def names_of(task: str) -> tuple[str, ...]:
    return tuple(path.stem for path in shipped_recordings(task))


@cache
def recording(name: str) -> Recording:
    return read(PATHS[name])


@cache
def excerpt(name: str, start_s: float, end_s: float, every: int = 1) -> Recording:
    """A part of a recording, or some of its frames: sooner watched than all of it. Its label must lie inside."""
    whole = recording(name)
    part = np.flatnonzero((whole.times_s >= start_s) & (whole.times_s <= end_s))[::every]
    return replace(
        whole,
        times_s=whole.times_s[part],
        qpos=whole.qpos[part],
        tracked={key: flags[part] for key, flags in whole.tracked.items()},
        signals={key: replace(signal, values=signal.values[part]) for key, signal in whole.signals.items()},
    )


@cache
def label(name: str) -> Label:
    return label_of(recording(name))


@cache
def observer(name: str) -> Observer:
    return Observer(recording(name).scene, recording(name))


@cache
def explanation(name: str) -> Explanation:
    return explain_recording(recording(name), predicates=())


@cache
def knowledge(*tasks: str) -> Knowledge:
    return Knowledge().add(*(explanation(name) for task in tasks for name in names_of(task)))
