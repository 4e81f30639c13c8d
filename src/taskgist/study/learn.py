"""Learning from recordings: a set of labelled demonstrations in, knowledge out."""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.errors import RecordingError
from taskgist.facts import STANDARD_TREE, HypothesisTree, Predicate
from taskgist.learning import Explanation, Knowledge
from taskgist.recording import Progress, Recording, silent
from taskgist.settings import DEFAULT, Settings
from taskgist.study.episodes import explain_recording


def learn(
    recordings: Iterable[Recording],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    progress: Progress = silent,
) -> Knowledge:
    """Learn from labelled recordings, each for the task of its label.

    Args:
        recordings: Labelled recordings of one or several tasks.
        tree: The hypothesis space; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        progress: Told how far it is.

    Raises:
        RecordingError: There are no recordings.
        LabelError: A recording has no label.
    """
    explanations = tuple(
        explain_all(recordings, tree=tree, settings=settings, predicates=predicates, progress=progress)
    )
    return Knowledge().add(*explanations)


def explain_all(
    recordings: Iterable[Recording],
    *,
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    progress: Progress = silent,
) -> Iterable[Explanation]:
    """The explanation of each recording, one after the other.

    Raises:
        RecordingError: There are no recordings.
        LabelError: A recording has no label.
    """
    recordings = tuple(recordings)
    predicates = None if predicates is None else tuple(predicates)
    if not recordings:
        raise RecordingError("no demonstrations to learn from", hint="name at least one labelled recording")
    for number, recording in enumerate(recordings):

        def of_this(what: str, share: float, number: int = number, name: str = recording.name) -> None:
            progress(f"{name}: {what}", (number + share) / len(recordings))

        yield explain_recording(recording, tree=tree, settings=settings, predicates=predicates, progress=of_this)
    progress("done", 1.0)
