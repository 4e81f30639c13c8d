"""Looking up single frames gives what watching all of them gives: windows, hysteresis, motion and confirmation."""

from __future__ import annotations

from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import taskgist.observe.frames as observed_frames
from taskgist.observe import Confirmed, Hysteresis, Motion
from taskgist.settings import DEFAULT
from taskgist.world.geometry.transforms import Pose
from tests.observe.states import sequence
from tests.observe.step_by_step import Confirmation, MotionWatch, SlidingWindow

TIMING = DEFAULT.timing
GAPS_S = st.sampled_from([1 / 120, 1 / 30, 0.05, 0.1, 0.2, 0.4]) | st.floats(0.004, 0.5)
SPEEDS_M_S = st.sampled_from([0.0, 0.03, 0.06, 0.08, 0.2]) | st.floats(0.0, 0.3)
VALUES = st.tuples(st.sampled_from("ABC"), st.sampled_from([1, 2]))


def runs(values: st.SearchStrategy[object]) -> st.SearchStrategy[list[object]]:
    """Values of frames: each stays for a few of them, so that some last and some do not."""
    stretches = st.lists(st.tuples(values, st.integers(1, 8)), min_size=1, max_size=12)
    return stretches.map(lambda drawn: [value for value, count in drawn for _ in range(count)])


def times_of(gaps: list[float], count: int) -> list[float]:
    """Times that go on with the same gaps, over and over."""
    return list(accumulate((gaps[number % len(gaps)] for number in range(count - 1)), initial=0.5))


@given(st.lists(GAPS_S, min_size=1, max_size=40), st.floats(0.01, 1.0))
def test_the_window_of_a_frame_is_the_one_that_slides_over_it(gaps: list[float], width_s: float) -> None:
    times = times_of(gaps, len(gaps) + 1)
    window: SlidingWindow[int] = SlidingWindow(width_s)
    slid = [around for index, time in enumerate(times) for around in window.push(time, index)] + [*window.finish()]
    frames = sequence(times)
    assert [tuple(frames.window(index, width_s)) for index in range(len(times))] == [each.items for each in slid]


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=30), st.randoms())
def test_going_back_to_what_is_decided_gives_what_going_forward_gives(
    table: list[tuple[bool, bool]], order: np.random.Generator
) -> None:
    forward = [*accumulate(table, lambda before, row: row[before], initial=False)][1:]
    assert [Hysteresis(lambda index, before: table[index][before]).at(each) for each in range(len(table))] == forward
    kept, indices = Hysteresis(lambda index, before: table[index][before]), [*range(len(table))]
    order.shuffle(indices)
    assert [kept.at(each) for each in indices] == [forward[each] for each in indices]


def test_what_was_decided_once_is_not_asked_again() -> None:
    asked: list[int] = []

    def undecided(index: int, before: bool) -> bool:
        asked.append(index)
        return before

    kept = Hysteresis(undecided)
    for index in range(100):
        kept.at(index)
    assert max(asked.count(index) for index in range(100)) <= 3


@given(st.lists(GAPS_S, min_size=1, max_size=5), runs(st.none() | SPEEDS_M_S))
def test_motion_looked_up_is_motion_watched(gaps: list[float], speeds: list[float | None]) -> None:
    times = times_of(gaps, len(speeds))
    steps = [0.0, *np.diff(times)]
    along = accumulate((speed or 0.0) * step for speed, step in zip(speeds, steps, strict=True))
    places = [None if speed is None else np.array([x, 0.0, 1.0]) for x, speed in zip(along, speeds, strict=True)]
    watch = MotionWatch(TIMING)
    corner = np.array([[0.1, 0.0, 0.0]])
    clouds = [None if place is None else place + corner for place in places]
    watched = [answer for time, cloud in zip(times, clouds, strict=True) for answer in watch.update(time, cloud)]
    poses = [None if place is None else Pose(place, np.eye(3)) for place in places]
    motion = Motion(sequence(times), poses.__getitem__, corner, TIMING)
    assert [(times[index], motion.at(index)) for index in reversed(range(len(times)))] == [
        *reversed([*watched, *watch.finish()])
    ]


@given(st.lists(GAPS_S, min_size=1, max_size=5), runs(VALUES), st.sampled_from([0.0, 0.1, 0.2, 0.5]))
def test_what_is_looked_up_is_what_was_confirmed(
    gaps: list[float], values: list[tuple[str, int]], minimum_s: float
) -> None:
    times = times_of(gaps, len(values))
    confirmation = Confirmation[tuple[str, int]](minimum_s, key=lambda value: value[0])
    for time, value in zip(times, values, strict=True):
        confirmation.update(time, value)
    asked = [0.0, *(time + later for time in times for later in (0.0, 0.003))]
    for time in reversed(asked):
        found = Confirmed(sequence(times), values.__getitem__, minimum_s, key=lambda value: value[0])
        assert found.at(time) == confirmation.at(time)
    assert found.intervals == confirmation.intervals


def test_no_more_frames_are_looked_at_than_it_takes() -> None:
    """The example of ``observe/frames.py``, within a longer sequence."""
    asked: set[int] = set()
    values: list[str] = [*"AAAAAAAAAA", *"AAABAAABBBB", *"BBBBBBBBBB"]

    def raw(index: int) -> str:
        asked.add(index)
        return values[index]

    times = [0.1 * index for index in range(len(values))]
    assert Confirmed(sequence(times), raw, 0.2).at(times[13]) == "A"
    assert asked == {10, 11, 12, 13, 14}
    asked.clear()
    assert Confirmed(sequence(times), raw, 0.2).at(times[17]) == "B"
    assert asked == {16, 17, 18, 19}


@given(runs(VALUES), st.lists(GAPS_S, min_size=1, max_size=5), st.floats(0.05, 0.5))
def test_what_was_forgotten_is_looked_up_again(values: list[object], gaps: list[float], minimum_s: float) -> None:
    """However few frames are kept, the answers are the same."""
    frames = sequence(times_of(gaps, len(values)))
    kept = Confirmed(frames, values.__getitem__, minimum_s, key=lambda value: value[0])  # type: ignore[index]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(observed_frames, "KEPT_FRAMES", 4)
        short = Confirmed(frames, values.__getitem__, minimum_s, key=lambda value: value[0])  # type: ignore[index]
        assert short.intervals == kept.intervals
        assert [short.at(time_s) for time_s in frames.times_s] == [kept.at(time_s) for time_s in frames.times_s]


def test_only_the_latest_frames_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(observed_frames, "KEPT_FRAMES", 50)
    frames = sequence([index / 30 for index in range(2000)])
    hysteresis = Hysteresis(lambda index, before: index % 90 < (60 if before else 30))
    forward = [*accumulate(range(2000), lambda before, index: index % 90 < (60 if before else 30), initial=False)][1:]
    confirmed = Confirmed(frames, hysteresis.at, 0.2)
    assert [hysteresis.at(index) for index in range(2000)] == forward
    assert len(confirmed.intervals) == 45
    assert len(hysteresis._found) == 50
    assert hysteresis.at(3) == forward[3]
