"""Learning from recordings: a set of labelled demonstrations in, knowledge out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

from taskgist.common.workers import Progress, cores, in_order, silent
from taskgist.errors import LabelError, RecordingError
from taskgist.facts.predicates import Predicate, known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Episode, HypothesisTree
from taskgist.learning.explanation import Explanation, explain
from taskgist.learning.knowledge import Knowledge
from taskgist.observe.attributes import Snapshot, snapshot
from taskgist.observe.history import History, LazyObserver, Observer
from taskgist.recording.mcap import read
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

# --- From a labelled recording to an explanation: world → perspective → observe → facts, in one place.


def label_of(recording: Recording, name: str = "") -> Label:
    """The recording's label.

    Raises:
        LabelError: It has none.
    """
    if recording.label is None:
        raise LabelError(
            "the recording has no label", where=name or recording.name, hint="set one: taskgist label RECORDING --help"
        )
    return recording.label


def observe_recording(recording: Recording, settings: Settings = DEFAULT, progress: Progress = silent) -> Observer:
    """An observer that has seen a whole recording."""
    observer = Observer(recording.scene, settings)
    count = len(recording.times_s)
    for index in range(count):
        observer.update(recording.state(index))
        progress("watching", (index + 1) / count)
    observer.finish()
    return observer


def episode_of(
    recording: Recording,
    *,
    label: Label | None = None,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
    observer: History | None = None,
    progress: Progress = silent,
) -> Episode:
    """What was observed at both ends of a demonstration, from the target agent's perspective.

    Args:
        recording: A recording.
        label: Instead of the recording's own.
        settings: All settings.
        predicates: A user's own predicates.
        observer: One that has seen the whole recording, if there is one already; it changes nothing in the answer.
        progress: Told how far it is.

    Raises:
        LabelError: There is no label.
    """
    label = label or label_of(recording)
    observer = observer or LazyObserver(recording.scene, recording, settings)
    start, end = _ends(recording, label, observer, settings, tuple(predicates), progress)
    return Episode(
        task=label.task,
        demonstration=recording.name,
        performing_agent=label.performing_agent,
        target_agent=label.target_agent,
        target_object=label.target_object,
        start=start,
        end=end,
        source=f"{recording.digest} {label.start_s:.4f}-{label.end_s:.4f} s",
    )


def _ends(
    recording: Recording,
    label: Label,
    observer: History,
    settings: Settings,
    predicates: tuple[Predicate, ...],
    progress: Progress,
) -> tuple[Snapshot, Snapshot]:
    """Every attribute at the label's start and end."""
    stage = Stage(recording.scene)

    def at(time_s: float) -> Snapshot:
        stage.show(recording.at(time_s))
        who, what = label.target_agent, label.target_object
        return snapshot(stage, observer, agent=who, name=what, settings=settings, predicates=predicates)

    start = at(label.start_s)
    progress("taking perspective", 0.5)
    end = at(label.end_s)
    progress("taking perspective", 1.0)
    return start, end


def explain_recording(
    recording: Recording,
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    progress: Progress = silent,
) -> Explanation:
    """The explanation of a labelled recording; predicates join the tree: by default all that are known.

    Raises:
        LabelError: There is no label.
    """
    predicates = known_predicates() if predicates is None else tuple(predicates)
    whole = with_predicates(tree, predicates)
    episode = episode_of(recording, settings=settings, predicates=predicates, progress=progress)
    return explain(episode, whole, settings)


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
