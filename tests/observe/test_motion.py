from collections.abc import Sequence

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from taskgist.observe import MotionWatch
from taskgist.settings import DEFAULT

RATE_HZ = 30.0
TIMING = DEFAULT.timing


def watch(speeds_m_s: Sequence[float | None]) -> list[tuple[float, str | None]]:
    """Motion of something that moves along x with these speeds, one per frame; None: not tracked."""
    watcher, x = MotionWatch(TIMING), 0.0
    answers: list[tuple[float, str | None]] = []
    for frame, speed in enumerate(speeds_m_s):
        x += (speed or 0.0) / RATE_HZ
        answers += watcher.update(frame / RATE_HZ, None if speed is None else np.array([x, 0.0, 0.0]))
    return [*answers, *watcher.finish()]


def symbols(speeds: Sequence[float | None]) -> list[str | None]:
    return [motion for _, motion in watch(speeds)]


@given(st.lists(st.one_of(st.none(), st.floats(0, 0.5)), min_size=1, max_size=50))
def test_every_frame_is_answered_once_and_in_order(speeds: list[float | None]) -> None:
    times = [time for time, _ in watch(speeds)]
    np.testing.assert_allclose(times, np.arange(len(speeds)) / RATE_HZ)


def test_moving_above_and_static_below_the_thresholds() -> None:
    assert set(symbols([0.2] * 20)) == {"Moving"}
    assert set(symbols([0.0] * 20)) == {"Static"}


def test_between_the_thresholds_the_past_decides() -> None:
    middle = (TIMING.moving_m_s + TIMING.static_m_s) / 2
    assert symbols([0.0] * 20 + [middle] * 20)[-1] == "Static"
    assert symbols([0.3] * 20 + [middle] * 20)[-1] == "Moving"


def test_untracked_frames_are_unknown_and_reset_the_watch() -> None:
    found = symbols([0.3] * 10 + [None] * 3 + [0.0] * 10)
    assert found[10:13] == [None] * 3
    assert set(found[:10]) == {"Moving"}
    assert set(found[13:]) == {"Static"}


def test_turning_on_the_spot_is_not_moving() -> None:
    watcher = MotionWatch(TIMING)
    answers = [a for frame in range(10) for a in watcher.update(frame / RATE_HZ, np.zeros(3))]
    assert {motion for _, motion in answers} == {"Static"}
