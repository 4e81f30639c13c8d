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
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from taskgist.errors import LabelError
from taskgist.facts import vocabulary as v
from taskgist.observe.observer import Observer
from taskgist.recognition.turns import BRIEF_S, GIVING, RESTING, Change, Turn, changes_of_hands, turns_of
from taskgist.recording.recording import Label, Recording
from taskgist.settings import DEFAULT, Checks, Settings
from taskgist.world.contacts import hand_gap_m, hand_known
from taskgist.world.stage import Stage

BEFORE_S = 0.3
"""How long before the first event a label starts."""
AFTER_S = 0.3
"""How long after the object has come to rest a label ends."""
MOVED_M = 0.02
"""How far an object must get away from where it was first, to be what a demonstration is about."""
LOOKS = 20
"""In as many frames of a turn it is looked whose hand is nearer."""
FARTHEST_M = 0.5
"""Beyond this, gaps are not measured."""
SURE = 0.995
"""From here on there is no doubt that is worth a word."""
TOO_LATE, UNENDED, UNSEEN, NOT_GIVEN = 0.7, 0.4, 0.3, 0.6
"""Confidence where the start is not seen, where the end is not, where it is not who takes the thing first, and where
nobody takes what is said to be given."""
UNSEEN_S = 0.5
"""Who has a thing at first is not seen where it is unknown for so long before somebody has it."""


@dataclass(frozen=True)
class Doubt:
    """One thing that a proposal hangs on.

    Attributes:
        confidence: From 0 (nothing speaks for it) to 1.
        reason: What was counted, in one clause.
    """

    confidence: float
    reason: str


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


@dataclass(frozen=True)
class _Ends:
    """Where a label may start and end for one object, how each was found, and what the start and all else hang on."""

    start_s: float
    start_how: str
    end_s: float
    end_how: str
    late: tuple[Doubt, ...]
    doubts: tuple[Doubt, ...]


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
    every = {name: turns_of(observer, name) for name in names}
    turns = {name: _within(every[name], span) for name in names}
    in_order = sorted((turn for each in turns.values() for turn in each), key=lambda turn: turn.start_s)
    changes = {name: changes_of_hands(observer, name, every[name]) for name in names}
    changes = {name: tuple(c for c in each if span[0] <= c.time_s <= span[1]) for name, each in changes.items()}
    agents = _given(target_agents)
    performer = performing_agent or _performer(recording, in_order, agents)
    given = {name: _given_by(changes[name], performer, agents) for name in names}
    targets = agents or _targets(recording, performer, in_order, [each[0] for each in given.values() if each])
    given = {name: _given_by(changes[name], performer, targets) for name in names}
    name_of_task = task or ("give" if all(given.values()) else None)
    if name_of_task is None:
        raise LabelError("the facts do not tell which task this is", field="task", hint="name it: --task show")
    acting = [name for name in names if turns[name] or _moves(observer, name)] or names
    ends = [_ends(recording, observer, name, turns[name], given[name], performer, span, settings) for name in acting]
    first, last = min(ends, key=lambda each: each.start_s), max(ends, key=lambda each: each.end_s)
    times = (
        _tidy(recording, first.start_s) if start_s is None else start_s,
        _tidy(recording, last.end_s) if end_s is None else end_s,
    )
    doubts = [each for found in ends for each in found.late]
    if not (performing_agent and agents and end_s is not None):
        doubts += [each for found in ends for each in found.doubts]
        if performing_agent is None:
            doubts += [each for name in acting for each in _unseen(observer, name, turns[name][:1])]
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


def _moves(observer: Observer, name: str) -> bool:
    return any(interval.value == v.MOVING for interval in observer.motion(name).intervals)


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


# --- From when to when.


def _ends(
    recording: Recording,
    observer: Observer,
    name: str,
    turns: tuple[Turn, ...],
    given: tuple[Change, ...],
    performer: str,
    span: tuple[float, float],
    settings: Settings,
) -> _Ends:
    own = [turn for turn in turns if turn.agent == performer]
    change = given[0] if given else None
    if change:
        own = [turn for turn in own if turn.start_s < change.taken_s][-1:]
    turn = own[0] if own else (turns[0] if turns else None)
    start_s, start_how, late = _start(recording, observer, name, turn, span, settings.checks)
    doubts: list[Doubt] = []
    if change:
        end_s, end_how = _change(observer, name, change)
        if len(given) > 1:
            doubts.append(Doubt(1.0 / len(given), f"{performer} gives {name} to {change.taker} {len(given)} times"))
        doubts.append(_nearer(recording, name, change, turn.start_s if turn else start_s))
    else:
        later = [each.start_s for each in turns if each.agent != performer and turn and each.start_s > turn.start_s]
        found = _rest(observer, name, after_s=start_s, until_s=min([*later, span[1]]))
        end_s, end_how = found or (float(recording.times_s[-1]), "ends with the recording")
        if not found and span[1] == math.inf:
            doubts.append(Doubt(UNENDED, f"the recording ends before {name} has come to rest or changed hands"))
    doubts += _unclear(observer, name, start_s, end_s)
    too_late = (Doubt(TOO_LATE, late),) if late else ()
    return _Ends(start_s, start_how, end_s, end_how, too_late, tuple(doubts))


def _known_s(observer: Observer, name: str, *, from_s: float, until_s: float) -> float:
    """The first moment in a span at which the object's placement is known; its start, if there is none."""
    known = (i for i in observer.placement(name).intervals if i.value.symbol is not None and i.end_s > from_s)
    moment = next((max(i.start_s, from_s) for i in known), from_s)
    return moment if moment < until_s else from_s


def _start(
    recording: Recording,
    observer: Observer,
    name: str,
    turn: Turn | None,
    span: tuple[float, float],
    limits: Checks,
) -> tuple[float, str, str]:
    """Just before the object is moved or leaves what it rests on, how that was found, and what is late about it."""
    first_s = max(float(recording.times_s[0]), span[0])
    known_s = _known_s(observer, name, from_s=first_s, until_s=float(recording.times_s[-1]))
    event_s = _event_s(observer, name, turn, known_s)
    if event_s is None:
        return known_s, "starts where the object is first known", ""
    still = [i.start_s for i in observer.motion(name).intervals if i.value == v.STATIC and i.start_s < event_s]
    start_s = max(known_s, still[-1] if still else known_s, event_s - BEFORE_S)
    late = ""
    if span[0] == -math.inf and event_s - first_s < limits.begins_s:
        late = f"the recording begins too late: {name} is moved {event_s - first_s:.2f} s after its first frame"
    return start_s, f"starts {event_s - start_s:.2g} s before the object is moved", late


def _event_s(observer: Observer, name: str, turn: Turn | None, known_s: float) -> float | None:
    """When the object leaves what it rests on to be held for a turn, or is moved there before, in seconds."""
    moving = [i for i in observer.motion(name).intervals if i.value == v.MOVING]
    later = [i.start_s for i in moving if i.start_s > known_s]
    if turn is None:
        return later[0] if later else None
    rests = [i for i in observer.placement(name).intervals if i.value.symbol in RESTING and i.start_s < turn.end_s]
    rests = [i for i in rests if i.start_s <= turn.start_s]
    if not rests:  # it was held from the first on
        during = [start_s for start_s in later if start_s < turn.end_s]
        return during[0] if during else known_s
    left_s = min(rests[-1].end_s, turn.start_s) if rests[-1].end_s > known_s else turn.start_s
    slid = [i.start_s for i in moving if i.start_s <= left_s <= i.end_s]
    return min(left_s, *slid) if slid else left_s


def _change(observer: Observer, name: str, change: Change) -> tuple[float, str]:
    """When it changes hands; where hands are hidden then, when it is first known thereafter where the object is."""
    end_s = _known_s(observer, name, from_s=change.time_s, until_s=change.kept_s)
    if change.released_s > change.taken_s:
        how = f"ends in the middle of the {change.released_s - change.taken_s:.2f} s in which both have it"
    else:
        how = "ends when it changes hands"
    return end_s, f"{how} ({change.giver} gives, {change.taker} takes)"


def _rest(observer: Observer, name: str, *, after_s: float, until_s: float) -> tuple[float, str] | None:
    """Just after the object has last come to rest before a time; None if it does not."""
    rests = [i for i in observer.motion(name).intervals if i.value == v.STATIC and after_s < i.start_s < until_s]
    if not rests:
        return None
    end_s = min(rests[-1].start_s + AFTER_S, max(rests[-1].end_s, rests[-1].start_s), until_s)
    return end_s, f"ends {end_s - rests[-1].start_s:.2g} s after the object comes to rest"


# --- How sure that is.


def _unclear(observer: Observer, name: str, start_s: float, end_s: float) -> tuple[Doubt, Doubt]:
    """How much of the time it is known who or what has the object, and how much of its way somebody carries it."""
    whole_s = max(end_s - start_s, 1e-9)
    placements = observer.placement(name).intervals
    unknown_s = sum(_shared_s(i.start_s, i.end_s, start_s, end_s) for i in placements if i.value.symbol is None)
    moving = [i for i in observer.motion(name).intervals if i.value == v.MOVING]
    moved_s = sum(_shared_s(i.start_s, i.end_s, start_s, end_s) for i in moving)
    alone_s = sum(
        _shared_s(max(i.start_s, j.start_s), min(i.end_s, j.end_s), start_s, end_s)
        for i in placements
        if i.value.symbol == v.IN_AIR
        for j in moving
    )
    known = f"in {_percent(unknown_s / whole_s)} of the time from start to end it is unknown who has {name}"
    carried = f"in {_percent(alone_s / max(moved_s, 1e-9))} of the time in which {name} moves nobody has it"
    return Doubt(1.0 - unknown_s / whole_s, known), Doubt(1.0 - alone_s / max(moved_s, 1e-9), carried)


def _unseen(observer: Observer, name: str, first: tuple[Turn, ...]) -> Iterator[Doubt]:
    """Whether somebody else may have had it before the first who is seen to."""
    for turn in first:
        for interval in observer.placement(name).intervals:
            lasts_s = turn.start_s - interval.start_s
            before = interval.value.symbol is None and interval.start_s < turn.start_s <= interval.end_s + BRIEF_S / 2
            if before and lasts_s >= UNSEEN_S:
                when = f"for {lasts_s:.2f} s before {turn.agent} has it"
                yield Doubt(UNSEEN, f"it is unknown who has {name} {when}, so it is not clear who performs")


def _shared_s(start_s: float, end_s: float, from_s: float, until_s: float) -> float:
    return max(min(end_s, until_s) - max(start_s, from_s), 0.0)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _nearer(recording: Recording, name: str, change: Change, start_s: float) -> Doubt:
    """Whose hands are nearer to the object while only one of the two has it.

    Where trackers are some centimetres off, another's hand is nearer for a while, and that says little; the doubt grows
    with the square of the time.
    """
    stage = Stage(recording.scene)
    spans = (
        (change.giver, change.taker, start_s, min(change.taken_s, change.released_s)),
        (change.taker, change.giver, max(change.taken_s, change.released_s), change.kept_s),
    )
    shares: list[float] = []
    for has, other, from_s, until_s in spans:
        first, last = (bisect_left(recording.times_s, time_s) for time_s in (from_s, until_s))
        gaps = [
            (_gap_m(stage.show(recording.state(index)), has, name), _gap_m(stage, other, name))
            for index in range(first, last, max((last - first) // LOOKS, 1))
        ]
        known = [(own, others) for own, others in gaps if own is not None and others is not None]
        shares.append(sum(own <= others for own, others in known) / len(known) if known else 1.0)
    share = min(shares)
    has, other, _, _ = spans[shares.index(share)]
    return Doubt(
        1.0 - (1.0 - share) ** 2,
        f"in {_percent(1.0 - share)} of the time in which {has} has {name}, {other}'s hand is nearer to it",
    )


def _gap_m(stage: Stage, agent: str, name: str) -> float | None:
    """From an agent's nearest hand to an object, metres; None if no hand, or not the object, was tracked."""
    body = stage.scene.agent(agent)
    if not stage.state.known([name]):
        return None
    gaps = [hand_gap_m(stage, arm, name, limit_m=FARTHEST_M) for arm in body.arms if hand_known(stage, body, arm)]
    return max(min(gaps), 0.0) if gaps else None
