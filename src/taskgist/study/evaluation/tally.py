"""Counts along draws: after each demonstration, what the learner counts of each node.

A verdict on a node follows from three numbers: in how many demonstrations it was known (N), how often it had its most
frequent value (n), and how many different values it had (k). So draws are counted once, in arrays, and judged by as
many rules as one likes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from taskgist.study.evaluation.coded import UNKNOWN_CODE, Codes

Counts = NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Tally:
    """What has been counted after each demonstration of each draw; all arrays are (draws, demonstrations, nodes)."""

    best: Codes
    """Code of the most frequent value, ties by canonical order; -1 where nothing is known."""
    n: Counts
    """Demonstrations that showed it."""
    N: Counts
    """Demonstrations in which the node was known."""
    k: Counts
    """Different values that were seen."""


def tally(drawn: Codes) -> Tally:
    """Count along draws.

    Args:
        drawn: Codes, (draws, demonstrations, nodes).
    """
    columns = [_column(drawn[:, :, node]) for node in range(drawn.shape[2])]
    best, n, N, k = (np.stack([column[part] for column in columns], axis=2) for part in range(4))
    return Tally(best, n, N, k)


def _column(codes: Codes) -> tuple[Codes, Counts, Counts, Counts]:
    """Counts of one node: best, n, N and k, (draws, demonstrations) each."""
    seen = np.unique(codes[codes != UNKNOWN_CODE])  # sorted: the first of several maxima is the canonical one
    if not len(seen):
        nothing = np.zeros(codes.shape, dtype=np.int32)
        return np.full_like(codes, UNKNOWN_CODE), nothing, nothing, nothing
    counts = np.cumsum(codes[:, :, None] == seen, axis=1, dtype=np.int32)
    n = counts.max(axis=2)
    best = np.where(n > 0, seen[counts.argmax(axis=2)], UNKNOWN_CODE).astype(np.int32)
    return best, n, counts.sum(axis=2, dtype=np.int32), (counts > 0).sum(axis=2, dtype=np.int32)
