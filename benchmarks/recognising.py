"""Whole clauses from many demonstrations: a fit, recognising by it, and what very many cost in time and memory."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from benchmarks.figure import Figure
from benchmarks.store import filled
from benchmarks.timing import in_turn, seconds
from taskgist.learning import Explanation, Knowledge, learn_clauses
from taskgist.learning.task_clauses import evidence_by_task
from taskgist.pipeline import explain_recording, shipped_recordings
from taskgist.pipeline.shipped import TASKS
from taskgist.recognition import Recogniser
from taskgist.recording import read

FEW, MANY, OF_TASKS = 1_000, 100_000, 20
"""Demonstrations in memory, demonstrations in a file, and tasks of either."""
OTHERWISE = 0.05
"""Share of facts that are those of another demonstration: what people vary."""
GOAL_S, GOAL_MB = 0.020, 1_000

PROGRAM = """
import resource, sys, time
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist.store import load
steps = [time.perf_counter()]
known = load(sys.argv[1], evidence=False)
steps.append(time.perf_counter())
recogniser = TaskRecogniser.of(known)
steps.append(time.perf_counter())
nodes = next(iter(known.explanations)).nodes
for _ in range(100):
    recogniser.by_tree["target"].recognise(nodes)
steps.append(time.perf_counter())
most_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(*(later - sooner for sooner, later in zip(steps, steps[1:])), most_mb, file=sys.stderr)
"""


def figures() -> Iterator[Figure]:
    """A fit beside a smaller one, and a file of very many demonstrations."""
    yield fitting()
    yield from very_many()


def fitting() -> Figure:
    """A task's clauses by a thousand demonstrations of all tasks, beside a hundred."""
    runs = {}
    for name, count in (("ours", FEW), ("by 100", 100)):
        known = Knowledge().add(*(demonstration(number) for number in range(count)))
        evidence = evidence_by_task(known)["task 00"]
        runs[name] = lambda evidence=evidence: learn_clauses(evidence, "task 00")
    beside = in_turn(runs)
    ours = beside.pop("ours")
    what = f"whole clauses of a task by {FEW:,} demonstrations of {OF_TASKS} tasks"
    return Figure("recognising", what, ours, beside, goal="20 ms", met=ours <= GOAL_S)


def very_many() -> Iterator[Figure]:
    """Reading a file of very many demonstrations, learning all its tasks, and recognising one."""
    with tempfile.TemporaryDirectory() as folder:
        path = filled(Path(folder) / "many.db", MANY, demonstration)
        done = subprocess.run([sys.executable, "-c", PROGRAM, str(path)], check=True, stderr=subprocess.PIPE, text=True)
    reading_s, learning_s, recognising_s, most_mb = map(float, done.stderr.split()[-4:])
    whole = f"{MANY:,} demonstrations of {OF_TASKS} tasks"
    yield Figure(
        "recognising",
        f"reading {whole}",
        reading_s,
        goal=f"at most {GOAL_MB:,} MB of memory",
        met=most_mb <= GOAL_MB,
        counts={"MB at most": round(most_mb)},
    )
    yield Figure("recognising", f"learning all tasks from {whole}", learning_s)
    few = Recogniser.of(Knowledge().add(*(demonstration(number) for number in range(10 * OF_TASKS))))
    beside = {f"by {10 * OF_TASKS}": seconds(lambda: few.recognise(demonstration(0).nodes))}
    yield Figure("recognising", f"recognising an episode by {whole}", recognising_s / 100, beside)


def demonstration(number: int) -> Explanation:
    """One of many: the facts of a shipped one, some of them exchanged, of a recording and a task of its own."""
    known, rng = _shipped(), np.random.default_rng(number)
    first = known[number % len(known)]
    nodes = first.nodes
    if changed := [name for name in nodes if rng.random() < OTHERWISE]:
        nodes = {**nodes, **{name: known[int(rng.integers(len(known)))].nodes[name] for name in changed}}
    return replace(
        first,
        task=f"task {number % OF_TASKS:02d}",
        demonstration=f"demonstration {number}",
        source=f"{number:016x} 0.0000-2.0000 s",
        nodes=nodes,
    )


@lru_cache(maxsize=1)
def _shipped() -> tuple[Explanation, ...]:
    """All shipped demonstrations."""
    return tuple(explain_recording(read(path)) for task in TASKS for path in shipped_recordings(task))
