"""Zeros that a tracker writes for what it does not see, and that nobody declared."""

from __future__ import annotations

import numpy as np

from taskgist.errors import MappingError
from taskgist.recording.rotations import Array
from taskgist.recording.tables.part import Part
from taskgist.recording.tables.tokens import Tokens

FARTHEST_JUMP_M = 0.3
"""Nothing gets from the origin to farther than this, or back, from one sample to the next (ours)."""


def check_zeros(part: Part, tokens: Tokens, position: Array) -> None:
    """Refuse a point that jumps to 0, 0, 0 and back, where the mapping does not say what that means.

    Args:
        part: Where the numbers come from.
        tokens: Source and point.
        position: Positions in the units of the source, (n, 3).

    Raises:
        MappingError: The point jumps there.
    """
    zero = (position == 0.0).all(axis=1)
    beside = np.zeros(len(zero), dtype=np.bool_)
    beside[1:] |= zero[:-1]
    beside[:-1] |= zero[1:]
    jumps_m = np.linalg.norm(position[beside & ~zero], axis=1) * tokens.source.frame.scale_m
    if np.any(jumps_m > FARTHEST_JUMP_M):
        raise MappingError(
            f"is 0, 0, 0 in {int(zero.sum())} of {len(zero)} samples, and far away in the next one",
            where=f"{part.where}, {part.place(int(np.argmax(zero)))}",
            field="position",
            hint=f"add missing = 0 to [sources.{tokens.source.name}] if it stands for not tracked, else missing = []",
        )
