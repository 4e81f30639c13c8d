"""Motion of an object, frame by frame."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.arrays import Array
from taskgist.observe import Motion, Observer
from taskgist.settings import DEFAULT, Settings
from taskgist.world import State
from taskgist.world.geometry.transforms import Pose, about_z, matrix_from_wxyz
from tests.observe.states import States, sequence
from tests.scenes import TABLE, agent, box, cylinder, scene

RATE_HZ = 30.0
TIMING = DEFAULT.timing
MIDDLE: Array = np.zeros((1, 3))


def symbols(speeds_m_s: Sequence[float | None]) -> list[str | None]:
    """Motion of something that moves along x with these speeds, one per frame; None: not tracked."""
    along = accumulate((speed or 0.0) / RATE_HZ for speed in speeds_m_s)
    poses = [
        None if speed is None else Pose(np.array([x, 0, 0]), np.eye(3))
        for speed, x in zip(speeds_m_s, along, strict=True)
    ]
    motion = Motion(sequence([frame / RATE_HZ for frame in range(len(poses))]), poses.__getitem__, MIDDLE, TIMING)
    return [motion.at(frame) for frame in range(len(poses))]


def test_moving_above_and_static_below_the_thresholds() -> None:
    assert set(symbols([0.2] * 20)) == {"Moving"}
    assert set(symbols([0.0] * 20)) == {"Static"}


def test_between_the_thresholds_the_past_decides() -> None:
    middle = (TIMING.moving_m_s + TIMING.static_m_s) / 2
    assert symbols([0.0] * 20 + [middle] * 20)[-1] == "Static"
    assert symbols([0.3] * 20 + [middle] * 20)[-1] == "Moving"


def test_untracked_frames_are_unknown_and_all_begins_anew_behind_them() -> None:
    found = symbols([0.3] * 10 + [None] * 3 + [0.0] * 10)
    assert found[10:13] == [None] * 3
    assert set(found[:10]) == {"Moving"}
    assert set(found[13:]) == {"Static"}
    middle = (TIMING.moving_m_s + TIMING.static_m_s) / 2
    assert set(symbols([0.3] * 10 + [None] + [middle] * 10)[11:]) == {"Static"}


def test_a_frame_that_stands_alone_is_unknown() -> None:
    assert symbols([0.3, None, 0.3, None]) == [None] * 4


def test_what_stays_where_it_is_does_not_move() -> None:
    assert set(symbols([0.0] * 10)) == {"Static"}


def turning(poses: Sequence[Pose], points: Array) -> list[str | None]:
    motion = Motion(sequence([frame / RATE_HZ for frame in range(len(poses))]), poses.__getitem__, points, TIMING)
    return [motion.at(frame) for frame in range(len(poses))]


@given(
    st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=25),
    st.tuples(*[st.floats(-1.0, 1.0)] * 3).map(np.array),
    st.floats(-math.pi, math.pi),
)
def test_where_the_frame_of_a_body_lies_changes_nothing(rates: list[float], aside_m: Array, turned: float) -> None:
    points, frame = np.array([[0.1, 0.05, 0.02], [-0.1, -0.05, 0.0]]), Pose(aside_m, matrix_from_wxyz(about_z(turned)))
    angles = np.cumsum(rates) / RATE_HZ
    poses = [Pose(np.array([angle / 20, 0, 0]), matrix_from_wxyz(about_z(angle))) for angle in angles]
    elsewhere = [Pose(pose.to_world(frame.position), pose.matrix @ frame.matrix) for pose in poses]
    assert turning(elsewhere, frame.to_local(points)) == turning(poses, points)


@pytest.mark.parametrize(("rad_s", "radius_m", "expected"), [(1.5, 0.1, "Moving"), (1.5, 0.02, "Static")])
def test_turning_in_place_moves_what_reaches_far(rad_s: float, radius_m: float, expected: str) -> None:
    poses = [Pose(np.zeros(3), matrix_from_wxyz(about_z(rad_s * frame / RATE_HZ))) for frame in range(20)]
    assert set(turning(poses, np.array([[radius_m, 0, 0], [-radius_m, 0, 0]]))) == {expected}


def tray_turned(settings: Settings) -> set[str | None]:
    room = scene(
        TABLE, box("tray", 0, 0, 0.73, (0.2, 0.1, 0.01)), cylinder("cup", 0.3, 0, 0.77), agents=agent("P1", -2, 0)
    )
    column = room.object_slice("tray")
    states = [
        State(room.initial.replace(at=column, to=(0, 0, 0.73, *about_z(0.05 * frame))).qpos, frame / RATE_HZ)
        for frame in range(30)
    ]
    observer = Observer(room, States(states), settings)
    assert {interval.value for interval in observer.motion("cup").intervals} == {"Static"}
    return {interval.value for interval in observer.motion("tray").intervals}


def test_by_a_setting_only_places_count() -> None:
    """Eq. 22."""
    assert tray_turned(DEFAULT) == {"Moving"}
    timing = dataclasses.replace(TIMING, turning_moves=False)
    assert tray_turned(dataclasses.replace(DEFAULT, timing=timing)) == {"Static"}
