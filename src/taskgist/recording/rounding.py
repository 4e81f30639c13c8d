"""The precision of a recording: what is kept on disk, and what its digest sees.

Rounding is idempotent, so that writing, reading and writing again gives the same file, and a recording that was just
imported has the digest of the file that is written of it. A tenth of a millimetre and a thousandth of a degree are
finer than any tracker.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from taskgist.world import Scene

Array = NDArray[np.float64]

POSITION_DECIMALS = 4  # metres
ANGLE_DECIMALS = 5  # radians, and components of quaternions
TIME_DECIMALS = 9  # seconds


def decimals(scene: Scene) -> NDArray[np.intp]:
    """Decimals kept of each of a scene's positions, (nq,)."""
    kept = np.full(scene.nq, ANGLE_DECIMALS, dtype=np.intp)
    for free in free_slices(scene):
        kept[free.start : free.start + 3] = POSITION_DECIMALS
    return kept


def free_slices(scene: Scene) -> tuple[slice, ...]:
    """Slices of qpos (7) of everything that moves freely: agents first, then objects."""
    bases = [scene.base_slice(agent) for agent in scene.agents]
    return (*bases, *(scene.object_slice(name) for name in scene.objects))


def rounded(qpos: Array, scene: Scene) -> Array:
    """Positions, (..., nq), at the precision of a recording."""
    scale = 10.0 ** decimals(scene)
    return np.asarray(np.rint(qpos * scale) / scale + 0.0)  # + 0.0 turns -0.0 into 0.0


def whole(qpos: Array, scene: Scene) -> NDArray[np.int64]:
    """The same as whole numbers of their last decimal, (..., nq), for digests."""
    return np.asarray(np.rint(qpos * 10.0 ** decimals(scene)), dtype=np.int64)


def nanoseconds(times_s: Array) -> NDArray[np.int64]:
    """Times in whole nanoseconds, (N,)."""
    return np.asarray(np.rint(times_s * 10.0**TIME_DECIMALS), dtype=np.int64)
