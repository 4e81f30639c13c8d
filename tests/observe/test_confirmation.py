"""Confirmation: what lasts counts, from its onset on; and it stands, however many frames follow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.errors import RecordingError
from taskgist.observe import Confirmed, FrameSequence, Observer, Refined
from taskgist.world import State
from tests.observe.states import States, sequence
from tests.scenes import agent, cylinder, scene

raw_values = st.lists(st.sampled_from("ABC"), min_size=1, max_size=60)
STEP_S = 0.1


def confirmed(values: Sequence[str], minimum_s: float = 0.2) -> Confirmed[str]:
    """Of a whole sequence."""
    times_s = [frame * STEP_S for frame in range(len(values))]
    return Confirmed(sequence(times_s), values.__getitem__, minimum_s)


def grown(values: Sequence[str], minimum_s: float = 0.2, window_s: float = 0.0) -> Confirmed[str]:
    """Of frames that were appended, and asked after each; more may come."""
    frames = FrameSequence(window_s)
    growing = Confirmed(frames, values.__getitem__, minimum_s)
    for frame in range(len(values)):
        frames.append(State(np.empty(0), frame * STEP_S))
        growing.at(frame * STEP_S)  # what is kept of this answer must not spoil later ones
    return growing


def offline(values: list[str], minimum_frames: int = 2) -> list[tuple[str, int]]:
    """The slow twin: cut into runs, drop the short ones, join what is equal; (value, onset) of what stays."""
    runs: list[list[object]] = []
    for frame, value in enumerate(values):
        if runs and runs[-1][0] == value:
            runs[-1][2] = frame
        else:
            runs.append([value, frame, frame])
    stable = [(str(v), int(str(a))) for v, a, b in runs if int(str(b)) - int(str(a)) >= minimum_frames]
    joined: list[tuple[str, int]] = []
    for value, onset in stable:
        if not joined or joined[-1][0] != value:
            joined.append((value, onset))
    return joined


@given(raw_values)
def test_intervals_are_the_runs_that_last(values: list[str]) -> None:
    intervals = confirmed(values).intervals
    assert [(i.value, round(i.start_s / STEP_S)) for i in intervals] == offline(values)


@given(raw_values, st.integers(1, 60), st.sampled_from([0.0, 0.2, 0.5]))
def test_what_was_confirmed_live_stands_offline(values: list[str], seen: int, window_s: float) -> None:
    live, later = grown(values[:seen], window_s=window_s).intervals, confirmed(values).intervals
    assert [(i.value, i.start_s) for i in live] == [(i.value, i.start_s) for i in later[: len(live)]]


@given(raw_values)
def test_at_reads_the_intervals(values: list[str]) -> None:
    found = confirmed(values)
    for interval in found.intervals:
        assert found.at(interval.start_s) == interval.value
        assert found.at((interval.start_s + interval.end_s) / 2) == interval.value


def test_a_change_is_provisional_and_then_backdated() -> None:
    fresh, settled = confirmed("AAAAB"), confirmed("AAAABBB")
    assert (fresh.provisional, fresh.at(0.4)) == ("B", "A")
    assert (settled.provisional, settled.at(0.4)) == (None, "B")
    assert settled.intervals[-1].start_s == pytest.approx(0.4)


def test_live_too_once_the_frames_around_it_have_come() -> None:
    fresh, settled = grown("AAAAB."), grown("AAAABBB.")
    assert (fresh.provisional, fresh.at(0.4)) == ("B", "A")
    assert (settled.provisional, settled.at(0.4)) == (None, "B")
    assert grown("AAAABBB.", window_s=0.4).provisional == "B", "frames are half a window late"


def test_nothing_is_confirmed_by_one_frame_or_none() -> None:
    assert confirmed("A").at(0.0) is None
    assert (confirmed("A").provisional, confirmed("A").intervals) == ("A", ())
    nothing = Confirmed(FrameSequence(0.2), "".__getitem__, 0.2)
    assert (nothing.at(0.0), nothing.provisional, nothing.intervals) == (None, None, ())


def test_only_the_key_must_last() -> None:
    values = [("A", 1), ("A", 2), ("A", 1), ("B", 1), ("B", 2), ("B", 3)]
    times_s = [frame * STEP_S for frame in range(len(values))]
    found = Confirmed(sequence(times_s), values.__getitem__, 0.2, key=lambda value: value[0])
    assert [i.value for i in found.intervals] == [("A", 1), ("B", 1)]


def refined(values: Sequence[tuple[str, int]]) -> Refined[tuple[str, int]]:
    times_s = [frame * STEP_S for frame in range(len(values))]
    return Refined(sequence(times_s), values.__getitem__, 0.2, kind=lambda value: value[0])


def test_particulars_are_told_once_they_last() -> None:
    """From hand to hand: held all the time, by one, by both for an instant, by the other."""
    found = refined([("held", 1)] * 4 + [("held", 12)] * 2 + [("held", 2)] * 4)
    assert [(i.value, round(i.start_s / STEP_S)) for i in found.intervals] == [(("held", 1), 0), (("held", 2), 6)]
    assert found.at(0.45) == ("held", 1)


def test_a_kind_counts_though_its_particulars_never_last() -> None:
    found = refined([("held", 1)] * 4 + [("free", 1), ("free", 2)] * 3)
    assert found.at(0.4) == ("free", 1)
    assert found.at(0.5) == ("free", 2), "as of the last frame of that kind"
    assert [i.value[0] for i in found.intervals] == ["held", "free"]


@given(raw_values, st.sampled_from([1.7e9, 1764373408.123, -3600.0, 86400.5]))
def test_when_it_was_changes_nothing(values: list[str], since_s: float) -> None:
    """Times of a clock that counts from 1970 are rounded to a quarter of a microsecond."""
    found = confirmed(values)
    times_s = [since_s + frame * STEP_S for frame in range(len(values))]
    later = Confirmed(sequence(times_s), values.__getitem__, 0.2)
    assert [i.value for i in later.intervals] == [i.value for i in found.intervals]
    assert [i.start_s - since_s for i in later.intervals] == pytest.approx(
        [i.start_s for i in found.intervals], abs=1e-6
    )
    assert [later.at(time_s) for time_s in times_s] == [found.at(time_s - since_s) for time_s in times_s]


def test_frames_come_in_order_and_only_where_more_were_to_come() -> None:
    room = scene(cylinder("cup", 0.0, 0.0, 0.05), agents=agent("P1", -0.8, 0))
    observer = Observer(room)
    observer.append(State(room.initial.qpos, 0.5))
    with pytest.raises(RecordingError, match=r"time_s: times run backwards \(got 0.5\); .* the last was at 0.5 s"):
        observer.append(State(room.initial.qpos, 0.5))
    observer.finish()
    for complete in (observer, Observer(room, States([room.initial]))):
        with pytest.raises(RecordingError, match="no more frames were to come"):
            complete.append(State(room.initial.qpos, 1.0))
