"""Steps of inverse kinematics on an arm that can be worked out by hand: a lift, and three joints in a plane."""

from __future__ import annotations

import math

import numpy as np
import pytest

from taskgist.common.arrays import Array
from taskgist.planning.damped_least_squares import descend, nearest_kept, palm_at
from taskgist.world.bodies.arm_chain import STEPS

LIFT = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.3)
"""Up by 0.3 m; then hinges about the vertical, each 0.5 m behind the last, and the palm 0.2 m beyond."""
AHEAD = np.array((1.2, 0.0, 0.0, *np.eye(3).ravel()))


def arm(*spans_rad: tuple[float, float]) -> Array:
    hinges = [(0.5 * i, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, low, high - low) for i, (low, high) in enumerate(spans_rad)]
    return np.array([LIFT, *hinges])


FREE = arm(*[(-math.pi, math.pi)] * 3)


def arrives(joints: Array, target: Array, values: Array, moving: tuple[bool, ...] = (True,) * 4) -> bool:
    return descend(joints, AHEAD, target, values, np.array(moving), 1e-4, 1e-3)


def test_a_palm_is_where_its_joints_bring_it() -> None:
    found = palm_at(FREE, AHEAD, np.array((0.1, math.pi / 2, -math.pi / 2, math.pi / 2)))
    np.testing.assert_allclose(found, (0.5, 0.7, 0.1, 0, -1, 0, 1, 0, 0, 0, 0, 1), atol=1e-12)


def test_it_arrives_where_drawn_configurations_are_and_never_beyond_a_limit() -> None:
    rng, arrived = np.random.default_rng(1), 0
    joints = arm((-2.0, 2.0), (0.0, 2.0), (-1.0, 1.0))
    for _ in range(50):
        target = palm_at(joints, AHEAD, joints[:, 7] + joints[:, 8] * rng.random(4))
        values = joints[:, 7] + joints[:, 8] * (0.3 + 0.4 * rng.random(4))
        arrived += arrives(joints, target, values)
        assert (values >= joints[:, 7] - 1e-9).all()
        assert (values <= joints[:, 7] + joints[:, 8] + 1e-9).all()
    assert arrived >= 45


def test_a_joint_at_its_limit_leaves_the_rest_to_the_others() -> None:
    joints = arm((-2.0, 0.0), (0.0, 2.0), (-2.0, 2.0))
    target, values = palm_at(joints, AHEAD, np.array((0.0, 0.0, 1.5, -0.5))), np.array((0.0, 0.0, 0.4, 0.0))
    assert arrives(joints, target, values)
    np.testing.assert_allclose(palm_at(joints, AHEAD, values), target, atol=1e-3)


def test_half_a_turn_away_is_a_direction_like_any_other() -> None:
    joints = FREE[[3]].copy()
    joints[0, 6:] = 0.0, -4.0, 8.0
    values = np.zeros(1)
    assert arrives(joints, palm_at(joints, AHEAD, np.array((math.pi,))), values, (True,))
    assert abs(values[0]) == pytest.approx(math.pi, abs=1e-3)


def test_what_may_not_move_stays_where_it_is() -> None:
    target = palm_at(FREE, AHEAD, np.array((0.2, 0.5, 0.5, -0.5)))
    values = np.array((0.1, 0.4, 0.6, -0.4))
    assert not arrives(FREE, target, values, (False, True, True, True))
    assert values[0] == 0.1
    assert arrives(FREE, target, values)


def test_kept_configurations_come_nearest_first_and_only_if_they_point_the_right_way() -> None:
    shares = np.array(((0.5, 0.5, 0.5), (0.5, 0.5, 0.52), (0.5, 0.5, 0.51), (0.5, 0.5, 0.95)))
    kept = np.round(shares * STEPS).astype(np.uint16)
    target, ahead = AHEAD + (0.0, 0.0, 0.2, *np.zeros(9)), np.array((1.0, 0.0, 0.0))
    found = nearest_kept(
        FREE,
        AHEAD,
        target,
        ahead,
        0.5,
        np.array(((0.0,), (0.2,))),
        np.array((0.0, 0.2)),
        np.array((0, 0)),
        np.array((0, len(kept))),
        kept,
        5,
    )
    assert found[:, 0].tolist() == [0.2, 0.2, 0.2, 0.0, 0.0]
    np.testing.assert_allclose(found[:3, 3] / (2 * math.pi) + 0.5, (0.5, 0.51, 0.52), atol=1e-4)
