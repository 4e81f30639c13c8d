"""Signed gaps between shapes, above all where MuJoCo alone misses one."""

import math

import mujoco
import numpy as np
import pytest

from taskgist.world.geometry.distances import Clearance

BOX = (0.4, 0.6, 0.02)
RADIUS, HALF = 0.07, 0.16


def world(place: tuple[float, float, float], tilt_rad: float = 0.0) -> tuple[mujoco.MjModel, mujoco.MjData]:
    turn = f"{math.cos(tilt_rad / 2)} 0 {math.sin(tilt_rad / 2)} 0"
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><geom type="box" size="{BOX[0]} {BOX[1]} {BOX[2]}"/>'
        f'<body pos="{place[0]} {place[1]} {place[2]}" quat="{turn}"><freejoint/>'
        f'<geom type="capsule" size="{RADIUS} {HALF}"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return model, data


def sampled_gap_m(data: mujoco.MjData) -> float:
    """Least signed distance of the capsule's axis to the box, by many points, less the radius."""
    along = data.geom_xmat[1].reshape(3, 3)[:, 2]
    points = data.geom_xpos[1] + np.linspace(-HALF, HALF, 20001)[:, None] * along
    beyond = np.abs(points) - BOX
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    return float((outside + np.minimum(beyond.max(axis=1), 0.0)).min()) - RADIUS


@pytest.mark.parametrize("z", [0.0, 0.05, 0.1, 0.15, -0.12])
def test_a_capsule_right_through_a_thin_box_is_deep_in_it(z: float) -> None:
    model, data = world((0.1, 0.1, z))
    for pair in ((0, 1), (1, 0)):
        gap = Clearance(model, data).gap_m(*pair, limit_m=1.0)
        assert sampled_gap_m(data) - 1e-6 <= gap <= -RADIUS
        assert Clearance(model, data).gap_m(*pair, limit_m=0.0) == gap


@pytest.mark.parametrize("seed", range(40))
def test_capsules_outside_keep_their_distance_and_crossing_ones_overlap(seed: int) -> None:
    rng = np.random.default_rng(seed)
    place = (rng.uniform(-0.6, 0.6), rng.uniform(-0.8, 0.8), rng.uniform(-0.4, 0.4))
    model, data = world(place, rng.uniform(-math.pi, math.pi))
    expected, gap = sampled_gap_m(data), Clearance(model, data).gap_m(0, 1, limit_m=2.0)
    if expected > -RADIUS:
        assert gap == pytest.approx(expected, abs=1e-4)
    else:
        assert gap <= -RADIUS + 1e-4
