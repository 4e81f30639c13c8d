"""An observer that says what a test tells it, of two people and a cup: intervals of hands, placement and motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import SimpleNamespace
from typing import cast

from taskgist.facts import vocabulary as v
from taskgist.observe import HandStatus, Interval, Observer, Placement
from taskgist.world import Scene
from tests.pipeline.small import room

Held = tuple[str, float, float]
"""Who holds the cup with the right hand, from when to when, seconds."""


@dataclass(frozen=True)
class Told:
    """All that is known.

    Attributes:
        held: Who holds the cup when.
        moving: From when to when it moves.
        unknown: From when to when it is unknown where it is.
        air: From when to when it is in the air.
        end_s: When the recording ends; the cup is on the table where nothing else is said.
    """

    held: Sequence[Held] = ()
    moving: Sequence[tuple[float, float]] = ()
    unknown: Sequence[tuple[float, float]] = ()
    air: Sequence[tuple[float, float]] = ()
    end_s: float = 10.0
    scene: Scene = field(default_factory=room)

    def observer(self) -> Observer:
        """It, as an observer."""
        return cast(Observer, self)

    def hand(self, agent: str, side: str) -> object:
        own = [(start, end) for who, start, end in self.held if (who, side) == (agent, "right")]
        spans = [Interval(HandStatus(v.HOLDING_OBJECT, "cup"), *span) for span in own]
        return SimpleNamespace(intervals=tuple(spans))

    def placement(self, name: str) -> object:
        assert name == "cup"
        edges = {0.0, self.end_s}
        for start, end in (*((start, end) for _, start, end in self.held), *self.unknown, *self.air):
            edges |= {start, end}
        spans = [Interval(self._placed((a + b) / 2), a, b) for a, b in pairwise(sorted(edges))]
        return SimpleNamespace(intervals=tuple(spans))

    def motion(self, name: str) -> object:
        assert name == "cup"
        edges = sorted({0.0, self.end_s, *(time for span in self.moving for time in span)})
        moves = [any(start <= a < end for start, end in self.moving) for a, _ in pairwise(edges)]
        values = [v.MOVING if each else v.STATIC for each in moves]
        return SimpleNamespace(
            intervals=tuple(Interval(value, *span) for value, span in zip(values, pairwise(edges), strict=True))
        )

    def _placed(self, time_s: float) -> Placement:
        if any(start < time_s < end for start, end in self.unknown):
            return Placement(None)
        if any(start < time_s < end for start, end in self.air):
            return Placement(v.IN_AIR)
        who = [f"{agent}'s right hand" for agent, start, end in self.held if start < time_s < end]
        return Placement(v.IN_HAND, tuple(who)) if who else Placement(v.ON_SUPPORT, ("table",))
