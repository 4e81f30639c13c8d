"""NPZ of SMPL, SMPL-H and SMPL-X: joints over time, with the pose parameters of AMASS if they are there.

AMASS (Mahmood et al. 2019) stores ``trans``, ``poses`` (axis times angle of each joint about its parent), ``betas`` and
``mocap_framerate``. Where joints are follows from these only by the body model, which is licensed to its users and not
ours to ship: a file without joints is refused, with the lines that add them. How joints are *turned* follows from the
poses alone, along the tree of the joints (Loper et al. 2015, SMPL); so head and hands get their directions.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from taskgist.common.array_files import ArrayFile
from taskgist.common.arrays import Array
from taskgist.errors import MappingError
from taskgist.importing.skeletons import SMPL_X
from taskgist.importing.takes import Take, TakeTrack
from taskgist.world.geometry.transforms import multiply, wxyz_from_rotation_vector

PARAMETERS = frozenset({"poses", "trans"})
JOINTS = ("joints", "Jtr", "joints3d", "joints_3d")
RATES = ("mocap_framerate", "mocap_frame_rate", "fps", "frame_rate", "rate_hz")
PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
"""Of each of the 22 joints, the one that carries it."""


def read_smplx(path: Path, where: str, most_bytes: int) -> Take:
    """The 22 body joints of an NPZ of SMPL.

    Raises:
        MappingError: It cannot be read, is too large; it holds no joints, or no rate; arrays do not fit each other.
    """
    arrays = ArrayFile(path, most_bytes=most_bytes, where=where, error=MappingError)
    name = next((name for name in JOINTS if name in arrays.names), None)
    if name is None:
        hint = (
            "joints follow from trans, poses and betas only by the body model, which is licensed to you: run it with "
            "the package smplx and save joints beside poses, as docs/howto/files.md shows"
        )
        raise MappingError("holds parameters of SMPL, and no joints", where=where, hint=hint)
    joints = np.asarray(arrays.array(name))
    count = len(SMPL_X.names)
    if joints.dtype.kind not in "fiu" or joints.ndim != 3 or joints.shape[1] < count or joints.shape[2] != 3:
        hint = f"save (frames, {count} or more, 3): the joints in the order of the model"
        raise MappingError("are no joints of SMPL", where=where, field=name, value=joints.shape, hint=hint)
    times_s = np.arange(len(joints)) / _rate_hz(arrays, where)
    turned = _turned(arrays, len(joints), where)
    tracks = {
        point: TakeTrack(times_s, joints[:, k].astype(np.float64), None if turned is None else turned[k])
        for k, point in enumerate(SMPL_X.names)
    }
    return Take("smplx", tracks, unit="m")


def _rate_hz(arrays: ArrayFile, where: str) -> float:
    name = next((name for name in RATES if name in arrays.names), None)
    if name is None:
        hint = f"save it as one of {', '.join(RATES)}"
        raise MappingError("says no frame rate", where=where, hint=hint)
    value = np.asarray(arrays.array(name))
    if value.size != 1 or value.dtype.kind not in "fiu" or not 0.0 < float(value.reshape(-1)[0]) < 1e5:
        raise MappingError(
            "is no frame rate", where=where, field=name, value=value.tolist(), hint="save frames per second"
        )
    return float(value.reshape(-1)[0])


def _turned(arrays: ArrayFile, frames: int, where: str) -> list[Array] | None:
    """Orientations of the joints in the file's axes, (frames, 4) each; None without poses."""
    if "poses" not in arrays.names:
        return None
    poses = np.asarray(arrays.array("poses"))
    if poses.dtype.kind != "f" or poses.shape[:1] != (frames,) or poses.size < frames * 3 * len(PARENTS):
        hint = f"save (frames, {3 * len(PARENTS)} or more), for the frames of the joints"
        raise MappingError("do not fit the joints", where=where, field="poses", value=poses.shape, hint=hint)
    vectors = poses.reshape(frames, -1, 3)[:, : len(PARENTS)].astype(np.float64)
    turned: list[Array] = []
    for joint, parent in enumerate(PARENTS):
        own = wxyz_from_rotation_vector(vectors[:, joint])
        turned.append(own if parent < 0 else multiply(turned[parent], own))
    return turned
