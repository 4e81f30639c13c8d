"""Windows around frames, and the velocity within them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.observe import FrameSequence, velocity
from taskgist.world import State
from tests.observe.states import sequence

steps = st.lists(st.floats(0.005, 0.4), min_size=0, max_size=40)


@given(steps, st.floats(0.01, 1.0))
def test_a_window_holds_what_is_near_in_time_and_the_neighbours(gaps: list[float], width: float) -> None:
    times = [0.0, *np.cumsum(gaps).tolist()]
    frames = sequence(times)
    for index, time in enumerate(times):
        found = set(frames.window(index, width))
        inside = {i for i, t in enumerate(times) if abs(t - time) <= width / 2 - 1e-6}
        neighbours = {index - 1, index, index + 1} & set(range(len(times)))
        near = {i for i, t in enumerate(times) if abs(t - time) <= width / 2 + 1e-6} | neighbours
        assert inside | neighbours <= found <= near


@given(steps, st.floats(0.01, 1.0))
def test_a_settled_frame_keeps_its_window(gaps: list[float], width: float) -> None:
    times = [0.0, *np.cumsum(gaps).tolist()]
    whole, growing = sequence(times), FrameSequence(width)
    for count, time in enumerate(times, start=1):
        growing.append(State(np.empty(0), time))
        assert growing.settled < count
        late = [t for t in times[: count - 1] if time - t >= width / 2 - 1e-9]
        assert growing.settled == len(late), "neither sooner nor later"
        for index in range(growing.settled):
            assert growing.window(index, width) == whole.window(index, width)
    growing.finish()
    assert growing.settled == whole.settled == len(times)


@pytest.mark.parametrize("rate_hz", [5.0, 8.0, 15.0, 30.0, 120.0])
def test_velocity_does_not_depend_on_the_rate(rate_hz: float) -> None:
    times, places = [i / rate_hz for i in range(20)], [np.array([0.3, -0.1, 0.0]) * i / rate_hz for i in range(20)]
    frames = sequence(times)
    for index in range(len(times)):
        around = frames.window(index, 0.2)
        moved = velocity([times[each] for each in around], [places[each] for each in around])
        assert moved is not None
        np.testing.assert_allclose(moved, np.array((0.3, -0.1, 0.0)), atol=1e-9)


def test_a_single_moment_has_no_velocity() -> None:
    assert velocity([1.0], [np.zeros(3)]) is None
