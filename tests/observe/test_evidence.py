"""What each frame says of who carries a thing: contacts, gaps, slips, falls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.observe.evidence import GRAVITY_M_S2, EvidenceOf, Tracked, acceleration_m_s2
from taskgist.observe.frames import FrameSequence
from taskgist.settings import DEFAULT
from taskgist.world import Fitter, Scene, Stage, State
from tests.observe.states import States
from tests.scenes import TABLE, agent, box, cylinder, scene

RATE_HZ = 30.0
PALM = (-0.3, -0.15, 1.1)
RIGHT = ("P1", "right")


@pytest.fixture(scope="module")
def room() -> Scene:
    """A hand beside a cup in the air, a mug on a tray on a table."""
    return scene(
        TABLE,
        cylinder("cup", *PALM),
        box("tray", 0.1, 0.2, 0.73, (0.15, 0.15, 0.01)),
        cylinder("mug", 0.1, 0.2, 0.79),
        agents=agent("P1", -0.8, 0) + agent("P2", 0.9, 0, yaw_deg=180),
    )


@pytest.fixture(scope="module")
def reaching(room: Scene) -> State:
    return Fitter(room, "P1", moving="arms").fit(room.initial, points={"right_palm": PALM}).state


def evidence(room: Scene, states: Sequence[State], name: str) -> EvidenceOf:
    return EvidenceOf(Tracked(Stage(room), FrameSequence(0.0, States(states)), DEFAULT), name)


def moved(room: Scene, start: State, paths: dict[str, np.ndarray], lost: frozenset[str] = frozenset()) -> list[State]:
    """States in which objects and agents are displaced along paths, (frames, 3) metres each."""
    states = []
    for index in range(len(next(iter(paths.values())))):
        qpos = np.array(start.qpos)
        for name, path in paths.items():
            at = room.base_slice(name) if name in room.agents else room.object_slice(name)
            qpos[at.start : at.start + 3] += path[index]
        states.append(State(qpos, index / RATE_HZ, lost))
    return states


def along(velocity_m_s: tuple[float, float, float], frames: int = 15) -> np.ndarray:
    return np.outer(np.arange(frames) / RATE_HZ, velocity_m_s)


STILL = along((0.0, 0.0, 0.0))


def test_a_hand_that_goes_along_does_not_slip(room: Scene, reaching: State) -> None:
    together, alone = along((0.0, 0.4, 0.1)), along((0.0, 0.3, 0.0))
    found = evidence(room, moved(room, reaching, {"P1": together, "cup": together}), "cup").at(7)
    (near,) = found.near
    assert (found.touches, found.rests, found.falls) == (False, False, False)
    assert found.speed_m_s == pytest.approx(np.hypot(0.4, 0.1))
    assert near.hand == RIGHT
    assert near.gap_m < DEFAULT.contact.grip_m
    assert near.slip_m_s == pytest.approx(0.0, abs=1e-9)
    passing = evidence(room, moved(room, reaching, {"P1": alone}), "cup").at(7)
    assert passing.speed_m_s == pytest.approx(0.0, abs=1e-9)
    assert passing.near[0].slip_m_s == pytest.approx(0.3)


def test_what_lies_still_rests_and_what_rises_may_be_carried(room: Scene, reaching: State) -> None:
    for up_m_s, rests in ((0.0, True), (0.05, True), (0.15, False), (-0.15, False)):
        path = along((0.2, 0.0, up_m_s)) - along((0.2, 0.0, up_m_s))[7]
        found = evidence(room, moved(room, reaching, {"tray": path}), "tray").at(7)
        assert (found.touches, found.rests) == (True, rests)


def test_what_rides_on_a_tray_rests_on_it(room: Scene, reaching: State) -> None:
    path = along((0.0, 0.0, 0.3))
    found = evidence(room, moved(room, reaching, {"tray": path, "mug": path}), "mug")
    assert [found.rests(index) for index in range(15)] == [True] * 15
    assert not evidence(room, moved(room, reaching, {"mug": path}), "mug").rests(2)


def test_a_fall_is_noticed_and_a_swing_is_not(room: Scene, reaching: State) -> None:
    since_s = np.arange(15)[:, None] / RATE_HZ
    fall, swing = 0.5 * since_s**2 * GRAVITY_M_S2, 0.1 * np.sin(2 * np.pi * since_s) * np.array([[0.0, 1.0, 0.0]])
    assert all(evidence(room, moved(room, reaching, {"cup": fall}), "cup").at(index).falls for index in range(2, 12))
    assert not any(evidence(room, moved(room, reaching, {"cup": swing}), "cup").at(index).falls for index in range(15))


def test_what_was_not_tracked_says_nothing(room: Scene, reaching: State) -> None:
    lost = evidence(room, moved(room, reaching, {"cup": STILL}, frozenset({"P1/right_arm"})), "cup").at(7)
    assert lost.lost == {RIGHT}
    assert lost.near == ()
    nowhere = evidence(room, moved(room, reaching, {"cup": STILL}, frozenset({"cup"})), "cup").at(7)
    assert not nowhere.tracked
    assert not nowhere.rests


def test_a_lone_frame_has_no_speeds(room: Scene, reaching: State) -> None:
    found = evidence(room, [reaching], "cup").at(0)
    assert (found.speed_m_s, found.near[0].slip_m_s, found.falls) == (None, None, False)
    assert evidence(room, [reaching], "mug").rests(0)


@given(
    st.lists(st.floats(0.01, 0.1), min_size=4, max_size=12),
    st.tuples(*[st.floats(-20, 20)] * 3),
    st.tuples(*[st.floats(-5, 5)] * 3),
)
def test_acceleration_of_a_parabola(
    gaps_s: list[float], acceleration: tuple[float, ...], velocity: tuple[float, ...]
) -> None:
    times_s = np.cumsum(gaps_s)
    places = 0.5 * times_s[:, None] ** 2 * np.array(acceleration) + times_s[:, None] * np.array(velocity) + 1.0
    found = acceleration_m_s2(times_s.tolist(), places)
    assert found is not None
    np.testing.assert_allclose(found, acceleration, atol=1e-4)
    assert acceleration_m_s2(times_s[:3].tolist(), places[:3]) is None
