"""What is confirmed of hands, postures, placements and motion over time: all that a snapshot asks of the past."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Protocol, TypeVar

from taskgist.facts import vocabulary as v
from taskgist.observe.status import HandUse, Placed
from taskgist.world import Hold, Scene, State

V = TypeVar("V", covariant=True)


class Confirmed(Protocol[V]):
    """The confirmed values of one fact."""

    def at(self, time_s: float) -> V | None:
        """The confirmed value at a time, as it last was by then; None before anything was confirmed."""


class History(ABC):
    """Confirmed facts of one scene over time. Whoever has them all gives the same answers, however they were found.

    Args:
        scene: The scene.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    @abstractmethod
    def placement(self, name: str) -> Confirmed[Placed]:
        """Placement of an object over time.

        Raises:
            UnknownNameError: There is no such object.
        """

    @abstractmethod
    def motion(self, name: str) -> Confirmed[str | None]:
        """Motion of an object over time; None is unknown.

        Raises:
            UnknownNameError: There is no such object.
        """

    @abstractmethod
    def hand(self, agent: str, side: str) -> Confirmed[HandUse]:
        """Use of a hand over time.

        Raises:
            UnknownNameError: There is no such agent, or it has no such hand.
        """

    @abstractmethod
    def posture(self, agent: str) -> Confirmed[str | None]:
        """Posture of an agent over time; None is unknown.

        Raises:
            UnknownNameError: There is no such agent.
        """

    def sides(self, agent: str) -> tuple[str, ...]:
        """Sides on which an agent has a hand."""
        return self.scene.agent(agent).sides

    def holds(self, time_s: float) -> tuple[Hold, ...]:
        """Which hands hold what at a time, as confirmed."""
        hands = ((agent, side) for agent in self.scene.agents for side in self.sides(agent))
        return tuple(
            Hold(agent, side, use.of)
            for agent, side in hands
            if (use := self.hand(agent, side).at(time_s)) and use.symbol == v.HOLDING_OBJECT and use.of
        )

    def decided(self, state: State) -> State:
        """A state with who holds what in it, as confirmed at its time: what perspective should start from."""
        return state.with_holding(self.holds(state.time_s))
