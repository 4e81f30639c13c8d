from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.moving.hand_pose import SETTLING_S, STEP_M, UP, Carry, HandPose, around, sampled, upright
from taskgist.world import Stage
from taskgist.world.geometry.transforms import about_z, matrix_from_wxyz, multiply, normalized
from taskgist_lab.simulator import Room
from taskgist_lab.simulator.room import TABLE, on_table

angles = st.floats(-3.0, 3.0)


@given(st.sampled_from(("left", "right")), angles, st.floats(-1.2, 1.2))
def test_a_hand_with_its_thumb_up_faces_inwards(side: str, yaw: float, rise: float) -> None:
    hand = upright(side, np.zeros(3), (np.cos(yaw), np.sin(yaw)), rise_rad=rise)
    assert hand.fingers @ hand.facing == pytest.approx(0.0, abs=1e-12)
    assert hand.facing[2] == pytest.approx(0.0)
    assert hand.fingers[2] == pytest.approx(np.sin(rise))
    inward = np.cross(hand.facing, (np.cos(yaw), np.sin(yaw), 0.0))[2]
    assert inward == pytest.approx(-1.0 if side == "right" else 1.0)


@given(angles)
def test_turning_a_hand_about_the_vertical_keeps_its_shape(turn: float) -> None:
    hand = upright("left", np.array([0.3, -0.2, 1.0]), (1.0, 0.5), rise_rad=0.4)
    turned = hand.turned(turn)
    assert turned.palm[2] == hand.palm[2]
    assert turned.fingers @ turned.palm == pytest.approx(hand.fingers @ hand.palm)
    assert np.angle(np.exp(1j * (turned.heading_rad - hand.heading_rad - turn))) == pytest.approx(0.0, abs=1e-9)


def test_a_sampled_way_keeps_its_ends_and_stays_within_its_corners() -> None:
    corners = np.array([(0.0, 0.0, 0.8), (0.0, 0.0, 1.2), (0.5, 0.3, 1.2), (0.5, 0.3, 0.9)])
    way = sampled([upright("right", corner, (1.0, 0.0)) for corner in corners])
    palms = np.array([hand.palm for hand in way])
    assert palms[[0, -1]] == pytest.approx(corners[[0, -1]])
    assert np.all(palms >= corners.min(axis=0) - 1e-9)
    assert np.all(palms <= corners.max(axis=0) + 1e-9)
    assert np.linalg.norm(np.diff(palms, axis=0), axis=1).max() <= STEP_M + 1e-9


def test_directions_turn_evenly_and_stay_perpendicular() -> None:
    start, end = upright("right", np.zeros(3), (1.0, 0.0)), upright("right", UP, (0.0, 1.0), rise_rad=1.0)
    for hand in sampled([start, end]):
        assert np.linalg.norm(hand.fingers) == pytest.approx(1.0)
        assert np.linalg.norm(hand.facing) == pytest.approx(1.0)
        assert hand.fingers @ hand.facing == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("dip", [0.0, 0.3, 0.9])
@pytest.mark.parametrize("name", ["cup", "wooden_cube", "bottle"])
def test_a_hand_around_a_thing_touches_its_side_and_clears_the_table(name: str, dip: float, side: str) -> None:
    thing = on_table(name, 0.1, -0.2)
    stage = Stage(Room("one thing", (), (thing,), TABLE).scene())
    tip = 0.1
    hand = around(stage, name, side, (1.0, 0.0), dip_rad=dip, tip_m=tip)
    beside = (hand.palm - stage.body_position(stage.scene.object_body(name))) @ -hand.facing
    assert beside == pytest.approx(thing.size_m[0] / 2, abs=0.002)
    fingertip = hand.palm + tip * hand.fingers
    assert fingertip[2] - TABLE.height_m > 0.03
    assert hand.palm[2] < TABLE.height_m + thing.height_m + tip * np.sin(dip)


def _random_hand(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    return rng.normal(size=(count, 3)), matrix_from_wxyz(normalized(rng.normal(size=(count, 4))))


def _grip() -> HandPose:
    return upright("right", np.zeros(3), (1.0, 0.0))


def test_what_is_held_moves_rigidly_with_the_hand() -> None:
    palms, turns = _random_hand(np.random.default_rng(1), 20)
    taken = np.array([0.3, 0.1, 0.8, *about_z(0.7)])
    poses = Carry("cup", "right", 0.0, _grip(), taken).poses(np.arange(20.0), palms, turns)
    assert np.abs(poses[0, 3:] @ taken[3:]) == pytest.approx(1.0)
    local = np.einsum("nji,nj->ni", turns, poses[:, :3] - palms)
    assert local == pytest.approx(np.tile(local[0], (20, 1)))
    turned = np.swapaxes(turns, 1, 2) @ matrix_from_wxyz(poses[:, 3:])
    assert turned == pytest.approx(np.tile(turned[0], (20, 1, 1)))


def test_what_is_put_down_settles_in_the_last_moment() -> None:
    times = np.linspace(0.0, 1.0, 101)
    palms, turns = np.zeros((101, 3)), np.tile(np.eye(3), (101, 1, 1))
    taken = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
    rest = np.array([0.002, 0.0, -0.001, *multiply((-1.0, 0.0, 0.0, 0.0), about_z(0.01))])
    poses = Carry("cup", "right", 0.0, _grip(), taken, 1.0, rest).poses(times, palms, turns)
    held = times < 1.0 - SETTLING_S - 1e-9
    assert np.abs(poses[held] @ taken) == pytest.approx(np.ones(held.sum()))
    assert poses[-1] == pytest.approx(rest)
    assert np.linalg.norm(poses[:, 3:], axis=1) == pytest.approx(np.ones(101))
    assert np.abs(np.diff(poses[:, :3], axis=0)).max() < 2e-4
