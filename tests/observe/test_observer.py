"""A hand takes a cup from a table, carries it, and lets go of it in the air (a script without perspective)."""

import numpy as np
import pytest

from taskgist.errors import UnknownNameError
from taskgist.facts import UNKNOWN
from taskgist.observe import Observer, snapshot
from taskgist.settings import DEFAULT
from taskgist.world import Fitter, Hold, Scene, Stage, State
from tests.observe.states import RATE_HZ, TOP, States, cup_between_two
from tests.scenes import cylinder


@pytest.fixture(scope="module")
def room() -> Scene:
    return cup_between_two()


@pytest.fixture(scope="module")
def carried(room: Scene) -> list[State]:
    """One second each: still, lifted by the hand, held, and the hand gone."""
    fitter = Fitter(room, "P1", moving="arms", weights={"right_palm": 3.0})
    arm = room.agent("P1").arm("right")
    cup, states, state = np.array([-0.25, -0.15, TOP + 0.05]), [], room.initial
    for frame in range(int(4 * RATE_HZ)):
        time = frame / RATE_HZ
        height = TOP + 0.08 + 0.3 * np.clip(time - 1, 0, 1)
        target = np.array([-0.27, -0.16, height]) if time < 3 else np.array([-0.5, -0.4, 1.2])
        state = fitter.fit(state, points={"right_palm": target}).state
        if 1 <= time < 3:
            cup = Stage(room, state).site(arm.palm_site).position + (0.02, 0.01, -0.03)
        states.append(State(state.replace(at=room.object_slice("cup"), to=(*cup, 1, 0, 0, 0)).qpos, time))
    return states


def test_the_story_is_told_in_order(room: Scene, carried: list[State]) -> None:
    observer = Observer(room, States(carried))
    assert [i.value.symbol for i in observer.placement("cup").intervals] == ["On_Support", "In_Hand", "In_Air"]
    held = observer.placement("cup").intervals[1]
    assert held.value.by == ("P1's right hand",)
    assert held.start_s == pytest.approx(1.0, abs=0.15)
    assert held.end_s == pytest.approx(3.0, abs=0.15)
    assert [i.value for i in observer.motion("cup").intervals] == ["Static", "Moving", "Static"]
    assert {i.value.symbol for i in observer.hand("P2", "left").intervals} == {"Free_of_Object"}


def test_live_facts_once_confirmed_equal_offline_facts(room: Scene, carried: list[State]) -> None:
    offline, live = Observer(room, States(carried)), Observer(room)
    for state in carried:
        live.append(state)
        for now, then in (
            (live.placement("cup"), offline.placement("cup")),
            (live.motion("cup"), offline.motion("cup")),
            (live.hand("P1", "right"), offline.hand("P1", "right")),
        ):
            confirmed = [(i.value, i.start_s) for i in now.intervals]
            assert confirmed == [(i.value, i.start_s) for i in then.intervals[: len(confirmed)]]


def test_holding_is_the_same_for_facts_and_perspective(room: Scene, carried: list[State]) -> None:
    observer = Observer(room, States(carried))
    held = snapshot(Stage(room, carried[50]), observer, agent="P1", name="cup")
    assert held["reach.effort"].value == held["grasp.effort"].value == "No_Effort_Required"
    assert held["hands"].value == {"left": "Free_of_Object", "right": "Holding_Object"}
    assert observer.as_confirmed(carried[50]).holding == frozenset({Hold("P1", "right", "cup")})
    assert observer.as_confirmed(carried[5]).holding == frozenset()


def test_what_stands_is_not_held_however_the_hand_trembles_at_it(room: Scene, carried: list[State]) -> None:
    """Put down again; then the hand is now at the cup, now off it: nothing of what it does there lasts."""
    lifted, column = carried[: int(2 * RATE_HZ)], room.object_slice("cup")
    standing, at_it, off_it = lifted[0].qpos[column], lifted[int(1.2 * RATE_HZ)], lifted[0]
    trembling = [(at_it if frame % 4 < 2 else off_it).replace(at=column, to=standing) for frame in range(20)]
    states = [
        State(state.qpos, frame / RATE_HZ) for frame, state in enumerate([*lifted, *reversed(lifted), *trembling])
    ]
    observer = Observer(room, States(states))
    told = [(observer.placement("cup").at(state.time_s), observer.holds(state.time_s)) for state in states]
    assert any(holds for _, holds in told)
    assert all(placed is not None and placed.symbol == "In_Hand" for placed, holds in told if holds)


def test_a_passing_hand_holds_nothing(room: Scene) -> None:
    """Near, but faster than any grip slips."""
    states = []
    for frame in range(40):
        time = frame / RATE_HZ
        fit = Fitter(room, "P1", moving="arms").fit(room.initial, points={"right_palm": (-0.3, -0.7 + 0.7 * time, 1.1)})
        places = (-0.3, -0.15, 1.1)
        states.append(State(fit.state.replace(at=room.object_slice("cup"), to=(*places, 1, 0, 0, 0)).qpos, time))
    near = [
        Stage(room, s).closest(room.agent("P1").arm("right").hand_geoms, room.object_geoms("cup"), limit_m=0.03)[0]
        for s in states
    ]
    assert min(near) < DEFAULT.contact.grip_m
    observer = Observer(room, States(states))
    assert {i.value.symbol for i in observer.hand("P1", "right").intervals} == {"Free_of_Object"}


def test_untracked_is_unknown_never_false(room: Scene, carried: list[State]) -> None:
    lost = [State(s.qpos, s.time_s, frozenset({"cup"}) if s.time_s >= 2 else frozenset()) for s in carried]
    observer = Observer(room, States(lost))
    found = snapshot(Stage(room, lost[70]), observer, agent="P2", name="cup")
    unknown = {name for name, observation in found.items() if observation.value is UNKNOWN}
    assert {"placement", "motion", "visibility.score", "see.effort", "reach.effort", "grasp.effort"} <= unknown
    armless = [State(s.qpos, s.time_s, frozenset({"P1/right_arm"})) for s in carried]
    lone = Observer(room, States(armless))
    assert lone.placement("cup").at(2.0) is not None
    assert lone.placement("cup").at(2.0).symbol is None  # type: ignore[union-attr]
    assert lone.hand("P1", "right").at(2.0).symbol is None  # type: ignore[union-attr]


def test_unknown_names_are_named(room: Scene) -> None:
    observer = Observer(room)
    with pytest.raises(UnknownNameError, match="did you mean 'cup'"):
        observer.placement("cups")
    with pytest.raises(UnknownNameError, match="known: P1, P2"):
        observer.posture("P3")


def test_holding_something_else_is_told_apart(room: Scene, carried: list[State]) -> None:
    both = cup_between_two(cylinder("mug", 0.2, 0.3, TOP + 0.05))
    assert both.nq == room.nq + 7
    states = []
    for state in carried:
        qpos = np.array(both.initial.qpos)
        for name in room.agents:
            qpos[both.base_slice(name)] = state.qpos[room.base_slice(name)]
            qpos[both.joint_indices(name)] = state.qpos[room.joint_indices(name)]
        qpos[both.object_slice("cup")] = state.qpos[room.object_slice("cup")]
        states.append(State(qpos, state.time_s))
    observer = Observer(both, States(states))
    found = snapshot(Stage(both, states[50]), observer, agent="P1", name="mug")
    assert found["hands"].value == {"left": "Free_of_Object", "right": "Holding_Other_Object"}


@pytest.mark.parametrize("every", [1, 2, 4])
def test_the_story_does_not_depend_on_the_frame_rate(room: Scene, carried: list[State], every: int) -> None:
    observer = Observer(room, States(carried[::every]))
    assert [i.value.symbol for i in observer.placement("cup").intervals] == ["On_Support", "In_Hand", "In_Air"]
    assert [i.value for i in observer.motion("cup").intervals] == ["Static", "Moving", "Static"]


@pytest.mark.parametrize("speed_m_s", [0.35, 0.45, 0.6])
def test_a_hand_that_only_slows_down_does_not_begin_to_hold(room: Scene, speed_m_s: float) -> None:
    """It goes on, along a thing that stays where it is."""
    fitter, states = Fitter(room, "P1", moving="arms"), []
    for frame in range(30):
        time = frame / RATE_HZ
        palm = (-0.3, -0.15 + speed_m_s * (time - 0.75), 1.1)
        fit = fitter.fit(room.initial, points={"right_palm": palm})
        at = (-0.3, -0.15, 1.1, 1, 0, 0, 0)
        states.append(State(fit.state.replace(at=room.object_slice("cup"), to=at).qpos, time))
    observer = Observer(room, States(states))
    assert "Holding_Object" not in {i.value.symbol for i in observer.hand("P1", "right").intervals}
