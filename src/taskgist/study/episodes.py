"""From a labelled recording to an explanation: world → perspective → observe → facts, in one place."""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.errors import LabelError
from taskgist.facts import STANDARD_TREE, Episode, HypothesisTree, Predicate, known_predicates, with_predicates
from taskgist.learning import Explanation, explain
from taskgist.observe import History, LazyObserver, Observer, Snapshot, snapshot
from taskgist.recording import Label, Progress, Recording, silent
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Stage


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
