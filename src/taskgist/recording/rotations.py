"""Rotations as tables hold them, and the interpolation between two; beside those of the world room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.world.geometry.rotations import matrix_from_wxyz, wxyz_from_matrix

Array = NDArray[np.float64]

_NEARLY_EQUAL_RAD = 1e-6  # below this angle, sin(s·a) / sin(a) is taken as s


def matrix_from_euler(angles_rad: Array, order: str, *, intrinsic: bool) -> Array:
    """Rotation matrices, (..., 3, 3), of Euler angles, (..., 3).

    Args:
        angles_rad: Angles; the first belongs to the first letter of the order.
        order: Three letters out of x, y, z, such as "zyx".
        intrinsic: Whether each turn is about the axes that the turns before it have moved.
    """
    turns = [_turn(angles_rad[..., i], "xyz".index(axis)) for i, axis in enumerate(order)]
    first, second, third = turns if intrinsic else turns[::-1]
    return np.asarray(first @ second @ third)


def wxyz_from_rotation_vector(vector_rad: Array) -> Array:
    """Unit quaternions, (..., 4), of rotation vectors (axis times angle), (..., 3)."""
    half = np.linalg.norm(vector_rad, axis=-1, keepdims=True) / 2
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) / 2 * vector_rad], axis=-1)


def slerp(start_wxyz: Array, end_wxyz: Array, share: Array) -> Array:
    """Great-circle interpolation between unit quaternions, (n, 4), at shares in [0, 1], (n,), the short way round."""
    cosine = np.sum(start_wxyz * end_wxyz, axis=-1)
    angle = np.arccos(np.clip(np.abs(cosine), 0.0, 1.0))
    near = angle < _NEARLY_EQUAL_RAD
    sine = np.where(near, 1.0, np.sin(angle))
    before = np.where(near, 1.0 - share, np.sin((1.0 - share) * angle) / sine)
    after = np.where(near, share, np.sin(share * angle) / sine)
    after = np.where(cosine < 0.0, -after, after)
    mixed = before[:, None] * start_wxyz + after[:, None] * end_wxyz
    return np.asarray(mixed / np.linalg.norm(mixed, axis=-1, keepdims=True))


def changed_frame(wxyz: Array, left: Array, right: Array) -> Array:
    """Quaternions, (n, 4), of ``left · R · right`` for the rotations R given as quaternions; NaN rows stay NaN."""
    result = np.full(wxyz.shape, np.nan)
    known = np.isfinite(wxyz).all(axis=-1)
    result[known] = wxyz_from_matrix(left @ matrix_from_wxyz(wxyz[known]) @ right)
    return result


def _turn(angle_rad: Array, axis: int) -> Array:
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    matrix = np.zeros((*np.shape(angle_rad), 3, 3))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[..., axis, axis] = 1.0
    matrix[..., i, i] = matrix[..., j, j] = cosine
    matrix[..., i, j], matrix[..., j, i] = -sine, sine
    return matrix
