"""Motion of an object, frame by frame."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np

from taskgist.observe import Motion
from taskgist.settings import DEFAULT
from tests.observe.states import sequence

RATE_HZ = 30.0
TIMING = DEFAULT.timing


def symbols(speeds_m_s: Sequence[float | None]) -> list[str | None]:
    """Motion of something that moves along x with these speeds, one per frame; None: not tracked."""
    along = accumulate((speed or 0.0) / RATE_HZ for speed in speeds_m_s)
    places = [None if speed is None else np.array([x, 0, 0]) for speed, x in zip(speeds_m_s, along, strict=True)]
    motion = Motion(sequence([frame / RATE_HZ for frame in range(len(places))]), places.__getitem__, TIMING)
    return [motion.at(frame) for frame in range(len(places))]


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
    """Turning on the spot is no motion."""
    assert set(symbols([0.0] * 10)) == {"Static"}
