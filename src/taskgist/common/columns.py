"""Rows of numbers that come one by one: one array that grows in place, so that it is never held twice."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Number = TypeVar("Number", bound=np.generic)

ROWS = 4096
"""By as many rows it grows: whole pages, which the system moves without copying them."""


class Columns(Generic[Number]):
    """A growing table.

    Args:
        width: Numbers in a row; None for a single column, whose rows are plain numbers.
        kind: Their type.
    """

    def __init__(self, width: int | None, kind: type[Number]) -> None:
        self._rows = np.zeros(0 if width is None else (0, width), dtype=kind)
        self._count = 0

    def __len__(self) -> int:
        """Number of rows."""
        return self._count

    def append(self, row: ArrayLike) -> None:
        """Take another row."""
        if self._count == len(self._rows):
            self._resize(self._count + ROWS)
        self._rows[self._count] = row
        self._count += 1

    def row(self, index: int) -> NDArray[Number]:
        """A copy of a row, (width,).

        Raises:
            IndexError: There is no such row.
        """
        if not -self._count <= index < self._count:
            raise IndexError(index)
        return np.array(self._rows[index % self._count])

    def finished(self) -> NDArray[Number]:
        """All rows, (n, width) or (n,), read-only; no more may come."""
        self._resize(self._count)
        self._rows.flags.writeable = False
        return self._rows

    def _resize(self, count: int) -> None:
        # Nobody else has a view of the rows, which may move: a row is copied in and out.
        self._rows.resize((count, *self._rows.shape[1:]), refcheck=False)
