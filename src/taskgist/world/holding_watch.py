"""Holding over time: a held object moves with the hand.

A hand that passes an object, or reaches around it before it closes, is near and yet does not hold. What tells them
apart is
slip: how fast the hand moves in the object's own frame. A ``HoldingWatch`` takes states as they come and gives them
back, half a window later, with ``State.holding`` decided: a near hand begins to hold when its slip is low, and lets
go when the slip is high or the hand is far.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from taskgist.settings import Contact
from taskgist.world.holding import hand_known, is_near
from taskgist.world.scene import Scene
from taskgist.world.stage import Stage
from taskgist.world.state import Hold, State

Places = dict[Hold, NDArray[np.float64] | None]
"""Place of each palm in each object's frame, metres, (3,); None where one of them was not tracked."""


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
        self._window: deque[tuple[State, Places, frozenset[Hold]]] = deque()
        self._next = 0
        self._held: frozenset[Hold] = frozenset()

    def update(self, state: State) -> Iterator[State]:
        """Take the next state; yields those that can be decided now, in order."""
        self._stage.show(state)
        self._window.append((state, self._places(), self._near()))
        half = self._settings.slip_window_s / 2
        while self._next < len(self._window) and self._window[self._next][0].time_s + half <= state.time_s + 1e-9:
            yield self._decided()

    def finish(self) -> Iterator[State]:
        """Decide the states that still wait, by what has been seen of their windows."""
        while self._next < len(self._window):
            yield self._decided()

    def _decided(self) -> State:
        half = self._settings.slip_window_s / 2
        state, _, near = self._window[self._next]
        while self._window[0][0].time_s < state.time_s - half - 1e-9:
            self._window.popleft()
            self._next -= 1
        last = next(entry for entry in reversed(self._window) if entry[0].time_s <= state.time_s + half + 1e-9)
        self._held = frozenset(hold for hold in near if self._stays(hold, self._window[0], last))
        self._next += 1
        return state.with_holding(self._held)

    def _stays(
        self,
        hold: Hold,
        first: tuple[State, Places, frozenset[Hold]],
        last: tuple[State, Places, frozenset[Hold]],
    ) -> bool:
        """Whether a near hand moves with the object, from the first to the last state of the window."""
        start, end = first[1][hold], last[1][hold]
        span = last[0].time_s - first[0].time_s
        if start is None or end is None or span <= 0:
            return True  # nothing is known but that the hand is near
        limit = self._settings.slip_stop_m_s if hold in self._held else self._settings.slip_start_m_s
        return float(np.linalg.norm(end - start)) / span < limit

    def _places(self) -> Places:
        scene, stage = self._stage.scene, self._stage
        places: Places = {}
        for hold, (agent, arm) in self._arms.items():
            known = hand_known(stage, agent, arm) and stage.state.known([hold.object])
            pose = stage.body(scene.object_body(hold.object))
            places[hold] = pose.to_local(stage.site(arm.palm_site).position) if known else None
        return places

    def _near(self) -> frozenset[Hold]:
        stage = self._stage
        return frozenset(
            hold
            for hold, (agent, arm) in self._arms.items()
            if hand_known(stage, agent, arm)
            and stage.state.known([hold.object])
            and is_near(stage, arm, hold.object, self._settings)
        )
