"""Boxes around shapes only tell what measuring the shapes confirms."""

from __future__ import annotations

import itertools

import mujoco
import numpy as np
import pytest

from taskgist.world.geometry.distances import (
    COLUMNS,
    Clearance,
    any_near,
    boxes_gap_m,
    boxes_of,
    near_ball,
    next_near,
    seen_from,
    surely_overlap,
)

KINDS = ("sphere", "capsule", "cylinder", "ellipsoid", "box")
SURE_M = 1e-3


def two(kind: str, rng: np.random.Generator) -> tuple[mujoco.MjModel, mujoco.MjData]:
    sizes = [" ".join(map(str, 10 ** rng.uniform(-2.3, -0.5, 3))) for _ in range(2)]
    bodies = "".join(
        f"<body><freejoint/><geom type='{each}' size='{size}' mass='1'/></body>"
        for each, size in zip(("box", kind), sizes, strict=True)
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    return model, mujoco.MjData(model)


def strewn(model: mujoco.MjModel, data: mujoco.MjData, rng: np.random.Generator) -> None:
    """Put two bodies somewhere near each other, now and then with parallel edges."""
    turns = rng.normal(size=(2, 4))
    if rng.random() < 0.3:
        turns[0] = turns[1] + rng.choice((0.0, 1e-6, 1e-3)) * rng.normal(size=4)
    for body in range(2):
        data.qpos[7 * body : 7 * body + 3] = rng.uniform(-0.6, 0.6, 3) * model.geom_rbound.sum()
        data.qpos[7 * body + 3 : 7 * body + 7] = turns[body] / np.linalg.norm(turns[body])
    mujoco.mj_kinematics(model, data)


@pytest.mark.parametrize("kind", KINDS)
def test_what_boxes_tell_is_what_is_measured(kind: str) -> None:
    rng = np.random.default_rng(KINDS.index(kind))
    seen = set()
    for _ in range(30):
        model, data = two(kind, rng)
        clearance = Clearance(model, data)
        for _ in range(30):
            strewn(model, data, rng)
            first, second = clearance.boxes(np.array([0])), clearance.boxes(np.array([1]))
            gap = clearance.gap_m(0, 1, limit_m=0.0)
            near = next_near(first, second, 0.0, 0) == 0
            sure = near and surely_overlap(first, 0, second, 0, SURE_M)
            assert near or gap >= 0.0
            assert not sure or gap < -SURE_M / 2
            assert next_near(first, second, -0.01, 0) == 0 or gap > -0.011
            seen.add((near, sure))
    assert seen == {(False, False), (True, False), (True, True)}


def test_separating_axes_tell_how_deep_boxes_overlap() -> None:
    rng = np.random.default_rng(9)
    for _ in range(200):
        model, data = two("box", rng)
        strewn(model, data, rng)
        first, second = Clearance(model, data).boxes(np.array([0])), Clearance(model, data).boxes(np.array([1]))
        axes = [matrix.reshape(3, 3).T for matrix in data.geom_xmat]
        along = [*axes[0], *axes[1], *(np.cross(a, b) for a, b in itertools.product(*axes))]
        units = np.array([axis / np.linalg.norm(axis) for axis in along if np.linalg.norm(axis) > 1e-3])
        reach = sum(np.abs(units @ matrix.T) @ size for matrix, size in zip(axes, model.geom_size, strict=True))
        gaps = np.abs(units @ (data.geom_xpos[1] - data.geom_xpos[0])) - reach
        assert boxes_gap_m(first, 0, second, 0, np.inf) == pytest.approx(gaps.max(), abs=1e-4)


def test_boxes_look_the_same_from_any_frame() -> None:
    rng = np.random.default_rng(5)
    for _ in range(50):
        model, data = two("cylinder", rng)
        strewn(model, data, rng)
        both = Clearance(model, data).boxes(np.array([0, 1]))
        from_first = seen_from(both, data.geom_xpos[0].copy(), data.geom_xmat[0].reshape(3, 3).copy())
        assert from_first[0, :12] == pytest.approx([0, 0, 0, *np.eye(3).ravel()])
        gap = boxes_gap_m(both[:1], 0, both[1:], 0, np.inf)
        assert boxes_gap_m(from_first[:1], 0, from_first[1:], 0, np.inf) == pytest.approx(gap, abs=1e-9)


def plane_and_ball(height: float) -> np.ndarray:
    positions, turned = np.array([(0.0, 0.0, 0.0), (3.0, 4.0, height)]), np.tile(np.eye(3).ravel(), (2, 1))
    kinds = np.array([int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_SPHERE)])
    bounds = np.array([(0.0,) * 6, (0.0, 0.0, 0.0, 0.5, 0.5, 0.5)])
    return boxes_of(np.arange(2), kinds, np.array([np.inf, 0.5]), bounds, positions, turned)


@pytest.mark.parametrize(("height", "near"), [(0.6, False), (0.501, False), (0.499, True), (-3.0, True)])
def test_a_plane_is_endless_and_thick(height: float, near: bool) -> None:
    table = plane_and_ball(height)
    assert (next_near(table[:1], table[1:], 0.0, 0) == 0) == near
    assert any_near(table[1:], (700.0, -20.0), table[:1], 0.0) == near


def test_pairs_are_numbered_along_the_second_set() -> None:
    table = np.repeat(plane_and_ball(0.0)[1:], 4, axis=0)
    table[:, 0] = (0.0, 0.9, 5.0, 5.9)
    found, pair = [], next_near(table, table, 0.0, 0)
    while pair >= 0:
        found.append(divmod(pair, 4))
        pair = next_near(table, table, 0.0, pair + 1)
    assert found == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2), (2, 3), (3, 2), (3, 3)]
    assert near_ball(table, 5.4, 4.0, 0.0, 0.1).tolist() == [2, 3]
    assert next_near(table, np.empty((0, COLUMNS)), 0.0, 0) == -1
