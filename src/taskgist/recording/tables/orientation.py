"""Orientations in the notations of different trackers, brought to quaternions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.recording.mapping.source_model import Rotation
from taskgist.recording.rotations import Array, matrix_from_euler, wxyz_from_rotation_vector
from taskgist.world.geometry.rotations import wxyz_from_matrix

_TOLERANCE = 0.05  # quaternions with two decimals must pass, wrong columns must not


def wxyz_from_numbers(numbers: Array, rotation: Rotation) -> tuple[Array, NDArray[np.bool_]]:
    """Unit quaternions in the source's axes, and which rows hold no rotation.

    Args:
        numbers: As they stand in the table, (n, 3, 4 or 9), by row; NaN where unknown.
        rotation: Their notation.

    Returns:
        Quaternions, (n, 4), NaN where unknown or bad; bad rows, (n,).
    """
    wxyz = np.full((len(numbers), 4), np.nan)
    bad = np.zeros(len(numbers), dtype=np.bool_)
    known = np.isfinite(numbers).all(axis=1)
    if rotation.kind == "matrix":
        wxyz[known], bad[known] = _from_matrices(numbers[known].reshape(-1, 3, 3))
    elif rotation.kind in ("xyzw", "wxyz"):
        wxyz[known], bad[known] = _from_quaternions(numbers[known], rotation.kind)
    elif rotation.kind == "rotation_vector":
        wxyz[known] = wxyz_from_rotation_vector(numbers[known] * rotation.unit_rad)
    else:
        intrinsic = rotation.kind == "euler_intrinsic"
        angles_rad = numbers[known] * rotation.unit_rad
        wxyz[known] = wxyz_from_matrix(matrix_from_euler(angles_rad, rotation.order, intrinsic=intrinsic))
    return wxyz, bad


def _from_quaternions(numbers: Array, kind: str) -> tuple[Array, NDArray[np.bool_]]:
    wxyz = np.roll(numbers, 1, axis=1) if kind == "xyzw" else numbers
    length = np.linalg.norm(wxyz, axis=1, keepdims=True)
    bad = np.abs(length[:, 0] - 1.0) > _TOLERANCE
    return wxyz / np.where(bad[:, None], np.nan, length), bad


def _from_matrices(matrices: Array) -> tuple[Array, NDArray[np.bool_]]:
    departure = np.abs(matrices @ np.swapaxes(matrices, -1, -2) - np.eye(3)).max(axis=(-1, -2), initial=0.0)
    bad = (departure > _TOLERANCE) | (np.linalg.det(matrices) < 0.0)
    wxyz = np.full((len(matrices), 4), np.nan)
    wxyz[~bad] = wxyz_from_matrix(matrices[~bad])
    return wxyz, bad
