"""A number with its spread over draws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import SupportsFloat

import numpy as np
from numpy.typing import ArrayLike

LOW, HIGH = 0.1, 0.9
"""Quantiles that tell the spread: four of five draws lie between them."""


@dataclass(frozen=True)
class Spread:
    """Mean and spread over draws; all are None where no draw gives a number."""

    mean: float | None
    low: float | None
    """10 % quantile."""
    high: float | None
    """90 % quantile."""
    count: int
    """Draws that give a number."""

    @staticmethod
    def of(values: ArrayLike) -> Spread:
        """Of numbers, NaN where a draw gives none."""
        known = np.asarray(values, dtype=np.float64).ravel()
        known = known[~np.isnan(known)]
        if not len(known):
            return Spread(None, None, None, 0)
        low, high = np.quantile(known, (LOW, HIGH))
        return Spread(rounded(known.mean()), rounded(low), rounded(high), len(known))


def rounded(value: SupportsFloat) -> float:
    """To four decimals: more would be noise."""
    return round(float(value), 4)
