"""Proposing a label from the facts: who did what for whom, from when to when.

The object that is taken in a hand or set in motion is the target object; who takes it first performs; the target agent
is who holds it in the end, if that is somebody else, and otherwise the other agent. The label starts while the
object still lies still, just before anything touches it, and ends when the performer lets go (a handover), or
when the object has come to rest where it stays. What the task is called only people know; a handover is proposed as
*give*.

Of several objects that are named, each is looked at in this way: the label starts before the first of them is moved and
ends after the last has been given or has come to rest.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from taskgist.errors import LabelError
from taskgist.facts import vocabulary as v
from taskgist.observe.observer import Observer
from taskgist.recording.recording import Label, Recording

BEFORE_S = 0.3
"""How long before the first event a label starts."""
SETTLED_S = 0.1
"""How long after a handover a label ends, so that it hangs on no single frame."""
AFTER_S = 0.3
"""How long after the object has come to rest a label ends."""
MOVED_M = 0.02
"""How far an object must get away from where it was first, to be what a demonstration is about."""


@dataclass(frozen=True)
class Grip:
    """One hand holds the object from ``start_s`` until ``end_s``, in seconds."""

    agent: str
    side: str
    start_s: float
    end_s: float


def grips_of(observer: Observer, name: str) -> tuple[Grip, ...]:
    """Who holds an object when, in order of time."""
    scene = observer.scene
    grips = [
        Grip(agent, side, interval.start_s, interval.end_s)
        for agent in scene.agents
        for side in scene.agent(agent).sides
        for interval in observer.hand(agent, side).intervals
        if interval.value.symbol == v.HOLDING_OBJECT and interval.value.thing == name
    ]
    return tuple(sorted(grips, key=lambda grip: (grip.start_s, grip.agent, grip.side)))


def propose_label(
    recording: Recording,
    observer: Observer,
    *,
    task: str | None = None,
    target_objects: str | Sequence[str] = (),
    performing_agent: str | None = None,
    target_agents: str | Sequence[str] = (),
) -> Label:
    """Propose a label; what is given is kept.

    Args:
        recording: The recording.
        observer: One of this recording.
        task: Name of the task.
        target_objects: The object, or several; none: the one that gets farthest away from where it was.
        performing_agent: Who performs.
        target_agents: For whom; none: who holds the object in the end, or the only other agent.

    Raises:
        LabelError: Nothing happens that would tell, or it does not tell which task it is.
    """
    names = _given(target_objects) or (_moved_most(recording),)
    grips = {name: grips_of(observer, name) for name in names}
    in_order = tuple(sorted((grip for each in grips.values() for grip in each), key=lambda grip: grip.start_s))
    agents = _given(target_agents)
    performer = performing_agent or _performer(recording, in_order, agents)
    receiver = next((grip.agent for grip in in_order if grip.agent != performer), None)
    targets = agents or (receiver or _other(recording, performer),)
    handovers = {name: _handover(observer, name, grips[name], performer, targets) for name in names}
    name_of_task = task or ("give" if all(handovers.values()) else None)
    if name_of_task is None:
        raise LabelError("the facts do not tell which task this is", field="task", hint="name it: --task show")
    start, start_how = min(_start(recording, observer, name, grips[name]) for name in names)
    end, end_how = max(handovers[name] or _rest(recording, observer, name, after_s=start) for name in names)
    times = (_tidy(recording, start), _tidy(recording, end))
    return Label(name_of_task, performer, targets, names, *times, f"proposed: {start_how}; {end_how}")


def _given(names: str | Sequence[str]) -> tuple[str, ...]:
    return (names,) if isinstance(names, str) else tuple(names)


def _tidy(recording: Recording, time_s: float) -> float:
    """To the millisecond, inside of the recording."""
    return min(max(round(time_s, 3), float(recording.times_s[0])), float(recording.times_s[-1]))


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


def _performer(recording: Recording, grips: tuple[Grip, ...], targets: tuple[str, ...]) -> str:
    if grips:
        return next((grip.agent for grip in grips if grip.agent not in targets), grips[0].agent)
    if targets:
        return _other(recording, *targets)
    raise LabelError("nobody is seen to hold the object", field="performing_agent", hint="name it: --performer P1")


def _other(recording: Recording, *agents: str) -> str:
    others = [name for name in recording.scene.agents if name not in agents]
    if len(others) != 1:
        raise LabelError("which agent is the target is not clear", field="target_agent", hint="name it: --target P2")
    return others[0]


def _handover(
    observer: Observer, name: str, grips: tuple[Grip, ...], performer: str, targets: tuple[str, ...]
) -> tuple[float, str] | None:
    """The moment at which a target agent holds the object and the performer no longer does.

    Where hands are hidden at that moment, the first one thereafter at which it is known where the object is.
    """
    grip_of_target = next((grip for grip in grips if grip.agent in targets), None)
    if grip_of_target is None:
        return None
    taken, held_until = grip_of_target.start_s, grip_of_target.end_s
    released = max((g.end_s for g in grips if g.agent == performer and g.start_s <= taken), default=None)
    if released is None:
        return None
    event = _placement_known(observer, name, from_s=max(released, taken), until_s=held_until)
    end = min(event + SETTLED_S, (event + held_until) / 2)
    return end, f"ends {SETTLED_S} s after {performer} has let go, while {grip_of_target.agent} holds it"


def _placement_known(observer: Observer, name: str, *, from_s: float, until_s: float) -> float:
    """The first moment in a span at which the object's placement is known; its start, if there is none."""
    known = (i for i in observer.placement(name).intervals if i.value.symbol is not None and i.end_s > from_s)
    moment = next((max(i.start_s, from_s) for i in known), from_s)
    return moment if moment < until_s else from_s


def _start(recording: Recording, observer: Observer, name: str, grips: tuple[Grip, ...]) -> tuple[float, str]:
    """Just before the object is first moved or held, while it still lies still and its place is known."""
    first_s, last_s = float(recording.times_s[0]), float(recording.times_s[-1])
    known = _placement_known(observer, name, from_s=first_s, until_s=last_s)
    motion = observer.motion(name).intervals
    moving = [i.start_s for i in motion if i.value == v.MOVING and i.start_s > known]
    events = [*moving[:1], *(grip.start_s for grip in grips if grip.start_s > known)]
    if not events:
        return known, "starts where the object is first known"
    event = min(events)
    still = [i.start_s for i in motion if i.value == v.STATIC and i.start_s < event]
    start = max(known, still[-1] if still else known, event - BEFORE_S)
    return start, f"starts {event - start:.2g} s before the object is moved"


def _rest(recording: Recording, observer: Observer, name: str, *, after_s: float) -> tuple[float, str]:
    """Just after the object has last come to rest."""
    last = float(recording.times_s[-1])
    still = [i.start_s for i in observer.motion(name).intervals if i.value == v.STATIC and i.start_s > after_s]
    if not still:
        return last, "ends with the recording"
    return min(last, still[-1] + AFTER_S), f"ends {AFTER_S} s after the object comes to rest"
