"""Learning from recordings: a set of labelled demonstrations in, knowledge out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

from taskgist.errors import RecordingError
from taskgist.facts import STANDARD_TREE, HypothesisTree, Predicate, known_predicates
from taskgist.learning import Explanation, Knowledge
from taskgist.recording import Progress, Recording, read, silent
from taskgist.settings import DEFAULT, Settings
from taskgist.study.episodes import explain_recording, label_of
from taskgist.workers import cores, in_order

FEW = 6
"""Up to so many recordings, workers take longer to begin than they save."""


def learn(
    recordings: Iterable[Recording | Path],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    progress: Progress = silent,
    processes: int | None = None,
) -> Knowledge:
    """Learn from labelled recordings, each for the task of its label.

    Args:
        recordings: Labelled recordings of one or several tasks, or paths of their files.
        tree: The hypothesis space; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        progress: Told how far it is.
        processes: How many explain recordings at the same time; see ``explain_all``.

    Raises:
        RecordingError: There are no recordings, or a file cannot be read.
        LabelError: A recording has no label.
    """
    explanations = explain_all(
        recordings, tree=tree, settings=settings, predicates=predicates, progress=progress, processes=processes
    )
    return Knowledge().add(*explanations)


def explain_all(
    recordings: Iterable[Recording | Path],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    progress: Progress = silent,
    processes: int | None = None,
) -> Iterator[Explanation]:
    """The explanation of each recording, in order.

    Args:
        recordings: Labelled recordings, or paths of their files: those are read when it is their turn, so that
            thousands need no memory.
        tree: The hypothesis space; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        progress: Told how far it is.
        processes: How many explain recordings at the same time; by default one for few recordings, and otherwise as
            many as there are cores. There is only one where a process cannot be forked (on Windows and macOS).

    Raises:
        RecordingError: There are no recordings, or a file cannot be read.
        LabelError: A recording has no label.
    """
    sources = tuple(recordings)
    if not sources:
        raise RecordingError("no demonstrations to learn from", hint="name at least one labelled recording")
    known = known_predicates() if predicates is None else tuple(predicates)
    explained = partial(_explained, tree=tree, settings=settings, predicates=known)
    yield explained(sources[0], _part(progress, 0, len(sources)))  # what is compiled now, workers need not compile
    if processes is None:
        processes = 1 if len(sources) <= FEW else cores()
    rest = sources[1:]

    def of(number: int) -> Explanation:
        part = _part(progress, number + 1, len(sources)) if processes == 1 else silent
        return explained(rest[number], part)

    for number, explanation in enumerate(in_order(of, len(rest), processes), start=2):
        progress(f"{explanation.demonstration}: explained", number / len(sources))
        yield explanation
    progress("done", 1.0)


def _explained(
    source: Recording | Path,
    progress: Progress,
    *,
    tree: HypothesisTree,
    settings: Settings,
    predicates: tuple[Predicate, ...],
) -> Explanation:
    recording = read(source) if isinstance(source, Path) else source
    label_of(recording, str(source) if isinstance(source, Path) else "")
    name = recording.name

    def of_this(what: str, share: float) -> None:
        progress(f"{name}: {what}", share)

    return explain_recording(recording, tree=tree, settings=settings, predicates=predicates, progress=of_this)


def _part(progress: Progress, number: int, count: int) -> Progress:
    """Progress of one of several equal parts."""
    return lambda what, share: progress(what, (number + share) / count)
