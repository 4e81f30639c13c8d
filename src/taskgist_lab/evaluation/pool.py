"""A pool: judged demonstrations of all tasks, made, kept on disk, and handed to the experiments."""

from __future__ import annotations

import gzip
import hashlib
import itertools
import json
import math
import zlib
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from taskgist.common.documents import read_packed_json
from taskgist.common.files import writing
from taskgist.common.workers import Progress, in_order, silent
from taskgist.errors import InputError, TaskgistError, UnknownNameError
from taskgist.facts.standard import STANDARD_TREE
from taskgist.learning.explanation import Context
from taskgist.pipeline.explain import explain_recording
from taskgist.recording.recording import Recording
from taskgist.settings import DEFAULT
from taskgist_lab.evaluation.noise import CONDITIONS
from taskgist_lab.evaluation.values import CLEAN, Failure, Sample
from taskgist_lab.generator.intentions import fulfilled
from taskgist_lab.generator.simulation import TASKS, simulate
from taskgist_lab.paper.demonstrations import STUDY
from taskgist_lab.paper.displacements import ANGLE_RAD, DISTANCE_M
from taskgist_lab.paper.published import INTUITION

HELD_OUT_EVERY = 3
"""Of every so many demonstrations the last one is held out: others learn, it judges."""


@dataclass(frozen=True)
class Pool:
    """Judged demonstrations, sorted by task, number and condition.

    Args:
        context: Settings and tree that they were judged with.
        source: Where the demonstrations come from; see ``sources.SOURCES``.
        seed: Their seed.
        nodes: The tree's nodes, in canonical order.
        samples: What was judged.
        failures: What could not be.
    """

    context: Context
    source: str
    seed: int
    nodes: tuple[str, ...]
    samples: tuple[Sample, ...] = ()
    failures: tuple[Failure, ...] = ()

    @property
    def tasks(self) -> tuple[str, ...]:
        """Names of the tasks, those of the paper first, in the order of its Table 4."""
        found = {sample.task for sample in self.samples}
        return (*(task for task in INTUITION if task in found), *sorted(found - INTUITION.keys()))

    @property
    def conditions(self) -> tuple[str, ...]:
        """Names of the conditions, the clean one first."""
        found = {sample.condition for sample in self.samples}
        return tuple(sorted(found, key=lambda name: (name != CLEAN, name)))

    def of(self, task: str, condition: str = CLEAN, *, held_out: bool) -> tuple[Sample, ...]:
        """Demonstrations of a task under a condition: those held out, or those to learn from."""
        return tuple(
            each
            for each in self.samples
            if each.task == task and each.condition == condition and is_held_out(each.number) == held_out
        )

    def with_more(self, samples: Iterable[Sample], failures: Iterable[Failure] = ()) -> Pool:
        """This pool and more of the same kind; what it has already stays as it is."""
        more = {_key(each): each for each in samples} | {_key(each): each for each in self.samples}
        missed = set(self.failures) | set(failures)
        return replace(self, samples=tuple(sorted(more.values(), key=_key)), failures=tuple(sorted(missed)))

    def restricted(self, count: int) -> Pool:
        """The first ``count`` demonstrations of each task."""
        return replace(
            self,
            samples=tuple(each for each in self.samples if each.number < count),
            failures=tuple(each for each in self.failures if each.number < count),
        )

    def check(self, context: Context, *, source: str, seed: int, where: str) -> None:
        """Refuse a pool that was made otherwise than wanted.

        Raises:
            InputError: It holds facts of other settings, of another tree, or other demonstrations.
        """
        wanted = {"context": str(context), "source": source, "seed": str(seed)}
        found = {"context": str(self.context), "source": self.source, "seed": str(self.seed)}
        for what, value in found.items():
            if value != wanted[what]:
                hint = f"wanted is {wanted[what]}; name another --pool file, or remove this one"
                raise InputError("the pool is another one", where=where, field=what, value=value, hint=hint)


def is_held_out(number: int) -> bool:
    """Whether a demonstration of this number is kept for judging."""
    return number % HELD_OUT_EVERY == HELD_OUT_EVERY - 1


def _key(sample: Sample) -> tuple[str, int, str]:
    return sample.task, sample.number, sample.condition


# --- Pools on disk: compressed JSON in which each value stands once.
#
# Values repeat: a table lists them, and a demonstration is a row of indices into it, with -1 for unknown. The digest
# over the content tells a damaged file.

FORMAT = "taskgist pool 2"


def write_pool(pool: Pool, path: Path) -> None:
    """Write a pool, whole or not at all; the same pool gives the same bytes.

    Raises:
        InputError: The file cannot be written.
    """
    text = json.dumps(_document(pool), ensure_ascii=False, separators=(",", ":"))
    with writing(path, replace=True) as stream:
        stream.write(gzip.compress(text.encode(), mtime=0))


def read_pool(path: Path) -> Pool:
    """Read a pool.

    Raises:
        InputError: The file cannot be read, or is no pool.
    """
    hint = "name a pool that taskgist evaluate made, or another file to make one"
    document = read_packed_json(path, most_bytes=DEFAULT.limits.document_bytes, problem="not a pool", hint=hint)
    try:
        return _pool(document)
    except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
        raise InputError(f"not a pool: {error!r}", where=path, field="pool", hint=hint) from error


def _document(pool: Pool) -> dict[str, Any]:
    table = sorted({value for sample in pool.samples for value in sample.values if value is not None})
    index: dict[str | None, int] = {value: number for number, value in enumerate(table)}
    index[None] = -1
    content = {
        "format": FORMAT,
        "settings": pool.context.settings_digest,
        "tree": pool.context.tree_version,
        "source": pool.source,
        "seed": pool.seed,
        "nodes": pool.nodes,
        "values": table,
        "samples": [
            [
                each.task,
                each.number,
                each.condition,
                each.means,
                [index[value] for value in each.values],
                each.fulfilled,
            ]
            for each in pool.samples
        ],
        "failures": [[each.task, each.number, each.condition, each.problem] for each in pool.failures],
    }
    return {**content, "digest": _digest(content)}


def _pool(document: dict[str, Any]) -> Pool:
    if document.pop("format") != FORMAT:
        raise ValueError("another format")
    stored = document.pop("digest")
    if stored != _digest({"format": FORMAT, **document}):
        raise ValueError("damaged: the digest does not fit")
    nodes, table = _texts(document["nodes"]), _texts(document["values"])
    return Pool(
        context=Context(*_texts([document["settings"], document["tree"]])),
        source=_text(document["source"]),
        seed=_whole(document["seed"]),
        nodes=nodes,
        samples=tuple(_sample(row, len(nodes), (*table, None)) for row in document["samples"]),
        failures=tuple(
            Failure(_text(task), _whole(number), _text(condition), _text(problem))
            for task, number, condition, problem in document["failures"]
        ),
    )


def _sample(row: Any, count: int, table: tuple[str | None, ...]) -> Sample:
    """A sample; the last entry of the table is what −1 means."""
    task, number, condition, means, codes, fulfilled = row
    if len(codes) != count or not all(-1 <= _whole(code) < len(table) - 1 for code in codes):
        raise ValueError(f"{count} values expected")
    values = tuple(table[code] for code in codes)
    return Sample(_text(task), _whole(number), _text(condition), _text(means), values, _texts(fulfilled))


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{value!r:.60} is no text")
    return value


def _texts(values: Any) -> tuple[str, ...]:
    return tuple(map(_text, values))


def _whole(value: Any) -> int:
    if type(value) is not int:
        raise TypeError(f"{value!r:.60} is no whole number")
    return value


def _digest(content: dict[str, Any]) -> str:
    text = json.dumps(content, ensure_ascii=False, sort_keys=True)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:16]


# --- Where demonstrations come from: the generator, or the paper's own study with everything displaced.

MEANS = "means: "
"""How a demonstrator's note on the means begins."""


class Player(Protocol):
    """Plays demonstrations."""

    def __call__(self, task: str, *, seed: int, number: int) -> Recording:
        """The demonstration of this number; raises a SceneError where it cannot be played."""


@dataclass(frozen=True)
class Source:
    """Where demonstrations come from.

    Args:
        name: Its name.
        text: What it is, in a few words.
        tasks: Which tasks it knows.
        play: Plays one demonstration.
        distinct: By task, how many distinct demonstrations there are, which come by turns; none where each is another.
    """

    name: str
    text: str
    tasks: tuple[str, ...]
    play: Player
    distinct: Mapping[str, int] = field(default_factory=dict)

    def kind(self, task: str, number: int) -> int:
        """Which of its distinct demonstrations one displaces; its own number where each is another."""
        return turn(number, self.distinct[task]) if task in self.distinct else number


def displaced(task: str, *, seed: int, number: int) -> Recording:
    """A demonstration of the paper's study, each by turns, with people and things displaced each time.

    Raises:
        SceneError: The displaced arrangement leaves no way to do it.
    """
    rng = np.random.default_rng([seed, zlib.crc32(task.encode()), number])
    staged = STUDY[task][turn(number, len(STUDY[task]))]
    return staged.record(int(rng.integers(2**31)), distance_m=DISTANCE_M, angle_rad=ANGLE_RAD)


def turn(number: int, count: int) -> int:
    """Which of ``count`` demonstrations comes with this number: each as often as others, also among those held out."""
    return (number + number // math.lcm(count, HELD_OUT_EVERY)) % count


def means_of(recording: Recording) -> str:
    """What its demonstrator noted as the means; the recording's name where it noted none."""
    noted = (note.removeprefix(MEANS) for note in recording.provenance.notes if note.startswith(MEANS))
    return next(noted, recording.name)


def _known(tasks: Collection[str]) -> tuple[str, ...]:
    return tuple(task for task in INTUITION if task in tasks)


JUDGING_ONLY = ("pour", "inspect", "tidy")
"""Manipulations that are kept out of the shipped background: what is called none of the known tasks is judged by
kinds that nothing was compared with."""
NEUTRAL = tuple(task for task in TASKS if task not in {*INTUITION, *JUDGING_ONLY})
"""Manipulations that nobody performs for another and that the shipped background is made of."""
BACKGROUND, UNFAMILIAR = "neutral", "unfamiliar"
"""Names of the sources of these and of those that are for judging only."""

SOURCES: Mapping[str, Source] = MappingProxyType(
    {
        each.name: each
        for each in (
            Source("generator", "generated demonstrations in random rooms", _known(TASKS), simulate),
            Source(BACKGROUND, "generated manipulations that are no task of the paper", NEUTRAL, simulate),
            Source(UNFAMILIAR, "generated manipulations of kinds that no background holds", JUDGING_ONLY, simulate),
            Source(
                "study",
                "the paper's study, all displaced by up to 3 cm and 5°",
                _known(STUDY),
                displaced,
                MappingProxyType({task: len(staged) for task, staged in STUDY.items()}),
            ),
        )
    }
)
"""All sources by name, the usual one first."""


# --- Making a pool: demonstrations are played, spoiled and judged on all cores, each once.

NODES = tuple(node.name for node in STANDARD_TREE.nodes)


@dataclass(frozen=True)
class Job:
    """One demonstration to be played, and the conditions under which it is to be judged."""

    source: str
    seed: int
    task: str
    number: int
    conditions: tuple[str, ...]

    def done(self) -> tuple[tuple[Sample, ...], tuple[Failure, ...]]:
        """Samples and failures."""
        try:
            recording = SOURCES[self.source].play(self.task, seed=self.seed, number=self.number)
        except TaskgistError as error:
            return (), (Failure(self.task, self.number, "", str(error)),)
        tasks = fulfilled(recording)
        found = [self._judged(recording, condition, tasks) for condition in self.conditions]
        samples = tuple(each for each in found if isinstance(each, Sample))
        return samples, tuple(each for each in found if isinstance(each, Failure))

    def _judged(self, recording: Recording, condition: str, tasks: tuple[str, ...]) -> Sample | Failure:
        try:
            watched = CONDITIONS[condition].applied(recording, seed=self.seed, number=self.number)
            explanation = explain_recording(watched, predicates=())
        except TaskgistError as error:
            return Failure(self.task, self.number, condition, str(error))
        means = means_of(recording)
        return Sample.of(explanation, NODES, number=self.number, condition=condition, means=means, fulfilled=tasks)


def empty_pool(source: str, seed: int) -> Pool:
    """A pool without demonstrations, for the present settings and tree."""
    return Pool(Context.of(), source, seed, NODES)


def extended(
    pool: Pool,
    count: int,
    *,
    conditions: Collection[str] = (CLEAN,),
    processes: int | None = None,
    progress: Progress = silent,
) -> Pool:
    """A pool with at least so many demonstrations of each task under each condition.

    Args:
        pool: What there is already.
        count: Demonstrations of each task.
        conditions: Names of conditions.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The pool's demonstrations can no longer be made as they were.
    """
    jobs = tuple(_jobs(pool, count, conditions))
    if not jobs:
        return pool
    if pool.samples:
        _check_still_made(pool)
    samples: list[Sample] = []
    failures: list[Failure] = []
    for number, (made, missed) in enumerate(_results(jobs, processes), start=1):
        samples += made
        failures += missed
        progress(f"demonstrations: {number} of {len(jobs)}", number / len(jobs))
    return pool.with_more(samples, failures)


def _jobs(pool: Pool, count: int, conditions: Collection[str]) -> Iterator[Job]:
    """What is missing, the tasks by turns."""
    had = {(each.task, each.number, each.condition) for each in pool.samples}
    had |= {(each.task, each.number, each.condition) for each in pool.failures}
    for number, task in itertools.product(range(count), SOURCES[pool.source].tasks):
        missing = tuple(name for name in CONDITIONS if name in conditions and (task, number, name) not in had)
        if missing and (task, number, "") not in had:
            yield Job(pool.source, pool.seed, task, number, missing)


def _results(jobs: tuple[Job, ...], processes: int | None) -> Iterator[tuple[tuple[Sample, ...], tuple[Failure, ...]]]:
    """Results in order. The first job is done here: what must be compiled is compiled once, before others need it."""
    yield jobs[0].done()
    rest = jobs[1:]
    yield from in_order(lambda number: rest[number].done(), len(rest), processes)


def _check_still_made(pool: Pool) -> None:
    """Refuse to add to demonstrations that would be others today: generator or judge have changed since."""
    first = next((each for each in pool.samples if each.condition == CLEAN), None)
    if first is None:
        return
    again, _ = Job(pool.source, pool.seed, first.task, first.number, (CLEAN,)).done()
    if again != (first,):
        hint = "it was made by another version of taskgist; name another --pool file, or remove this one"
        where = f"{first.task} {first.number} of seed {pool.seed}"
        raise InputError("a demonstration of the pool is not what it was", where=where, field="pool", hint=hint)


# --- The pool that an evaluation wants: read, extended by what is missing, and kept.

BATCH = 60
"""Demonstrations of each task after which the file is written: who interrupts a long run loses little."""


@dataclass(frozen=True)
class Wanted:
    """What a pool shall hold.

    Args:
        source: Where demonstrations come from.
        seed: Their seed.
        count: Demonstrations of each task.
        conditions: Under which they are watched.

    Raises:
        UnknownNameError: There is no such source.
        InputError: The seed is negative.
    """

    source: str
    seed: int
    count: int
    conditions: tuple[str, ...]

    def __post_init__(self) -> None:
        if self.source not in SOURCES:
            raise UnknownNameError("source", self.source, SOURCES)
        if self.seed < 0:
            raise InputError("negative", field="--seed", value=self.seed, hint="give 0 or more")


def kept_pool(path: Path | None, wanted: Wanted, *, processes: int | None = None, progress: Progress = silent) -> Pool:
    """The wanted demonstrations, those that the file has and those that are made now; the file keeps them all.

    Args:
        path: The pool's file, which need not exist; None keeps nothing.
        wanted: What it shall hold.
        processes: How many to use; by default one for each core.
        progress: Told how far it is.

    Raises:
        InputError: The file is no pool, another one than wanted, or cannot be written; or no demonstration at all
            could be played and judged.
    """
    fresh = empty_pool(wanted.source, wanted.seed)
    if path is None:
        made = extended(fresh, wanted.count, conditions=wanted.conditions, processes=processes, progress=progress)
        return _checked(made)
    if not path.parent.is_dir():
        raise InputError("no such folder", where=path, field="pool", hint="name a file in a folder that exists")
    known = read_pool(path) if path.exists() else fresh
    known.check(fresh.context, source=wanted.source, seed=wanted.seed, where=str(path))
    for done, count in pairwise((*range(0, wanted.count, BATCH), wanted.count)):

        def of_all(what: str, share: float, done: int = done, count: int = count) -> None:
            progress(what, (done + share * (count - done)) / wanted.count)

        whole = extended(known, count, conditions=wanted.conditions, processes=processes, progress=of_all)
        if whole != known:
            write_pool(whole, path)
        known = whole
    return _checked(known.restricted(wanted.count))


def _checked(pool: Pool) -> Pool:
    """Refuse a pool in which there is nothing to learn from, and say why that is so."""
    if not pool.samples:
        first = pool.failures[0]
        where = f"{first.task} {first.number} of seed {pool.seed}"
        hint = f"the first problem is: {first.problem}; try another --seed and another --pool file"
        raise InputError("no demonstration could be played and judged", where=where, field="pool", hint=hint)
    return pool
