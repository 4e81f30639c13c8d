"""An independent witness of holding: who grips by force, beside who holds by geometry.

Recordings may carry a signal ``AGENT_grip`` in newtons, measured by sensors in the object. Force and geometry mean
slightly different things: a hand may squeeze an object that still rests on a support, which nobody holds (8.5), and
fingers may rest around it before they squeeze. The comparison says by how much the two differ in time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from taskgist.errors import RecordingError
from taskgist.facts import vocabulary as v
from taskgist.observe.observer import Observer
from taskgist.recognition.turns import grips_of
from taskgist.recording.recording import Recording

GRIP_N = 3.0
"""Force above which a hand grips; the sensors' noise stays below 1 N."""
SUFFIX = "_grip"


@dataclass(frozen=True)
class GripCheck:
    """One agent's beginning or end of a hold, by force and by geometry, in seconds.

    Attributes:
        agent: Who.
        event: "takes" or "lets go".
        supported: Whether the object rested on a support then, so that geometry must say something else.
    """

    agent: str
    event: str
    by_force_s: float
    by_geometry_s: float
    supported: bool

    @property
    def difference_ms(self) -> float:
        """Geometry minus force, in milliseconds."""
        return 1000 * (self.by_geometry_s - self.by_force_s)


def check_grips(recording: Recording, observer: Observer, name: str) -> tuple[GripCheck, ...]:
    """Compare the first hold of each agent with its grip force.

    Args:
        recording: A recording with a signal ``AGENT_grip`` for each agent whose force was measured.
        observer: One of this recording.
        name: The object with the sensors.

    Raises:
        RecordingError: There are no such signals.
    """
    measured = [agent for agent in recording.scene.agents if agent + SUFFIX in recording.signals]
    if not measured:
        raise RecordingError("no grip forces", where=recording.name, field="signals", hint="name them AGENT_grip")
    checks: list[GripCheck] = []
    for agent in measured:
        held = [grip for grip in grips_of(observer, name) if grip.agent == agent]
        if held:
            checks += _compared(recording, observer, name, agent, (held[0].start_s, held[0].end_s))
    return tuple(checks)


def _compared(
    recording: Recording, observer: Observer, name: str, agent: str, held_s: tuple[float, float]
) -> list[GripCheck]:
    gripped = _gripped(recording, agent, around_s=sum(held_s) / 2)
    events = zip(("takes", "lets go"), gripped, held_s, strict=True)
    return [
        GripCheck(agent, event, force_s, geometry_s, _supported(observer, name, force_s))
        for event, force_s, geometry_s in events
    ]


def _gripped(recording: Recording, agent: str, around_s: float) -> tuple[float, float]:
    """The stretch of force around a time: its first and last moment in seconds."""
    pressing = recording.signals[agent + SUFFIX].values > GRIP_N
    middle = recording.index_at(around_s)
    before, after = np.flatnonzero(~pressing[:middle]), np.flatnonzero(~pressing[middle:])
    first = int(before[-1]) + 1 if len(before) else 0
    last = middle + int(after[0]) - 1 if len(after) else len(pressing) - 1
    return float(recording.times_s[first]), float(recording.times_s[last])


def _supported(observer: Observer, name: str, time_s: float) -> bool:
    placement = observer.placement(name).at(time_s)
    return placement is not None and placement.symbol == v.ON_SUPPORT
