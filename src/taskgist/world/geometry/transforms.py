"""Poses and rotations: unit quaternions, scalar first (``wxyz``), and 3×3 matrices; single ones and stacks of them.

Every function takes arrays with any leading shape: quaternions (..., 4), matrices (..., 3, 3), vectors (..., 3).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from taskgist.common.arrays import Array

# --- A pose: a place and an orientation in the world.


@dataclass(frozen=True, eq=False)
class Pose:
    """A place and an orientation in the world.

    Attributes:
        position: Metres, (3,).
        matrix: Rotation, (3, 3); its columns are the frame's axes in the world.
    """

    position: Array
    matrix: Array

    def to_world(self, points: ArrayLike) -> Array:
        """Points (..., 3) of this frame, in the world."""
        return np.asarray(np.asarray(points) @ self.matrix.T + self.position)

    def to_local(self, points: ArrayLike) -> Array:
        """Points (..., 3) of the world, in this frame."""
        return np.asarray((np.asarray(points) - self.position) @ self.matrix)


IDENTITY_WXYZ: Array = np.array([1.0, 0.0, 0.0, 0.0])
IDENTITY_WXYZ.flags.writeable = False


def normalized(vector: ArrayLike) -> Array:
    """Unit vectors or unit quaternions, (..., n)."""
    array = np.asarray(vector, dtype=float)
    return np.asarray(array / np.linalg.norm(array, axis=-1, keepdims=True))


def matrix_from_wxyz(wxyz: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    array = np.asarray(wxyz, dtype=float)
    w, x, y, z = (array[..., i] for i in range(4))
    found = np.empty((*array.shape[:-1], 3, 3))
    found[..., 0, 0] = 1 - 2 * (y * y + z * z)
    found[..., 0, 1] = 2 * (x * y - w * z)
    found[..., 0, 2] = 2 * (x * z + w * y)
    found[..., 1, 0] = 2 * (x * y + w * z)
    found[..., 1, 1] = 1 - 2 * (x * x + z * z)
    found[..., 1, 2] = 2 * (y * z - w * x)
    found[..., 2, 0] = 2 * (x * z - w * y)
    found[..., 2, 1] = 2 * (y * z + w * x)
    found[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return found


def wxyz_from_matrix(matrix: ArrayLike) -> Array:
    """Unit quaternions (..., 4), w ≥ 0, of rotation matrices (..., 3, 3); Bar-Itzhack's eigenvector form."""
    m = np.asarray(matrix, dtype=float)
    trace = np.trace(m, axis1=-2, axis2=-1)
    k = np.empty((*m.shape[:-2], 4, 4))
    k[..., 0, 0] = trace
    k[..., 1:, 1:] = m + np.swapaxes(m, -1, -2) - trace[..., None, None] * np.eye(3)
    axial = np.stack((m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]), axis=-1)
    k[..., 0, 1:] = k[..., 1:, 0] = axial
    wxyz = np.linalg.eigh(k)[1][..., :, -1]
    return np.asarray(np.where(wxyz[..., :1] < 0, -wxyz, wxyz))


def multiply(left: ArrayLike, right: ArrayLike) -> Array:
    """Quaternion products left ⊗ right, (..., 4)."""
    a, b = np.moveaxis(np.asarray(left, dtype=float), -1, 0), np.moveaxis(np.asarray(right, dtype=float), -1, 0)
    found = np.empty((*np.broadcast_shapes(a.shape[1:], b.shape[1:]), 4))
    found[..., 0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    found[..., 1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    found[..., 2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    found[..., 3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    return found


def conjugate(wxyz: ArrayLike) -> Array:
    """Inverse rotations of unit quaternions, (..., 4)."""
    return np.asarray(np.asarray(wxyz, dtype=float) * (1.0, -1.0, -1.0, -1.0))


def rotate(wxyz: ArrayLike, vector: ArrayLike) -> Array:
    """Vectors (..., 3) turned by unit quaternions (..., 4)."""
    return np.asarray(np.einsum("...ij,...j->...i", matrix_from_wxyz(wxyz), np.asarray(vector, dtype=float)))


def about_z(angle_rad: float) -> Array:
    """Quaternion (4,) of a turn about the vertical."""
    return np.array([np.cos(angle_rad / 2), 0.0, 0.0, np.sin(angle_rad / 2)])


def turned_about_z(wxyz: ArrayLike, angle_rad: float) -> Array:
    """A quaternion (4,) turned about the world's vertical."""
    w, x, y, z = (float(value) for value in np.asarray(wxyz))
    cosine, sine = math.cos(angle_rad / 2), math.sin(angle_rad / 2)
    return np.array((cosine * w - sine * z, cosine * x - sine * y, cosine * y + sine * x, cosine * z + sine * w))


def yaw_of(wxyz: ArrayLike) -> float:
    """Heading about the vertical, radians, of the rotated x axis; wxyz (4,)."""
    w, x, y, z = np.asarray(wxyz, dtype=float).tolist()
    return float(np.arctan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z)))


def wrapped(angle_rad: float) -> float:
    """The same angle in (−π, π]."""
    return float(np.pi - (np.pi - angle_rad) % (2 * np.pi))


# --- Rotations as tables hold them, and the interpolation between two; beside those of the world room.

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
