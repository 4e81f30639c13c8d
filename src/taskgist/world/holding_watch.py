"""Holding over time: a held object moves with the hand.

A hand that passes an object, or reaches around it before it closes, is near and yet does not hold. What tells them
apart is slip: how fast the hand moves in the object's own frame. A ``HoldingWatch`` takes states as they come and gives
them back, half a window later, with ``State.holding`` decided: a near hand begins to hold when its slip is low, and
lets go when the slip is high or the hand is far.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.body.agent import Agent, ArmIndices
from taskgist.world.holding import hand_known, is_near
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State
from taskgist.world.window import Around, SlidingWindow, velocity


@dataclass(frozen=True, eq=False)
class Hands:
    """A state and its hands.

    Attributes:
        near: The hands that are near to objects.
        places: Place of each palm in each object's frame, metres, (3,), where both were tracked.
    """

    state: State
    near: frozenset[Hold]
    places: dict[Hold, NDArray[np.float64]]


class HoldingWatch:
    """Decides who holds what in states that follow each other.

    Args:
        scene: Their scene.
        settings: Distances, speeds and the window.
    """

    def __init__(self, scene: Scene, settings: Contact) -> None:
        self._settings = settings
        self._stage = Stage(scene)
        self._arms = {
            Hold(agent, arm.profile.side, name): (scene.agent(agent), arm)
            for agent in scene.agents
            for arm in scene.agent(agent).arms
            for name in scene.objects
        }
        self._window: SlidingWindow[Hands] = SlidingWindow(settings.slip_window_s)
        self._held: frozenset[Hold] = frozenset()

    def update(self, state: State) -> Iterator[State]:
        """Take the next state; yields those that can be decided now, in order."""
        yield from map(self._decided, self._window.push(state.time_s, self._hands(state)))

    def finish(self) -> Iterator[State]:
        """Decide the states that still wait, by what has been seen of their windows."""
        yield from map(self._decided, self._window.finish())

    def _decided(self, around: Around[Hands]) -> State:
        self._held = frozenset(hold for hold in around.item.near if self._stays(hold, around))
        return around.item.state.with_holding(self._held)

    def _stays(self, hold: Hold, around: Around[Hands]) -> bool:
        """Whether a near hand moves with the object in the window; where that is unknown, near is all there is."""
        frames = zip(around.times_s, around.items, strict=True)
        known = [(time_s, hands.places[hold]) for time_s, hands in frames if hold in hands.places]
        slip = velocity([time_s for time_s, _ in known], [place for _, place in known])
        limit = self._settings.slip_stop_m_s if hold in self._held else self._settings.slip_start_m_s
        return slip is None or float(np.linalg.norm(slip)) < limit

    def _hands(self, state: State) -> Hands:
        stage = self._stage.show(state)
        known = {hold: arms for hold, arms in self._arms.items() if self._known(hold, *arms)}
        near = (hold for hold, (_, arm) in known.items() if is_near(stage, arm, hold.object, self._settings))
        return Hands(state, frozenset(near), {hold: self._place(hold, arm) for hold, (_, arm) in known.items()})

    def _known(self, hold: Hold, agent: Agent, arm: ArmIndices) -> bool:
        return hand_known(self._stage, agent, arm) and self._stage.state.known([hold.object])

    def _place(self, hold: Hold, arm: ArmIndices) -> NDArray[np.float64]:
        pose = self._stage.body(self._stage.scene.object_body(hold.object))
        return pose.to_local(self._stage.site(arm.palm_site).position)
