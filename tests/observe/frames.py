"""Frames for tests, and what both observers say of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.observe import History, LazyObserver, Observer
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Scene, State


@dataclass(frozen=True)
class States:
    """States of one scene in order of time, as a recording has them."""

    states: Sequence[State]

    @property
    def times_s(self) -> NDArray[np.float64]:
        return np.array([state.time_s for state in self.states])

    def state(self, index: int) -> State:
        return self.states[index]


def said(history: History, time_s: float) -> dict[str, object]:
    """All that is confirmed at a time."""
    scene = history.scene
    return {
        **{f"{name} placement": history.placement(name).at(time_s) for name in scene.objects},
        **{f"{name} motion": history.motion(name).at(time_s) for name in scene.objects},
        **{f"{who} {side}": history.hand(who, side).at(time_s) for who in scene.agents for side in history.sides(who)},
        **{f"{who} posture": history.posture(who).at(time_s) for who in scene.agents},
        "holds": history.holds(time_s),
    }


def assert_same(scene: Scene, states: Sequence[State], every: int = 1, settings: Settings = DEFAULT) -> None:
    """Both observers say the same, whenever the lazy one is asked first."""
    full = Observer.of(scene, states, settings)
    lazy = LazyObserver(scene, States(states), settings)
    for state in reversed(states[::every]):
        assert said(lazy, state.time_s) == said(full, state.time_s), f"at {state.time_s:.3f} s"
