import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.observe import Confirmation

raw_values = st.lists(st.sampled_from("ABC"), min_size=1, max_size=60)
STEP_S = 0.1


def fed(values: list[str], minimum_s: float = 0.2) -> Confirmation[str]:
    confirmation: Confirmation[str] = Confirmation(minimum_s)
    for frame, value in enumerate(values):
        confirmation.update(frame * STEP_S, value)
    return confirmation


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
def test_fed_frame_by_frame_equals_cutting_runs_afterwards(values: list[str]) -> None:
    intervals = fed(values).intervals
    assert [(i.value, round(i.start_s / STEP_S)) for i in intervals] == offline(values)


@given(raw_values, st.integers(1, 60))
def test_what_was_confirmed_live_stands_offline(values: list[str], seen: int) -> None:
    live, later = fed(values[:seen]).intervals, fed(values).intervals
    assert [(i.value, i.start_s) for i in live] == [(i.value, i.start_s) for i in later[: len(live)]]


@given(raw_values)
def test_at_reads_the_intervals(values: list[str]) -> None:
    confirmation = fed(values)
    for interval in confirmation.intervals:
        assert confirmation.at(interval.start_s) == interval.value
        assert confirmation.at((interval.start_s + interval.end_s) / 2) == interval.value


def test_a_change_is_provisional_and_then_backdated() -> None:
    fresh, settled = fed([*"AAAAB"]), fed([*"AAAABBB"])
    assert (fresh.provisional, fresh.at(0.4)) == ("B", "A")
    assert (settled.provisional, settled.at(0.4)) == (None, "B")
    assert settled.intervals[-1].start_s == pytest.approx(0.4)


def test_nothing_is_confirmed_by_one_frame() -> None:
    assert fed(["A"]).at(0.0) is None


def test_only_the_key_must_last() -> None:
    confirmation: Confirmation[tuple[str, int]] = Confirmation(0.2, key=lambda value: value[0])
    for frame, value in enumerate([("A", 1), ("A", 2), ("A", 1), ("B", 1), ("B", 2), ("B", 3)]):
        confirmation.update(frame * STEP_S, value)
    assert [i.value for i in confirmation.intervals] == [("A", 1), ("B", 1)]
