"""Tables of numbers that come row by row, as many as a day of motion has, in little memory and never held twice."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin
from numpy.typing import ArrayLike, NDArray

from taskgist.common.arrays import Array

Number = TypeVar("Number", bound=np.generic)

ROWS = 4096
"""Rows of a block."""


class Columns(Generic[Number]):
    """A table that grows in place.

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

    def finished(self) -> NDArray[Number]:
        """All rows, (n, width) or (n,), read-only; no more may come."""
        self._resize(self._count)
        self._rows.flags.writeable = False
        return self._rows

    def _resize(self, count: int) -> None:
        # Nobody has a view of the rows, and the system moves whole pages without copying them.
        self._rows.resize((count, *self._rows.shape[1:]), refcheck=False)


class PackedRows(NDArrayOperatorsMixin):
    """A table of decimals: blocks that are exact in whole numbers of their last decimal take half the memory.

    It is read as an array is, and gives the very numbers that it was given. What else an array can do, it does as an
    array of its own, made for the occasion::

        rows[7]            one row, (width,)
        rows[100:200]      some, (100, width)
        rows[:, 3:10]      columns of all, (n, 7)
        np.asarray(rows)   all, (n, width): an array of its own

    Args:
        scale: 10 to the power of the decimals of each column, (width,).
    """

    def __init__(self, scale: Array) -> None:
        self._scale = scale
        self._blocks: list[Array | NDArray[np.int32]] = []
        self._open = np.empty((ROWS, len(scale)))
        self._count = 0

    def append(self, row: Array) -> None:
        """Take another row, (width,)."""
        self._open[self._count % ROWS] = row
        self._count += 1
        if self._count % ROWS == 0:
            self._blocks.append(self._packed(self._open))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self._count, len(self._scale)

    def __len__(self) -> int:
        """Number of rows."""
        return self._count

    def __getitem__(self, key: Any) -> Array:
        """Rows, or columns of rows, as an array of their own."""
        rows, columns = key if isinstance(key, tuple) else (key, slice(None))
        if isinstance(rows, int | np.integer):
            if not -self._count <= rows < self._count:
                raise IndexError(rows)
            block, row = divmod(int(rows) % self._count, ROWS)
            numbers: Array = self._unpacked(block, slice(row, row + 1), columns)[0]
            return numbers
        if isinstance(rows, slice) and rows.step in (None, 1):
            first, last, _ = rows.indices(self._count)
            parts = [
                self._unpacked(block, slice(max(first - block * ROWS, 0), last - block * ROWS), columns)
                for block in range(first // ROWS, -(-last // ROWS))
            ]
            return np.concatenate(parts or [self._unpacked(0, slice(0), columns)])
        return np.asarray(self[:, columns][rows])

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self[:], name)

    def __array_ufunc__(self, function: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        """Calculations, with an array of all rows."""
        arrays = (each[:] if isinstance(each, PackedRows) else each for each in inputs)
        return getattr(function, method)(*arrays, **options)

    def __iter__(self) -> Iterator[Array]:
        """Row by row."""
        return (self[index] for index in range(self._count))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """All rows as an array."""
        array: NDArray[Any] = self[:].astype(dtype or np.float64, copy=False)
        return array

    def _block(self, number: int) -> Array | NDArray[np.int32]:
        return self._blocks[number] if number < len(self._blocks) else self._open[: self._count % ROWS]

    def _unpacked(self, number: int, rows: slice, columns: Any) -> Array:
        part = self._block(number)[rows, columns]
        return np.array(part / self._scale[columns] if part.dtype == np.int32 else part, dtype=np.float64)

    def _packed(self, rows: Array) -> Array | NDArray[np.int32]:
        whole = np.rint(rows * self._scale)
        if (np.abs(whole) < 2**31).all() and (whole / self._scale == rows).all():
            return whole.astype(np.int32)
        return np.array(rows)
