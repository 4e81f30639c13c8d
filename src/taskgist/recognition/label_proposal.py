"""Proposing a label from the facts: who did what for whom, from when to when, and how sure that is.

The object that is taken in a hand or set in motion is the target object; who has it first performs; the target agent
is who takes it from the performer's hands, or takes it next, or else the other agent. Who is alone performs for nobody.

- A label *starts* a little before the object leaves what it rests on, or is first moved.
- It *ends* when the object changes hands, in the middle of the time in which both have it; where it does not, when it
  has come to rest, before somebody else takes it.

What the task is called only people know; an object that changes hands is proposed as *give*. Of several objects that
are named, each is looked at in this way: the label starts before the first of them is moved and ends after the last has
been given or has come to rest.

What speaks against a proposal is counted (``Doubt``), each as a share from 0 to 1; the least of them is the confidence.
Below ``settings.checks.least_confidence`` nothing is proposed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from taskgist.errors import LabelError
from taskgist.observe.observer import Observer
from taskgist.recognition.courses import Doubt, courses_of, ends_of, unseen
from taskgist.recognition.turns import GIVING, Change, Turn
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Checks, Settings

MOVED_M = 0.02
"""How far an object must get away from where it was first, to be what a demonstration is about."""
SURE = 0.995
"""From here on there is no doubt that is worth a word."""
NOT_GIVEN = 0.6
"""Confidence where nobody takes what is said to be given."""


@dataclass(frozen=True)
class Proposal:
    """A proposed label.

    Attributes:
        label: The label; its ``how`` says all of this, too.
        confidence: From 0 to 1: that of the greatest doubt.
        reason: What that was, in one clause.
    """

    label: Label
    confidence: float
    reason: str


def propose_label(
    recording: Recording,
    observer: Observer,
    *,
    task: str | None = None,
    target_objects: str | Sequence[str] = (),
    performing_agent: str | None = None,
    target_agents: str | Sequence[str] = (),
    start_s: float | None = None,
    end_s: float | None = None,
    settings: Settings = DEFAULT,
) -> Label:
    """The label of ``propose``; arguments and errors as there."""
    return propose(
        recording,
        observer,
        task=task,
        target_objects=target_objects,
        performing_agent=performing_agent,
        target_agents=target_agents,
        start_s=start_s,
        end_s=end_s,
        settings=settings,
    ).label


def propose(
    recording: Recording,
    observer: Observer,
    *,
    task: str | None = None,
    target_objects: str | Sequence[str] = (),
    performing_agent: str | None = None,
    target_agents: str | Sequence[str] = (),
    start_s: float | None = None,
    end_s: float | None = None,
    settings: Settings = DEFAULT,
) -> Proposal:
    """Propose a label; what is given is kept.

    Args:
        recording: The recording.
        observer: One of this recording.
        task: Name of the task.
        target_objects: The object, or several; none: the one that gets farthest away from where it was.
        performing_agent: Who performs.
        target_agents: For whom; none: who takes the object from the performer, or the only other agent.
        start_s: When it starts, seconds; what happens before does not count.
        end_s: When it ends, seconds; what happens after does not count.
        settings: Confidence below which nothing is proposed.

    Raises:
        LabelError: Nothing happens that would tell, or too little speaks for what seems to, or it does not tell which
            task it is.
    """
    names = _given(target_objects) or (_moved_most(recording),)
    span = (-math.inf if start_s is None else start_s, math.inf if end_s is None else end_s)
    courses = courses_of(observer, names)
    turns = {name: _within(courses[name].turns, span) for name in names}
    in_order = sorted((turn for each in turns.values() for turn in each), key=lambda turn: turn.start_s)
    changes = {
        name: tuple(each for each in course.changes if span[0] <= each.time_s <= span[1])
        for name, course in courses.items()
    }
    agents = _given(target_agents)
    performer = performing_agent or _performer(recording, in_order, agents)
    given = {name: _given_by(changes[name], performer, agents) for name in names}
    targets = agents or _targets(recording, performer, in_order, [each[0] for each in given.values() if each])
    given = {name: _given_by(changes[name], performer, targets) for name in names}
    name_of_task = task or ("give" if all(given.values()) else None)
    if name_of_task is None:
        raise LabelError("the facts do not tell which task this is", field="task", hint="name it: --task show")
    acting = [name for name in names if turns[name] or courses[name].moving] or names
    ends = [ends_of(recording, courses[name], turns[name], given[name], performer, span, settings) for name in acting]
    first, last = min(ends, key=lambda each: each.start_s), max(ends, key=lambda each: each.end_s)
    times = (
        _tidy(recording, first.start_s) if start_s is None else start_s,
        _tidy(recording, last.end_s) if end_s is None else end_s,
    )
    doubts = [each for found in ends for each in found.late]
    if not (performing_agent and agents and end_s is not None):
        doubts += [each for found in ends for each in found.doubts]
        if performing_agent is None:
            doubts += [each for name in acting for each in unseen(courses[name], turns[name][:1])]
        if name_of_task.lower() in GIVING:
            doubts += [Doubt(NOT_GIVEN, f"{name} does not change hands") for name in acting if not given[name]]
    doubt = min(doubts, key=lambda each: each.confidence, default=Doubt(1.0, ""))
    if doubt.confidence >= SURE:
        doubt = Doubt(1.0, "nothing speaks against it")
    _check(doubt, settings.checks)
    start_how = first.start_how if start_s is None else "starts as given"
    end_how = last.end_how if end_s is None else "ends as given"
    how = f"proposed: {start_how}; {end_how}; confidence {doubt.confidence:.2f}: {doubt.reason}"
    label = Label(name_of_task, performer, targets, names, *times, how)
    return Proposal(label, doubt.confidence, doubt.reason)


def _check(doubt: Doubt, limits: Checks) -> None:
    if doubt.confidence < limits.least_confidence:
        raise LabelError(
            f"what happens is not clear enough to propose a label: {doubt.reason}",
            field="label",
            value=f"confidence {doubt.confidence:.2f}, at least {limits.least_confidence:g} is asked for",
            hint="see taskgist check; name what you know (--performer, --target, --start, --end), or set all by hand",
        )


def _given(names: str | Sequence[str]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)


def _tidy(recording: Recording, time_s: float) -> float:
    """To the next millisecond, inside of the recording: what is so from a frame on is so then."""
    return min(max(math.ceil(1000 * time_s - 1e-6) / 1000, float(recording.times_s[0])), float(recording.times_s[-1]))


# --- What it is about, and who is who.


def _moved_most(recording: Recording) -> str:
    """The object that gets farthest away from where it was first tracked."""

    def farthest_m(name: str) -> float:
        places = recording.qpos[:, recording.scene.object_slice(name)][:, :3]
        if name in recording.tracked:
            places = places[recording.tracked[name]]
        squared_m2 = ((places - places[:1]) ** 2).sum(axis=1)
        return math.sqrt(squared_m2.max(initial=0.0))

    moved_m = {name: farthest_m(name) for name in recording.scene.objects}
    best = max(moved_m, key=lambda name: moved_m[name], default=None)
    if best is None or moved_m[best] < MOVED_M:
        raise LabelError("no object moves in this recording", field="target_object", hint="name it: --object NAME")
    return best


def _within(turns: Iterable[Turn], span: tuple[float, float]) -> tuple[Turn, ...]:
    """The turns that lie in a span of time, or reach into it."""
    return tuple(turn for turn in turns if turn.start_s < span[1] and turn.end_s > span[0])


def _performer(recording: Recording, turns: Sequence[Turn], targets: tuple[str, ...]) -> str:
    if turns:
        return next((turn.agent for turn in turns if turn.agent not in targets), turns[0].agent)
    if targets:
        return _others(recording, *targets)[0]
    raise LabelError("nobody is seen to hold the object", field="performing_agent", hint="name it: --performer P1")


def _targets(recording: Recording, performer: str, turns: Sequence[Turn], given: Sequence[Change]) -> tuple[str, ...]:
    """For whom it is: who takes it from the performer, or takes it next, or the only other agent; nobody, if alone."""
    if given:
        return (min(given, key=lambda change: change.taken_s).taker,)
    first_s = min((turn.start_s for turn in turns if turn.agent == performer), default=-math.inf)
    later = next((turn.agent for turn in turns if turn.agent != performer and turn.start_s > first_s), None)
    if later is not None:
        return (later,)
    return _others(recording, performer) if len(recording.scene.agents) > 1 else ()


def _others(recording: Recording, *agents: str) -> tuple[str]:
    others = [name for name in recording.scene.agents if name not in agents]
    if len(others) != 1:
        raise LabelError("which agent is the target is not clear", field="target_agent", hint="name it: --target P2")
    return (others[0],)


def _given_by(changes: Sequence[Change], performer: str, targets: tuple[str, ...]) -> tuple[Change, ...]:
    """The changes of hands from the performer to a target agent; to anybody, where none is named."""
    return tuple(each for each in changes if each.giver == performer and (not targets or each.taker in targets))
