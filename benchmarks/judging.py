"""Judging demonstrations: from a recording to its explanation, by the frames around the label's ends or by all."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from benchmarks.figure import Figure
from benchmarks.timing import all_cores, in_turn, once
from taskgist.observe import Observer
from taskgist.pipeline import episodes_of, explain_all, explain_recording, shipped_study
from taskgist.recording import Recording, read
from taskgist.world import State
from taskgist_lab.generator import simulate_all

REPEATS = 3
TENTH, STUDY_S, MINUTE_S = 10.0, 10.0, 60.0
TASKS = ("show", "hide", "make accessible", "give", "put away", "hide away")
EACH, SEED = 20, 2
"""Generated demonstrations of each task, and their seed."""
OURS, ALL = "ours", "watching all frames"


class Counted:
    """A recording that counts the frames that are asked for."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self.asked: set[int] = set()

    @property
    def times_s(self) -> NDArray[np.float64]:
        """Times of all frames in seconds, (n,)."""
        return self._recording.times_s

    def state(self, index: int) -> State:
        """The state in a frame."""
        self.asked.add(index)
        return self._recording.state(index)


def figures() -> Iterator[Figure]:
    """One demonstration of each task, then all of the study, then many."""
    yield one()
    with all_cores() as cores:
        yield study(cores)
        yield many(cores)


def one() -> Figure:
    """The median over one recording per task of the study, each judged both ways in turn."""
    recordings = [read(paths[0]) for paths in shipped_study().values()]
    taken = [in_turn({OURS: partial(_by_ends, each), ALL: partial(_by_all, each)}, REPEATS) for each in recordings]
    ours, full = (median(each[name] for each in taken) for name in (OURS, ALL))
    counts = {"frames looked at": median(map(_looked_at, recordings)), "frames": median(map(len, recordings))}
    return Figure(
        "judging",
        "a demonstration, by the frames around its ends",
        ours,
        {ALL: full},
        goal="a tenth of the time",
        met=full >= TENTH * ours,
        counts=counts,
    )


def study(cores: int) -> Figure:
    """All demonstrations of the paper's study, from their files to their explanations."""
    paths = _paths()
    ours = once(lambda: [*explain_all(paths, processes=cores)])
    return Figure(
        "judging",
        f"the study's {len(paths)} demonstrations, with reading their files",
        ours,
        goal="10 s",
        met=ours < STUDY_S,
        note=f"on {cores} cores",
    )


def many(cores: int) -> Figure:
    """Generated demonstrations in random rooms, made beforehand."""
    made = (simulate_all(task, count=EACH, seed=SEED, processes=cores) for task in TASKS)
    recordings = [recording for of_task in made for recording in of_task]
    each_s = once(lambda: [*explain_all(recordings, processes=cores)]) / len(recordings)
    return Figure(
        "judging",
        "1,000 generated demonstrations",
        1000 * each_s,
        goal="a minute",
        met=1000 * each_s < MINUTE_S,
        note=f"{MINUTE_S / each_s:,.0f} a minute on {cores} cores, measured with {len(recordings)}",
    )


def _paths() -> list[Path]:
    return [path for paths in shipped_study().values() for path in paths]


def watched(recording: Recording) -> Observer:
    """An observer that has looked at all frames: at hands, postures, placements and motions."""
    scene, observer = recording.scene, Observer(recording.scene, recording)
    for name in scene.objects:
        _, _ = observer.placement(name).intervals, observer.motion(name).intervals
    for agent in scene.agents:
        _, _ = observer.posture(agent).intervals, [observer.hand(agent, s).intervals for s in scene.agent(agent).sides]
    return observer


def _by_ends(recording: Recording) -> None:
    explain_recording(recording, predicates=())


def _by_all(recording: Recording) -> None:
    explain_recording(recording, predicates=(), observer=watched(recording))


def _looked_at(recording: Recording) -> int:
    frames = Counted(recording)
    episodes_of(recording, observer=Observer(recording.scene, frames))
    return len(frames.asked)
