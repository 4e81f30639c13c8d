from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.common.arrays import Array
from taskgist.moving.motion import AMPLITUDE_RAD, FREQUENCIES_HZ, Motion, minimum_jerk, sway, through

shares = st.floats(0.0, 1.0)


@given(shares, shares)
def test_the_way_never_goes_back(a: float, b: float) -> None:
    early, late = sorted((a, b))
    assert minimum_jerk(early) <= minimum_jerk(late) + 1e-12


@given(shares)
def test_the_second_half_mirrors_the_first(share: float) -> None:
    assert minimum_jerk(share) + minimum_jerk(1.0 - share) == pytest.approx(1.0)


def test_speed_is_a_bell_that_peaks_at_15_8_of_its_mean() -> None:
    way = minimum_jerk(np.linspace(0.0, 1.0, 1001))
    speed = np.diff(way) * 1000
    assert speed.max() == pytest.approx(1.875, rel=1e-4)
    assert speed.argmax() in (499, 500)
    assert speed[0] < 1e-4
    assert speed[-1] < 1e-4


def test_nothing_moves_before_the_start_and_after_the_end() -> None:
    assert minimum_jerk([-0.5, 1.5]).tolist() == [0.0, 1.0]


def test_a_motion_passes_its_knots_in_order_and_rests_at_its_ends() -> None:
    knots = np.array([(0.0, 1.0), (0.4, 1.5), (0.5, -1.0), (2.0, 0.0)])
    places = np.array([0.0, 0.2, 0.6, 1.0])
    assert through(knots, places, places) == pytest.approx(knots)
    motion = Motion(knots, places, start_s=1.0, duration_s=2.0)
    assert motion.end_s == 3.0
    assert motion.at(np.array([0.0, 1.0, 3.0, 9.0])) == pytest.approx(knots[[0, 0, 3, 3]])
    assert np.abs(motion.at(np.array([1.01, 2.99])) - knots[[0, 3]]).max() < 1e-4


def test_the_curve_through_knots_on_a_line_is_that_line() -> None:
    places = np.array([0.0, 0.3, 0.35, 1.0])
    wanted = np.linspace(0.0, 1.0, 11)
    assert through(places[:, None] * (2.0, -1.0), places, wanted) == pytest.approx(wanted[:, None] * (2.0, -1.0))


@pytest.mark.parametrize("count", [2, 3, 6])
def test_the_curve_is_the_natural_spline(count: int) -> None:
    rng = np.random.default_rng(count)
    knots, places = rng.normal(size=(count, 4)), np.r_[0.0, np.sort(rng.uniform(0.1, 0.9, count - 2)), 1.0]
    wanted = np.linspace(0.0, 1.0, 101)
    assert through(knots, places, wanted) == pytest.approx(natural_spline(knots, places, wanted), abs=1e-9)


def natural_spline(knots: Array, places: Array, wanted: Array) -> Array:
    """The twin, from its second derivatives: continuous at the knots, zero at both ends."""
    count, gaps = len(knots), np.diff(places)
    system, right = np.eye(count), np.zeros_like(knots)
    slopes = np.diff(knots, axis=0) / gaps[:, None]
    for i in range(1, count - 1):
        system[i, i - 1 : i + 2] = gaps[i - 1], 2.0 * (gaps[i - 1] + gaps[i]), gaps[i]
        right[i] = 6.0 * (slopes[i] - slopes[i - 1])
    bends = np.linalg.solve(system, right)
    left = np.clip(np.searchsorted(places, wanted, side="right") - 1, 0, len(gaps) - 1)
    gap = gaps[left][:, None]
    b = (wanted - places[left])[:, None] / gap
    a = 1.0 - b
    curved = ((a**3 - a) * bends[left] + (b**3 - b) * bends[left + 1]) * gap**2 / 6.0
    return np.asarray(a * knots[left] + b * knots[left + 1] + curved)


def test_curves_have_no_corners() -> None:
    rng = np.random.default_rng(3)
    knots, places = rng.normal(size=(5, 3)), np.array([0.0, 0.1, 0.5, 0.7, 1.0])
    step = 1e-4
    for place in places[1:-1]:
        before, here, after = through(knots, places, [place - step, place, place + step])
        assert (here - before) / step == pytest.approx((after - here) / step, abs=0.05)


def test_motions_cannot_be_written_to() -> None:
    motion = Motion(np.zeros((2, 1)), np.array([0.0, 1.0]), 0.0, 1.0)
    with pytest.raises(ValueError, match="read-only"):
        motion.knots[0] = 1.0


def test_sway_is_small_slow_and_decided_by_its_seed() -> None:
    times = np.arange(0.0, 60.0, 1 / 30)
    swaying = sway(times, np.random.default_rng(5))
    again = sway(times, np.random.default_rng(5))
    for joint, offsets in swaying.items():
        assert np.array_equal(offsets, again[joint])
        assert 0.0 < np.abs(offsets).max() <= len(FREQUENCIES_HZ) * AMPLITUDE_RAD
        assert np.abs(np.diff(offsets)).max() * 30 < 0.02
