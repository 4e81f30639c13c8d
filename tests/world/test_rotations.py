import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from taskgist.common.arrays import Array
from taskgist.world.geometry import transforms as r

quaternions = arrays(float, 4, elements=st.floats(-1, 1)).filter(lambda q: np.linalg.norm(q) > 0.1).map(r.normalized)
vectors = arrays(float, 3, elements=st.floats(-10, 10))


@given(quaternions)
def test_matrix_and_back(wxyz: Array) -> None:
    back = r.wxyz_from_matrix(r.matrix_from_wxyz(wxyz))
    assert abs(back @ wxyz) > 1 - 1e-9


@given(quaternions, quaternions, vectors)
def test_product_turns_like_one_after_the_other(a: Array, b: Array, v: Array) -> None:
    np.testing.assert_allclose(r.rotate(r.multiply(a, b), v), r.rotate(a, r.rotate(b, v)), atol=1e-9)


@given(quaternions, vectors)
def test_conjugate_undoes(a: Array, v: Array) -> None:
    np.testing.assert_allclose(r.rotate(r.conjugate(a), r.rotate(a, v)), v, atol=1e-9)


@given(st.floats(-3.1, 3.1))
def test_yaw_of_a_turn(angle: float) -> None:
    assert abs(r.yaw_of(r.about_z(angle)) - angle) < 1e-9


@given(st.floats(-100, 100))
def test_wrapped_is_the_same_direction(angle: float) -> None:
    assert -np.pi < r.wrapped(angle) <= np.pi + 1e-12
    assert abs(np.exp(1j * r.wrapped(angle)) - np.exp(1j * angle)) < 1e-9


def test_stacks_are_turned_one_by_one() -> None:
    turns = np.stack((r.about_z(0.3), r.about_z(-1.2)))
    for single, stacked in zip(turns, r.matrix_from_wxyz(turns), strict=True):
        np.testing.assert_allclose(r.matrix_from_wxyz(single), stacked)
