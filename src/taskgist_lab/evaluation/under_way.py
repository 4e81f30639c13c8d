"""How well tasks are foreseen while they are under way, beside recognising them as if they ended now.

Held-out demonstrations are watched until 25, 50, 75 and 90 % of their labelled time. What is said then is judged by all
tasks that they fulfil in the end, and by the one that they were played as.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from taskgist.common.workers import Progress, silent
from taskgist.pipeline.under_way import foresee_recording
from taskgist_lab.evaluation.learner import Coded
from taskgist_lab.evaluation.recognition import BINS, CERTAIN
from taskgist_lab.evaluation.replayed import Replayed
from taskgist_lab.evaluation.values import Result, Sample, rounded

SHARES = (0.25, 0.5, 0.75, 0.9)
"""Moments, as shares of the labelled time."""
HALF = 0.5
NOW, FORESEEN = "if it ended now", "foreseen"


@dataclass(frozen=True)
class Said:
    """What is said of a demonstration at one moment, in one way.

    Args:
        sample: Which demonstration.
        share: The moment, as a share of the labelled time.
        how: ``NOW`` or ``FORESEEN``.
        probability: Of each task.
        best: The most probable task; None: none of them.
    """

    sample: Sample
    share: float
    how: str
    probability: dict[str, float]
    best: str | None


@dataclass(frozen=True)
class Foreseeing:
    """One way at one moment: means over demonstrations, of each task as many.

    Attributes:
        how: ``NOW`` or ``FORESEEN``.
        share: The moment, as a share of the labelled time.
        right: Share whose most probable task is one that they fulfil in the end; none of them is wrong.
        right_of_known: The same where it is taken for granted that it is one of the known tasks.
        as_played: Whose most probable task is the one that they were played as.
        log_loss: Natural logarithm, mean over tasks and demonstrations.
        brier: Mean squared difference of probability and truth.
    """

    how: str
    share: float
    right: float
    right_of_known: float
    as_played: float
    log_loss: float
    brier: float


@dataclass(frozen=True)
class UnderWayScores(Result):
    """Both ways at all moments.

    Attributes:
        rows: By moment and way.
        demonstrations: How many were watched.
        untold: Moments at which too little was tracked.
        reliability: At half time, of probabilities that were foreseen, by bins from 0 to 1: their mean, the share in
            which it was so, and how many there were; empty bins are left out.
    """

    rows: tuple[Foreseeing, ...]
    demonstrations: int
    untold: int
    reliability: tuple[tuple[float, float, int], ...]


def under_way(coded: Coded, *, processes: int | None = None, progress: Progress = silent) -> UnderWayScores:
    """Watch held-out demonstrations until several moments, and say what they will be.

    Args:
        coded: A pool.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The pool has too few demonstrations.
    """
    replayed = Replayed.of(coded.pool)
    every = replayed.each(partial(said_of, replayed), "foreseeing", processes=processes, progress=progress)
    return scores_of([each for found in every for each in found], len(replayed.samples))


def scores_of(said: Sequence[Said], demonstrations: int) -> UnderWayScores:
    """The scores of what was said of so many demonstrations; a way in which nothing was said at a moment has none."""
    keys = [(share, how) for share in SHARES for how in (NOW, FORESEEN)]
    by_key = {key: [each for each in said if (each.share, each.how) == key] for key in keys}
    rows = [_scored(found, *key) for key, found in by_key.items() if found]
    half = by_key[HALF, FORESEEN]
    reliability = _reliability(half) if half else []
    return UnderWayScores(tuple(rows), demonstrations, demonstrations * len(keys) - len(said), tuple(reliability))


def said_of(replayed: Replayed, sample: Sample) -> list[Said]:
    """What is said of a demonstration at each moment; nothing where too little is tracked."""
    recording = replayed.recording(sample)
    label = recording.label
    assert label is not None
    said = []
    for share in SHARES:
        time_s = label.start_s + share * (label.end_s - label.start_s)
        (found,) = foresee_recording(replayed.recogniser, recording, time_s, predicates=())
        now = replayed.recogniser.by_tree["target"].recognise(found.moment.nodes)
        best = now.best.task if now.best else None
        said.append(Said(sample, share, NOW, {each.task: each.probability for each in now.tasks}, best))
        if found.foreseen:
            said.append(Said(sample, share, FORESEEN, dict(found.foreseen.tasks), found.foreseen.best))
    return said


def _scored(said: Sequence[Said], share: float, how: str) -> Foreseeing:
    given, true = _table(said)
    kept = given.clip(CERTAIN, 1.0 - CERTAIN)
    loss = -np.where(true, np.log(kept), np.log1p(-kept))
    right = [_fulfils(each, each.best) for each in said]
    of_known = [_fulfils(each, max(each.probability, key=lambda task: each.probability[task])) for each in said]
    played = [each.best == each.sample.task for each in said]
    figures = (np.mean(right), np.mean(of_known), np.mean(played), loss.mean(), ((given - true) ** 2).mean())
    return Foreseeing(how, share, *map(rounded, figures))


def _fulfils(said: Said, task: str | None) -> bool:
    return task is not None and said.sample.fulfils(task)


def _reliability(said: Sequence[Said]) -> list[tuple[float, float, int]]:
    given, true = _table(said)
    bins = np.minimum((given * BINS).astype(int), BINS - 1)
    return [
        (rounded(given[bins == each].mean()), rounded(true[bins == each].mean()), int((bins == each).sum()))
        for each in np.unique(bins)
    ]


def _table(said: Sequence[Said]) -> tuple[np.ndarray, np.ndarray]:
    """Probabilities and truth, (demonstrations, tasks)."""
    tasks = sorted({task for each in said for task in each.probability})
    given = np.array([[each.probability[task] for task in tasks] for each in said])
    true = np.array([[each.sample.fulfils(task) for task in tasks] for each in said])
    return given.reshape(len(said), len(tasks)), true.reshape(len(said), len(tasks))
