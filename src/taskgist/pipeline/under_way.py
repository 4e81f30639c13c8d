"""Tasks that are under way: what a recording, or what has come of it so far, will turn out to be.

Only the frames up to the moment are looked at. Who does it, for whom and with what are those of the label, whose task
and end play no part; without a label they are found in what has come so far: of what is being handled, the last.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass

from taskgist.errors import LabelError, RecordingError
from taskgist.facts.predicates import Predicate, known_predicates, with_predicates
from taskgist.facts.tree import HypothesisTree
from taskgist.facts.values import Observation, Value
from taskgist.observe.attributes import Snapshot, resting_snapshot
from taskgist.observe.observer import Observer
from taskgist.observe.under_way import LOOK_BACK_S, Cues, cues_at
from taskgist.pipeline.recognise import TaskRecogniser
from taskgist.recognition.completion import Foreseen, foresee
from taskgist.recognition.episodes import handlings_of
from taskgist.recording.recording import Recording
from taskgist.recording.signals import Signal
from taskgist.settings import DEFAULT, Settings
from taskgist.world.stage import Stage

Nodes = dict[str, Observation[Value]]


@dataclass(frozen=True)
class Moment:
    """What is known at one moment of something that is under way.

    Attributes:
        time_s: The moment, seconds.
        start_s: When it began.
        performing_agent: Who does it.
        target_agent: For whom it may be.
        thing: With what.
        cues: What is under way; None: one of them is not tracked.
        nodes: Facts as they would be if it ended now.
    """

    time_s: float
    start_s: float
    performing_agent: str
    target_agent: str
    thing: str
    cues: Cues | None
    nodes: Nodes


@dataclass(frozen=True)
class UnderWay:
    """A moment, and what it will turn out to be; None where too little is tracked."""

    moment: Moment
    foreseen: Foreseen | None


def foresee_recording(
    recogniser: TaskRecogniser,
    recording: Recording,
    time_s: float,
    *,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] | None = None,
) -> tuple[UnderWay, ...]:
    """What will be done in a recording, as far as can be known at a moment.

    Args:
        recogniser: What is known of tasks for target agents.
        recording: The recording; what comes after the moment is not looked at.
        time_s: The moment, seconds.
        settings: All settings.
        predicates: A user's own predicates; by default all that are known.

    Returns:
        One answer for each target agent and object of the label, or for each other agent.

    Raises:
        KnowledgeError: None of these tasks can be asked for; see ``TaskRecogniser.of``.
        LabelError: Nothing has begun yet; or there is nobody for whom it might be done, or no task is known that is.
        RecordingError: The moment is outside of the recording.
    """
    so_far = until(recording, time_s)
    time_s = float(so_far.times_s[-1])
    recogniser.check("target")
    if "target" not in recogniser.by_tree:
        raise LabelError("no task is known that is done for another", hint="learn some first: taskgist learn --help")
    known = known_predicates() if predicates is None else tuple(predicates)
    found = []
    for performer, target, thing, start_s in _roles(recording, so_far, time_s, settings):
        moment = moment_of(
            so_far, (start_s, time_s), performer, target, thing, recogniser.tree, settings=settings, predicates=known
        )
        foreseen = foresee(recogniser.by_tree["target"], moment.cues, moment.nodes) if moment.cues else None
        found.append(UnderWay(moment, foreseen))
    return tuple(found)


def _roles(
    recording: Recording, so_far: Recording, time_s: float, settings: Settings
) -> list[tuple[str, str, str, float]]:
    """Who does what is under way, for whom, with what, and since when."""
    label = recording.label
    if label is not None:
        if not label.target_agents:
            raise LabelError("nobody is there for whom it might be done", where=recording.name, field="target_agent")
        if time_s <= label.start_s:
            hint = f"ask for a time after {label.start_s:g} s"
            raise LabelError("nothing has begun yet", where=recording.name, field="at", value=time_s, hint=hint)
        return [(label.performing_agent, agent, name, label.start_s) for agent, name in label.pairs]
    handlings = [
        each
        for each in handlings_of(so_far, Observer(so_far.scene, so_far, settings), settings=settings)
        if each.performing_agent is not None and each.target_agents
    ]
    if not handlings:
        hint = "ask for a later time, or name in a label who does it, for whom and with what: taskgist label --help"
        raise LabelError("nothing is handled yet", where=recording.name, field="at", value=time_s, hint=hint)
    last = handlings[-1]
    return [(last.performing_agent or "", agent, last.thing, last.start_s) for agent in last.target_agents]


def moment_of(
    recording: Recording,
    span: tuple[float, float],
    performing_agent: str,
    target_agent: str,
    thing: str,
    tree: HypothesisTree,
    *,
    settings: Settings = DEFAULT,
    predicates: Iterable[Predicate] = (),
) -> Moment:
    """What is known at the end of a span of time, in which something has been under way from its start on.

    Args:
        recording: The recording; nothing after the span is looked at.
        span: From when to when, seconds.
        performing_agent: Who does it.
        target_agent: For whom it may be.
        thing: With what.
        tree: Of which nodes facts are; ``predicates`` extend it.
        settings: All settings.
        predicates: A user's own predicates.
    """
    start_s, time_s = span
    first, before, now = (recording.at(each) for each in (start_s, max(time_s - LOOK_BACK_S, start_s), time_s))
    cues = cues_at(
        recording.scene,
        first,
        before,
        now,
        performing_agent=performing_agent,
        target_agent=target_agent,
        thing=thing,
        settings=settings,
    )
    stage, known, snapshots = Stage(recording.scene), tuple(predicates), list[Snapshot]()
    for state in (first, now):
        stage.show(state)
        snapshots.append(resting_snapshot(stage, agent=target_agent, name=thing, settings=settings, predicates=known))
    # the recogniser's tree holds the predicates that were known when tasks were learned
    own = {each.subtree.name for each in known} - {each.name for each in tree.subtrees}
    whole = with_predicates(tree, [each for each in known if each.subtree.name in own])
    nodes = whole.instantiate(snapshots[0], snapshots[1], settings)
    return Moment(time_s, start_s, performing_agent, target_agent, thing, cues, nodes)


def until(recording: Recording, time_s: float) -> Recording:
    """A recording as it was when no more of it had come than the frames up to a time; without its label.

    Raises:
        RecordingError: The time is outside of the recording, or before its second frame.
    """
    count = recording.index_at(time_s) + 1
    if count < 2:
        hint = f"ask for a time after {recording.times_s[1]:g} s"
        raise RecordingError("nothing has begun yet", where=recording.name, field="time_s", value=time_s, hint=hint)
    return dataclasses.replace(
        recording,
        times_s=recording.times_s[:count],
        qpos=recording.qpos[:count],
        tracked={name: flags[:count] for name, flags in recording.tracked.items()},
        signals={name: Signal(each.values[:count], each.unit) for name, each in recording.signals.items()},
        label=None,
    )
