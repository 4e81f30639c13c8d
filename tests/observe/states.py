"""States for tests as frames of a recording, and what observers say of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from taskgist.observe import FrameSequence, Interval, Observer
from taskgist.settings import DEFAULT, Settings
from taskgist.world import Scene, State
from tests.observe.step_by_step import Watching
from tests.scenes import TABLE, agent, cylinder, scene

RATE_HZ = 20.0
TOP = 0.72
"""Height of the table's top, metres."""


def cup_between_two(*more: str) -> Scene:
    """A cup on a table, and what else is, between P1 and P2, who face one another."""
    cup = cylinder("cup", -0.25, -0.15, TOP + 0.05)
    return scene(TABLE, cup, *more, agents=agent("P1", -0.8, 0) + agent("P2", 0.8, 0, yaw_deg=180))


@dataclass(frozen=True)
class States:
    """States of one scene in order of time, as a recording has them."""

    states: Sequence[State]

    @property
    def times_s(self) -> NDArray[np.float64]:
        return np.array([state.time_s for state in self.states])

    def state(self, index: int) -> State:
        return self.states[index]


def sequence(times_s: Sequence[float], window_s: float = 0.0) -> FrameSequence:
    """Frames of which nothing but the times matters."""
    return FrameSequence(window_s, States([State(np.empty(0), time_s) for time_s in times_s]))


def said(observer: Observer | Watching, time_s: float) -> dict[str, object]:
    """All that is confirmed at a time."""
    scene, found = observer.scene, dict[str, object]()
    for name in scene.objects:
        found |= {
            f"{name} placement": observer.placement(name).at(time_s),
            f"{name} motion": observer.motion(name).at(time_s),
        }
    for who in scene.agents:
        found |= {f"{who} {side}": observer.hand(who, side).at(time_s) for side in scene.agent(who).sides}
        found[f"{who} posture"] = observer.posture(who).at(time_s)
    return found | {"holds": observer.holds(time_s)}


def intervals(observer: Observer | Watching) -> dict[str, list[tuple[object, float, float]]]:
    """All intervals of each fact: value, start and end in seconds."""
    scene = observer.scene
    facts: dict[str, tuple[Interval[Any], ...]] = {}
    for name in scene.objects:
        facts |= {
            f"{name} placement": observer.placement(name).intervals,
            f"{name} motion": observer.motion(name).intervals,
        }
    for who in scene.agents:
        facts |= {f"{who} {side}": observer.hand(who, side).intervals for side in scene.agent(who).sides}
        facts[f"{who} posture"] = observer.posture(who).intervals
    return {fact: [(i.value, i.start_s, i.end_s) for i in found] for fact, found in facts.items()}


def live(scene: Scene, states: Sequence[State], settings: Settings = DEFAULT) -> Observer:
    """An observer to which these states have been appended; more may come."""
    observer = Observer(scene, settings=settings)
    for state in states:
        observer.append(state)
    return observer


def assert_same(scene: Scene, states: Sequence[State], every: int = 1, settings: Settings = DEFAULT) -> None:
    """What is looked up says what watching says, whenever it is asked first, and so does what was appended."""
    watched = Watching.of(scene, states, settings)
    looked_up, appended = Observer(scene, States(states), settings), live(scene, states, settings)
    appended.finish()
    for state in reversed(states[::every]):
        assert said(looked_up, state.time_s) == said(watched, state.time_s), f"at {state.time_s:.3f} s"
    assert intervals(looked_up) == intervals(watched)
    for name in scene.objects:
        assert appended.motion(name).intervals == looked_up.motion(name).intervals
    for who in scene.agents:
        assert appended.posture(who).intervals == looked_up.posture(who).intervals


def assert_confirmed_stands(scene: Scene, states: Sequence[State]) -> None:
    """Live, at every frame: what has been confirmed of each fact is the beginning of what will be said in the end.

    And whatever was asked too early spoils no later answer.
    """
    growing, asked_late = Observer(scene), live(scene, states)
    asked_late.finish()
    whole = intervals(asked_late)
    for state in states:
        growing.append(state)
        said(growing, state.time_s)
        for fact, found in intervals(growing).items():
            confirmed = [(value, start_s) for value, start_s, _ in found]
            assert confirmed == [(value, start_s) for value, start_s, _ in whole[fact][: len(confirmed)]], fact
    growing.finish()
    assert intervals(growing) == whole
