"""Draws: every demonstration performed and judged anew, with people and things moved at random.

A clause that hangs on a millimetre was not learned. So each demonstration is played again in a room in which everybody
and everything stands elsewhere by a little; the demonstrator acts anew by its own geometry, and is judged anew. One
*draw* of a task is one such performance of each of its demonstrations, all moved independently.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from taskgist.demonstrator.study import STUDY
from taskgist.errors import TaskgistError
from taskgist.facts import STANDARD_TREE, FrozenMap, Value
from taskgist.learning import Context
from taskgist.recording import Progress, silent
from taskgist.study.episodes import explain_recording
from taskgist.study.paper.demonstrations import Judged
from taskgist.workers import in_order

DISTANCE_M, ANGLE_RAD = 0.03, math.radians(5)
"""How far people and things are moved at most in x and in y, and turned."""
SEEDS_PER_DEMONSTRATION = 100_000
"""No two demonstrations share a seed, as no two are moved alike."""

Outcome = tuple[Value, ...] | str
"""Values of all nodes in canonical order; or the reason why it could not be played."""
Draw = tuple[Outcome, ...]
"""An outcome for each demonstration of a task."""


@dataclass(frozen=True)
class Draws:
    """What came of displaced demonstrations.

    Args:
        study: Digest of the recordings that were not displaced; see ``digest_of``.
        context: Settings and tree under which all was judged.
        by_task: The draws of each task, the first one first.
    """

    study: str
    context: Context = field(default_factory=Context.of)
    by_task: Mapping[str, tuple[Draw, ...]] = field(default_factory=FrozenMap)

    def __post_init__(self) -> None:
        object.__setattr__(self, "by_task", FrozenMap(self.by_task))

    def count(self, task: str) -> int:
        """How often a task was drawn."""
        return len(self.by_task.get(task, ()))

    def add(self, task: str, draw: Draw) -> Draws:
        """These draws and one more."""
        more = {**self.by_task, task: (*self.by_task.get(task, ()), draw)}
        return replace(self, by_task=FrozenMap(more))


@dataclass(frozen=True)
class Job:
    """One demonstration of one draw; both are counted from one."""

    task: str
    number: int
    draw: int

    @property
    def seed(self) -> int:
        """Seed of its displacement."""
        before = sum(len(STUDY[task]) for task in list(STUDY)[: list(STUDY).index(self.task)])
        return SEEDS_PER_DEMONSTRATION * (before + self.number) + self.draw


def digest_of(judged: Mapping[str, Sequence[Judged]]) -> str:
    """Digest of the recordings of a study, 16 hexadecimal digits: other recordings, other draws."""
    digests = [each.recording_digest for of_task in judged.values() for each in of_task]
    return hashlib.sha256(" ".join(digests).encode()).hexdigest()[:16]


def measure(
    known: Draws,
    count: int,
    *,
    tasks: Sequence[str] = tuple(STUDY),
    processes: int | None = None,
    progress: Progress = silent,
) -> Iterator[Draws]:
    """Draw until each task has been drawn so often, on all cores.

    Args:
        known: Draws that there are already: what they hold is not played again.
        count: Draws of each task.
        tasks: Which tasks.
        processes: How many work at the same time; by default one on each core.
        progress: Told how far it is.

    Yields:
        What is known after each draw of all tasks, so that it can be kept.

    Raises:
        InputError: The number of processes is less than one.
    """
    missing = {draw: [task for task in tasks if draw > known.count(task)] for draw in range(1, count + 1)}
    rounds = {draw: due for draw, due in missing.items() if due}
    jobs = [Job(task, n, draw) for draw, due in rounds.items() for task in due for n in range(1, len(STUDY[task]) + 1)]
    outcomes = _played(jobs, processes)
    for done, (draw, due) in enumerate(rounds.items()):
        for number, task in enumerate(due, start=1):
            known = known.add(task, tuple(next(outcomes) for _ in STUDY[task]))
            progress(f"draw {draw} of {count}, {task}", (done + number / len(due)) / len(rounds))
        yield known


def _played(jobs: Sequence[Job], processes: int | None) -> Iterator[Outcome]:
    first, rest = jobs[:1], jobs[1:]
    coming = in_order(lambda number: play(rest[number]), len(rest), processes)
    yield from map(play, first)  # what is compiled now, workers need not compile
    yield from coming


def play(job: Job) -> Outcome:
    """Perform one displaced demonstration, and judge it."""
    demonstration = STUDY[job.task][job.number - 1]
    try:
        recording = demonstration.record(job.seed, distance_m=DISTANCE_M, angle_rad=ANGLE_RAD)
    except TaskgistError as error:  # the displaced room leaves no way to do it
        return f"{demonstration.name}: {error}"
    nodes = explain_recording(recording, predicates=()).nodes
    return tuple(nodes[node.name].value for node in STANDARD_TREE.nodes)
