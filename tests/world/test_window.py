import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.observe import Around, SlidingWindow, velocity

steps = st.lists(st.floats(0.005, 0.4), min_size=0, max_size=40)


def windows(times: list[float], width: float) -> list[Around[int]]:
    window: SlidingWindow[int] = SlidingWindow(width)
    found = [around for index, time in enumerate(times) for around in window.push(time, index)]
    return [*found, *window.finish()]


@given(steps, st.floats(0.01, 1.0))
def test_every_frame_comes_back_with_its_neighbourhood(gaps: list[float], width: float) -> None:
    times = [0.0, *np.cumsum(gaps).tolist()]
    found = windows(times, width)
    assert [around.item for around in found] == list(range(len(times)))
    for index, around in enumerate(found):
        inside = {i for i, t in enumerate(times) if abs(t - times[index]) <= width / 2 - 1e-6}
        neighbours = {index - 1, index, index + 1} & set(range(len(times)))
        near = {i for i, t in enumerate(times) if abs(t - times[index]) <= width / 2 + 1e-6} | neighbours
        assert inside | neighbours <= set(around.items) <= near


@pytest.mark.parametrize("rate_hz", [5.0, 8.0, 15.0, 30.0, 120.0])
def test_velocity_does_not_depend_on_the_rate(rate_hz: float) -> None:
    window: SlidingWindow[np.ndarray] = SlidingWindow(0.2)
    line = [(i / rate_hz, np.array([0.3, -0.1, 0.0]) * i / rate_hz) for i in range(20)]
    arounds = [around for time, place in line for around in window.push(time, place)]
    assert arounds
    for around in arounds:
        moved = velocity(around.times_s, around.items)
        assert moved is not None
        np.testing.assert_allclose(moved, np.array((0.3, -0.1, 0.0)), atol=1e-9)


def test_a_single_moment_has_no_velocity() -> None:
    assert velocity([1.0], [np.zeros(3)]) is None
