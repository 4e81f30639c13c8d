"""Laws of smoothing: steady motion stays, jitter goes, and nothing leaks across gaps."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.importing import Track
from taskgist.importing.table_values import smoothed
from taskgist.world.geometry.transforms import about_z

SEEDED = settings(derandomize=True, deadline=None, max_examples=25)
ONES = np.ones(3)


@SEEDED
@given(
    steps_s=st.lists(st.floats(0.005, 0.3), min_size=2, max_size=40),
    window_s=st.floats(0.01, 1.0),
    velocity=st.tuples(*[st.floats(-2, 2)] * 3),
)
def test_steady_motion_stays_as_it_is(
    steps_s: list[float], window_s: float, velocity: tuple[float, float, float]
) -> None:
    times_s = np.concatenate([[0.0], np.cumsum(steps_s)])
    line = times_s[:, None] * np.array(velocity)
    track = smoothed(Track(times_s, line, None, ONES, ""), window_s, max_gap_s=0.2)
    np.testing.assert_allclose(track.position_m, line, atol=1e-6)


def test_jitter_shrinks_and_the_rest_is_left_alone() -> None:
    rng = np.random.default_rng(0)
    times_s = np.arange(300) / 30
    path = np.column_stack([np.sin(times_s), np.cos(times_s), times_s])
    noisy = path + rng.normal(scale=0.01, size=path.shape)
    track = Track(times_s, noisy, None, ONES, "")
    assert smoothed(track, 0.0, max_gap_s=0.2) is track
    shaken = np.std(smoothed(track, 0.3, max_gap_s=0.2).position_m - path)
    assert shaken < 0.6 * np.std(noisy - path)


def test_what_is_lost_stays_lost_and_both_sides_of_a_gap_are_strangers() -> None:
    times_s = np.arange(30) / 30
    position = np.zeros((30, 3))
    position[10:20] = np.nan
    position[20:] = 1.0
    result = smoothed(Track(times_s, position, None, ONES, ""), 1.0, max_gap_s=0.2).position_m
    np.testing.assert_allclose(result, position, atol=1e-9)


def test_orientations_are_smoothed_whatever_their_sign() -> None:
    rng = np.random.default_rng(1)
    times_s = np.arange(90) / 30
    angles = 2.0 * times_s
    noisy = np.array([about_z(angle) for angle in angles + rng.normal(scale=0.05, size=90)])
    noisy[::3] *= -1.0
    wxyz = smoothed(Track(times_s, np.zeros((90, 3)), noisy, ONES, ""), 0.3, max_gap_s=0.2).wxyz
    assert wxyz is not None
    np.testing.assert_allclose(np.linalg.norm(wxyz, axis=1), 1.0)
    true = np.array([about_z(angle) for angle in angles])
    errors = [2 * np.arccos(np.clip(np.abs(np.sum(q * true, axis=1)), 0.0, 1.0)) for q in (noisy, wxyz)]
    assert np.std(errors[1]) < 0.6 * np.std(errors[0])
