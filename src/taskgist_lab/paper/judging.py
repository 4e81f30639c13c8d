"""The study's demonstrations: read, judged and timed."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from taskgist.common.workers import Progress, in_order, silent
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import HypothesisTree
from taskgist.learning.experience import Experience
from taskgist.learning.explanation import Explanation
from taskgist.learning.understanding import Understanding, understand
from taskgist.observe.attributes import ability_observations
from taskgist.pipeline.explain import explain_recording, label_of
from taskgist.pipeline.shipped import shipped_study
from taskgist.recording.mcap import read
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT, Learning
from taskgist.world.stage import Stage


@dataclass(frozen=True)
class Judged:
    """One demonstration, judged.

    Args:
        explanation: What was found.
        recording_digest: Digest of what was recorded.
        length_s: From the label's start to its end.
        seconds: Time that judging took, from the recording in memory to the explanation.
        perspective_seconds: Time that the target agent's abilities took alone, at start and end.
    """

    explanation: Explanation
    recording_digest: str
    length_s: float
    seconds: float
    perspective_seconds: float


def judge_study(
    paths: Mapping[str, Sequence[Path]] | None = None, *, processes: int | None = None, progress: Progress = silent
) -> dict[str, tuple[Judged, ...]]:
    """Judge all demonstrations, by task and in the study's order.

    Args:
        paths: Recordings by task; by default those that are shipped.
        processes: How many work at the same time; by default one on each core.
        progress: Told how far it is.

    Raises:
        RecordingError: One cannot be read.
        LabelError: One has no label.
        InputError: The number of processes is less than one.
    """
    paths = shipped_study() if paths is None else paths
    files = [path for of_task in paths.values() for path in of_task]
    coming = in_order(lambda number: judge(files[number]), len(files), processes)
    _timed(read(files[0]))  # what is loaded or compiled but once is paid for here, and not by each worker
    judged = []
    for each in coming:
        judged.append(each)
        progress(f"judged {each.explanation.demonstration}", len(judged) / len(files))
    rest = iter(judged)
    return {task: tuple(next(rest) for _ in of_task) for task, of_task in paths.items()}


def judge(path: Path) -> Judged:
    """Judge one demonstration and measure how long that takes."""
    recording = read(path)
    label = label_of(recording)
    seconds, explanation = _timed(recording)
    perspective_seconds = _perspective_seconds(read(path))
    return Judged(explanation, recording.digest, label.end_s - label.start_s, seconds, perspective_seconds)


def understanding_of(
    task: str,
    judged: Sequence[Judged],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Learning = DEFAULT.learning,
) -> Understanding:
    """What these demonstrations of a task teach."""
    return understand(Experience.of(task, (each.explanation for each in judged)), tree, settings)


def _timed(recording: Recording) -> tuple[float, Explanation]:
    begin = time.perf_counter()
    explanation = explain_recording(recording, predicates=())
    return time.perf_counter() - begin, explanation


def _perspective_seconds(recording: Recording) -> float:
    label = label_of(recording)
    begin = time.perf_counter()
    stage = Stage(recording.scene)
    for time_s in (label.start_s, label.end_s):
        stage.show(recording.at(time_s))
        ability_observations(stage, label.target_agent, label.target_object, DEFAULT)
    return time.perf_counter() - begin
