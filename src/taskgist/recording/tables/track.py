"""One tracked point or body over time, as its source sampled it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Track:
    """Samples of one point, in the room's axes and metres.

    Attributes:
        times_s: Times of the samples in the time of the sources, (n,), strictly increasing.
        position_m: Positions, (n, 3); NaN where the tracker lost the point.
        wxyz: Orientations, (n, 4), or ``None`` for a bare point; NaN where lost.
        signs: What turns a vector in the source's naming of the body's own axes into the frame of ``wxyz``, (3,):
            (1, 1, 1), or (1, 1, -1) for a left-handed source.
        where: File that it comes from, for messages.
    """

    times_s: Array
    position_m: Array
    wxyz: Array | None
    signs: Array
    where: str
