"""Rotations: unit quaternions, scalar first (``wxyz``), and 3×3 matrices; single ones and stacks of them.

Every function takes arrays with any leading shape: quaternions (..., 4), matrices (..., 3, 3), vectors (..., 3).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

IDENTITY_WXYZ: Array = np.array([1.0, 0.0, 0.0, 0.0])
IDENTITY_WXYZ.flags.writeable = False


def normalized(vector: ArrayLike) -> Array:
    """Unit vectors or unit quaternions, (..., n)."""
    array = np.asarray(vector, dtype=float)
    return np.asarray(array / np.linalg.norm(array, axis=-1, keepdims=True))


def matrix_from_wxyz(wxyz: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    w, x, y, z = np.moveaxis(np.asarray(wxyz, dtype=float), -1, 0)
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


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
    return np.stack(
        (
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ),
        axis=-1,
    )


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
    forward = rotate(wxyz, (1.0, 0.0, 0.0))
    return float(np.arctan2(forward[1], forward[0]))


def wrapped(angle_rad: float) -> float:
    """The same angle in (−π, π]."""
    return float(np.pi - (np.pi - angle_rad) % (2 * np.pi))
