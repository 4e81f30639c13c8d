"""An observer says what one says that has watched all frames, looks at few of them, and lets more be appended."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import UnknownNameError
from taskgist.observe import Observer, Placement, snapshot
from taskgist.world import Fitter, Hold, Scene, Stage, State
from tests.observe.states import States, assert_confirmed_stands, assert_same
from tests.observe.step_by_step import Watching
from tests.scenes import TABLE, agent, box, cylinder, scene

RATE_HZ = 30.0
PALM = (-0.3, -0.15, 1.1)


@pytest.fixture(scope="module")
def room() -> Scene:
    """A hand beside a cup in the air; a mug on the table, and a box."""
    return scene(
        TABLE,
        cylinder("cup", *PALM),
        cylinder("mug", 0.2, 0.3, 0.77),
        box("box", 0.2, -0.2, 0.77, (0.05, 0.05, 0.05)),
        agents=agent("P1", -0.8, 0) + agent("P2", 0.9, 0, yaw_deg=180),
    )


@pytest.fixture(scope="module")
def reaching(room: Scene) -> State:
    return Fitter(room, "P1", moving="arms").fit(room.initial, points={"right_palm": PALM}).state


@dataclass(frozen=True)
class Stretch:
    """Some frames: how fast the agent and the cup go sideways, metres per second; where the cup is; what is lost."""

    frames: int
    agent_m_s: float
    cup_m_s: float
    drop_m: float
    lost: frozenset[str] = field(default_factory=frozenset)


STRETCHES = st.builds(
    Stretch,
    frames=st.integers(1, 9),
    agent_m_s=st.sampled_from([0.0, 0.0, 0.1, 0.2, 0.25, 0.4, -0.2]),
    cup_m_s=st.sampled_from([0.0, 0.0, 0.06, 0.08, 0.15, -0.3]),
    drop_m=st.sampled_from([0.0, 0.0, 0.0, 0.33]),
    lost=st.sampled_from([frozenset(), frozenset(), frozenset(), {"cup"}, {"P1/right_arm"}, {"P1"}, {"mug"}]).map(
        frozenset
    ),
)


def played(room: Scene, start: State, stretches: list[Stretch], gaps_s: list[float]) -> list[State]:
    """The states of these stretches; with the drop, the cup is on the table's height."""
    agent_m, cup_m, time_s, states = 0.0, 0.0, 0.0, list[State]()
    base, cup = room.base_slice("P1"), room.object_slice("cup")
    for stretch in stretches:
        for _ in range(stretch.frames):
            gap_s = gaps_s[len(states) % len(gaps_s)]
            time_s, agent_m = time_s + gap_s, agent_m + gap_s * stretch.agent_m_s
            cup_m += gap_s * stretch.cup_m_s
            qpos = np.array(start.qpos)
            qpos[base.start + 1] += agent_m
            qpos[cup.start + 1] += cup_m
            qpos[cup.start + 2] -= stretch.drop_m
            states.append(State(qpos, time_s, stretch.lost))
    return states


@settings(max_examples=25)
@given(
    st.lists(STRETCHES, min_size=1, max_size=8),
    st.lists(st.sampled_from([1 / 60, 1 / 30, 0.05, 0.21]), min_size=1, max_size=3),
)
def test_what_is_looked_up_is_what_was_watched_at_every_frame(
    room: Scene, reaching: State, stretches: list[Stretch], gaps_s: list[float]
) -> None:
    assert_same(room, played(room, reaching, stretches, gaps_s))


@settings(max_examples=8)
@given(
    st.lists(STRETCHES, min_size=1, max_size=6),
    st.lists(st.sampled_from([1 / 30, 0.05, 0.21]), min_size=1, max_size=3),
)
def test_what_was_confirmed_live_stands_when_all_frames_have_come(
    room: Scene, reaching: State, stretches: list[Stretch], gaps_s: list[float]
) -> None:
    assert_confirmed_stands(room, played(room, reaching, stretches, gaps_s))


def still_and_held(room: Scene, start: State) -> list[State]:
    """Ten seconds: the hand stays at the cup, and both go sideways in the middle."""
    stretches = [Stretch(140, 0.0, 0.0, 0.0), Stretch(20, 0.3, 0.3, 0.0), Stretch(140, 0.0, 0.0, 0.0)]
    return played(room, start, stretches, [1 / RATE_HZ])


@dataclass(frozen=True)
class Counted(States):
    """Frames that note which of them were looked at."""

    looked_at: set[int] = field(default_factory=set)

    def state(self, index: int) -> State:
        self.looked_at.add(index)
        return super().state(index)


def test_of_what_rests_few_frames_are_looked_at(room: Scene, reaching: State) -> None:
    """All about the mug, though the hand is at the cup all the time."""
    frames = Counted(still_and_held(room, reaching))
    observer = Observer(room, frames)
    for index in (10, 290):
        time_s = frames.states[index].time_s
        assert observer.placement("mug").at(time_s) == Placement("On_Support", ("table",))
        assert observer.motion("mug").at(time_s) == "Static"
    assert len(frames.looked_at) < 2 * 15, "a fifth of a second, and the window of the speed before and behind it"


def test_what_hands_may_hold_is_looked_at_between_two_moments_of_rest_and_not_beyond(
    room: Scene, reaching: State
) -> None:
    """Seconds of lying on the table before and behind; ten and more of them in the hand."""
    lying, held = Stretch(200, 0.0, 0.0, 0.33), Stretch(30, 0.3, 0.3, 0.0)
    frames = Counted(played(room, reaching, [lying, held, lying], [1 / RATE_HZ]))
    assert "P1's right hand" in str(Observer(room, frames).placement("cup").at(frames.states[215].time_s))
    assert frames.looked_at <= set(range(190, 240))
    longer = Counted(played(room, reaching, [lying, Stretch(2000, 0.3, 0.3, 0.0)], [1 / RATE_HZ]))
    assert "P1's right hand" in str(Observer(room, longer).placement("cup").at(longer.states[1000].time_s))
    assert len(longer.looked_at) < 21 * RATE_HZ, "ten seconds, and five before and behind them"


def test_a_snapshot_is_the_same_from_either(room: Scene, reaching: State) -> None:
    states = still_and_held(room, reaching)[::3]
    observers = (Observer(room, States(states)), cast(Observer, Watching.of(room, states)))
    for state in (states[3], states[50], states[-1]):
        for who in room.agents:
            found = [snapshot(Stage(room, state), observer, agent=who, name="cup") for observer in observers]
            assert found[0] == found[1]
            assert found[0]["placement"].evidence["by"] == ("P1's right hand",)


def test_how_it_goes_on_decides_who_held_it(room: Scene, reaching: State) -> None:
    """Two seconds with the hand at the cup, which then stays, or comes along: the same frames, another answer."""
    at_it = Stretch(4, 0.0, 0.0, 0.0)
    held = {}
    for cup_m_s in (0.0, 0.4):
        states = played(room, reaching, [Stretch(20, 0.4, 0.0, 0.0), at_it, Stretch(20, 0.4, cup_m_s, 0.0)], [1 / 30])
        states = [State(_aside(room, state, 20 * 0.4 / 30), state.time_s) for state in states]
        assert_same(room, states)
        held[cup_m_s] = Observer(room, States(states)).holds(states[22].time_s)
    assert held == {0.0: (), 0.4: (Hold("P1", "right", "cup"),)}


def _aside(room: Scene, state: State, aside_m: float) -> np.ndarray:
    qpos = np.array(state.qpos)
    qpos[room.base_slice("P1").start + 1] -= aside_m
    return qpos


def test_what_was_never_confirmed_is_unknown(room: Scene, reaching: State) -> None:
    lone = States([State(reaching.qpos, 1.0)])
    observer = Observer(room, lone)
    assert observer.posture("P1").at(1.0) is None
    assert observer.placement("cup").at(0.5) is None
    assert observer.holds(1.0) == ()


def test_unknown_names_are_named(room: Scene, reaching: State) -> None:
    observer = Observer(room, States([reaching]))
    with pytest.raises(UnknownNameError, match="did you mean 'cup'"):
        observer.placement("cups")
    with pytest.raises(UnknownNameError, match="did you mean 'mug'"):
        observer.motion("mugs")
    with pytest.raises(UnknownNameError, match="known: P1, P2"):
        observer.posture("P3")
    with pytest.raises(UnknownNameError, match="known: P1, P2"):
        observer.hand("P3", "left")
