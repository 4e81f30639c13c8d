"""People whose left is on their right: axes that mirror, or sides that were mixed up.

Bodies are nearly symmetric, so a mirrored one would be fitted well enough to be believed, with every hand the wrong
one and the face looking backwards. What betrays it is that faces, toes, and knees as they bend, point forward.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import MappingError

Array = NDArray[np.float64]

SIDES = (("left_shoulder", "right_shoulder"), ("left_hip", "right_hip"))
FORWARD = (("left_heel", "left_toe"), ("right_heel", "right_toe"))
MOST_TURNED = -0.5
"""Cosine between where face and feet point and what the sides say is forward; people turn their heads, not round."""


def check_not_mirrored(file: Path, name: str, points: Mapping[str, Array], face: Array | None) -> None:
    """Refuse a person that faces backwards.

    Args:
        file: The mapping, for messages.
        name: The person.
        points: Positions by landmark, metres, (N, 3) each.
        face: Where the face looks, (N, 3), if that is known.

    Raises:
        MappingError: Face and feet point against what left and right say.
    """
    across = [points[left] - points[right] for left, right in SIDES if left in points and right in points]
    ahead = [points[toe] - points[heel] for heel, toe in FORWARD if heel in points and toe in points]
    ahead += [] if face is None else [face]
    cosines = [_level_cosine(np.cross(sideways, (0.0, 0.0, 1.0)), forward) for sideways in across for forward in ahead]
    known = [cosine for cosine in cosines if np.isfinite(cosine)]
    if known and max(known) < MOST_TURNED:
        raise MappingError(
            "the person faces backwards: left and right are exchanged",
            where=file,
            field=f"people.{name}",
            hint="give axes that mirror if the source is left-handed (see Units, axes, frames), or exchange the points",
        )


def _level_cosine(a: Array, b: Array) -> float:
    """Median cosine between horizontal directions over time; NaN if they are never known together."""
    level_a, level_b = a[:, :2], b[:, :2]
    lengths = np.linalg.norm(level_a, axis=1) * np.linalg.norm(level_b, axis=1)
    known = np.isfinite(lengths) & (lengths > 0.0)
    if not known.any():
        return float("nan")
    return float(np.median(np.sum(level_a[known] * level_b[known], axis=1) / lengths[known]))
