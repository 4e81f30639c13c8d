"""From recordings to knowledge: one labelled recording gives an explanation, many of them teach.

An episode is what ``observe`` says at both ends of the label; the hypothesis tree makes an explanation of it, and
explanations are what is learned from. Many recordings are explained on several cores.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

from taskgist.common.workers import Progress, cores, in_order, silent
from taskgist.errors import LabelError, RecordingError
from taskgist.facts.predicates import Predicate, known_predicates, with_predicates
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.tree import Episode, HypothesisTree, TreeOf, tree_of
from taskgist.learning.explanation import Context, Explanation, SymbolicAction, explain, merged
from taskgist.learning.knowledge import Knowledge
from taskgist.observe.attributes import Snapshot, snapshot
from taskgist.observe.observer import Observer
from taskgist.recording.mcap import read
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage


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


def episodes_of(
    recording: Recording,
    *,
    label: Label | None = None,
    of: TreeOf = "target",
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
    observer: Observer | None = None,
    progress: Progress = silent,
) -> tuple[Episode, ...]:
    """What was observed at both ends of a demonstration, from the perspective of each target agent on each object.

    Args:
        recording: A recording.
        label: Instead of the recording's own.
        of: From whose perspective: the target agents', or the performing agent's own.
        settings: All settings.
        predicates: A user's own predicates.
        observer: One of this recording, if there is one already: it need not look again at what it has seen.
        progress: Told how far it is.

    Returns:
        One episode for each of the label's ``pairs``, in their order.

    Raises:
        LabelError: There is no label.
    """
    label = _label_about(recording, label, of)
    observer = observer or Observer(recording.scene, recording, settings)
    predicates, stage = tuple(predicates), Stage(recording.scene)
    ends: list[list[Snapshot]] = []
    for time_s in (label.start_s, label.end_s):
        stage.show(recording.at(time_s))
        ends.append([])
        for agent, name in label.pairs:
            ends[-1].append(snapshot(stage, observer, agent=agent, name=name, settings=settings, predicates=predicates))
            progress("taking perspective", sum(map(len, ends)) / (2 * len(label.pairs)))
    return tuple(
        Episode(
            task=label.task,
            demonstration=recording.name,
            performing_agent=label.performing_agent,
            target_agent=agent,
            target_object=name,
            start=start,
            end=end,
            source=_source(recording, label),
        )
        for (agent, name), start, end in zip(label.pairs, *ends, strict=True)
    )


def episode_of(
    recording: Recording,
    *,
    label: Label | None = None,
    of: TreeOf = "target",
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
    observer: Observer | None = None,
) -> Episode:
    """The one episode of a demonstration for one target agent with one object; arguments as in ``episodes_of``.

    Raises:
        LabelError: There is no label, or it has several target agents or objects.
    """
    label = _label_about(recording, label, of)
    _ = label.target_agent, label.target_object  # several are refused before any work
    (episode,) = episodes_of(recording, label=label, settings=settings, predicates=predicates, observer=observer)
    return episode


def _label_about(recording: Recording, label: Label | None, of: TreeOf) -> Label:
    """The label, the recording's own unless one is given, by which the tree of these agents is made."""
    label = label or label_of(recording)
    return label.alone if tree_of(of) == "performer" else label


def _source(recording: Recording, label: Label) -> str:
    """What was observed, and when."""
    return f"{recording.digest} {label.start_s:.4f}-{label.end_s:.4f} s"


def announced(
    recording: Recording,
    *,
    of: TreeOf = "target",
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
) -> Explanation:
    """The explanation that ``explain_recording`` will give, without facts: digest, rivals and whose tree are the same.

    It tells before any long work whether a recording may be learned from. Arguments as there.

    Raises:
        LabelError: There is no label.
    """
    label = _label_about(recording, None, of)
    predicates = known_predicates() if predicates is None else tuple(predicates)
    return Explanation(
        task=label.task,
        demonstration=recording.name,
        performing_agent=label.performing_agent,
        target_agents=label.watched,
        target_objects=label.target_objects,
        source=_source(recording, label),
        context=Context.of(settings, with_predicates(tree, predicates)),
        nodes={},
    )


def explain_recording(
    recording: Recording,
    *,
    label: Label | None = None,
    of: TreeOf = "target",
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    actions: bool = False,
    observer: Observer | None = None,
    progress: Progress = silent,
) -> Explanation:
    """The explanation of a labelled recording; predicates join the tree: by default all that are known.

    It is the target agents' tree, or with ``of="performer"`` the performing agent's own (7.2), which is the only one
    where the label has no target agent.

    Where the label has several target agents or objects, each pair is explained alone (``Explanation.parts``), and
    these are merged to one. With ``actions`` it holds what was done meanwhile, too.

    Raises:
        LabelError: There is no label.
    """
    observer = observer or Observer(recording.scene, recording, settings)
    predicates = known_predicates() if predicates is None else tuple(predicates)
    whole = with_predicates(tree, predicates)
    episodes = episodes_of(
        recording, label=label, of=of, settings=settings, predicates=predicates, observer=observer, progress=progress
    )
    explanation = merged(explain(episode, whole, settings) for episode in episodes)
    return replace(explanation, actions=_done(recording, label, observer, settings)) if actions else explanation


def _done(
    recording: Recording, label: Label | None, observer: Observer, settings: Settings
) -> tuple[SymbolicAction, ...]:
    """What was done with the target objects during the label, by roles."""
    from taskgist.recognition.actions import actions_of  # which nobody else here needs

    label = label or label_of(recording)

    def role(agent: str | None) -> str:
        if agent == label.performing_agent:
            return "performer"
        return "target" if agent in label.target_agents else "other"

    found = actions_of(recording, observer, names=label.target_objects, looks=False, settings=settings)
    return tuple(
        SymbolicAction(
            each.kind, role(each.agent), each.start_s, each.end_s, role(each.to) if each.kind == "hand over" else None
        )
        for each in found
        if each.start_s < label.end_s and each.end_s > label.start_s
    )


FEW = 6
"""Up to so many recordings, workers take longer to begin than they save."""


def learn(
    recordings: Iterable[Recording | Path],
    *,
    of: TreeOf = "target",
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    wrong: bool = False,
    actions: bool = False,
    progress: Progress = silent,
    processes: int | None = None,
) -> Knowledge:
    """Learn from labelled recordings, each for the task of its label.

    Args:
        recordings: Labelled recordings of one or several tasks, or paths of their files.
        of: What they mean for whom: for their target agents, or for who performs them (7.2).
        tree: The hypothesis space; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        wrong: Whether they show how their tasks must not be done.
        actions: Whether what was done is learned, too; see ``learning.actions``.
        progress: Told how far it is.
        processes: How many explain recordings at the same time; see ``explain_all``.

    Raises:
        RecordingError: There are no recordings, or a file cannot be read.
        LabelError: A recording has no label.
    """
    explanations = explain_all(
        recordings,
        of=of,
        tree=tree,
        settings=settings,
        predicates=predicates,
        actions=actions,
        progress=progress,
        processes=processes,
    )
    return Knowledge().add(*(each.marked_wrong() if wrong else each for each in explanations))


def explain_all(
    recordings: Iterable[Recording | Path],
    *,
    of: TreeOf = "target",
    tree: HypothesisTree = STANDARD_TREE,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
    actions: bool = False,
    progress: Progress = silent,
    processes: int | None = None,
) -> Iterator[Explanation]:
    """The explanation of each recording, in order.

    Args:
        recordings: Labelled recordings, or paths of their files: those are read when it is their turn, so that
            thousands need no memory.
        of: Whose tree: the target agents', or the performing agent's own.
        tree: The hypothesis space; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.
        actions: Whether explanations hold what was done, too.
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

    def explained(number: int, told: Progress) -> Explanation:
        source = sources[number]
        recording = read(source) if isinstance(source, Path) else source
        label_of(recording, str(source) if isinstance(source, Path) else "")

        def of_this(what: str, share: float) -> None:
            told(f"{recording.name}: {what}", (number + share) / len(sources))

        return explain_recording(
            recording, of=of, tree=tree, settings=settings, predicates=known, actions=actions, progress=of_this
        )

    yield explained(0, progress)  # what is compiled now, workers need not compile
    if processes is None:
        processes = 1 if len(sources) <= FEW else cores()
    told = progress if processes == 1 else silent
    others = in_order(lambda number: explained(number + 1, told), len(sources) - 1, processes)
    for number, explanation in enumerate(others, start=2):
        progress(f"{explanation.demonstration}: explained", number / len(sources))
        yield explanation
    progress("done", 1.0)
