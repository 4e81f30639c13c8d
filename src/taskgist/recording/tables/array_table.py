"""Tables as NumPy arrays: one array with an axis for time, or several (NPZ)."""

from __future__ import annotations

import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import MappingError, UnknownNameError
from taskgist.recording.mapping.source_model import Name

Array = NDArray[np.float64]

USUAL_LAYOUTS: dict[int, tuple[Name, ...]] = {
    1: ("time",),
    2: ("time", "value"),
    3: ("time", "{point}", "value"),
    4: ("time", "{person}", "{point}", "value"),
}
"""Axes of an array whose layout the mapping leaves out, by their number."""


class ArrayTable:
    """The arrays of an NPZ or NPY file.

    Args:
        file: The file.
        where: The mapping and source that name it, for messages.

    Raises:
        MappingError: The file is missing or holds no plain arrays.
    """

    def __init__(self, file: Path, where: str) -> None:
        self.where = f"{where}: {file}"
        try:
            self._arrays = _loaded(file)
        except OSError as problem:
            reason = problem.strerror or str(problem)
            hint = "check file, person and point, and the data folder"
            raise MappingError("cannot read the arrays", where=self.where, value=reason, hint=hint) from None
        except (ValueError, EOFError, zipfile.BadZipFile):
            hint = "save plain arrays of numbers with numpy.savez or numpy.save"
            raise MappingError("not a file of plain arrays", where=self.where, hint=hint) from None

    def array(self, name: str | None) -> NDArray[np.generic]:
        """An array by name; ``None`` is the only one.

        Raises:
            UnknownNameError: There is no such array.
            MappingError: It holds no numbers; or no name is given, and there are several.
        """
        if name is None and len(self._arrays) == 1:
            name = next(iter(self._arrays))
        if name is None:
            hint = f'add array = "NAME" (known: {", ".join(self._arrays)})'
            raise MappingError("the file holds several arrays", where=self.where, field="array", hint=hint)
        if name not in self._arrays:
            raise UnknownNameError("array", name, self._arrays, where=self.where)
        array = self._arrays[name]
        if array.dtype.kind not in "fiu":
            raise MappingError("not an array of numbers", where=self.where, field=name, value=str(array.dtype))
        return array


@dataclass(frozen=True)
class ArrayPart:
    """The part of the arrays that belongs to one point.

    Attributes:
        table: All arrays of the file.
        name: Array with the positions (and what else has an index); ``None``: the only one.
        layout: What each of its axes is; empty: the usual one for that number of axes.
        index_of: Index that a placeholder stands for, "{person}" or "{point}".
    """

    table: ArrayTable
    name: str | None
    layout: tuple[Name, ...]
    index_of: Callable[[str], int]

    @property
    def where(self) -> str:
        """Mapping, source and file."""
        return self.table.where

    def numbers(self, columns: Sequence[Name]) -> Array:
        """Values by index in the array of positions, or other arrays by name, (time, columns).

        Raises:
            UnknownNameError: There is no such array.
            MappingError: The layout does not fit, an index is out of range, or arrays differ in length.
        """
        found = [self._value(c) if isinstance(c, int) else self._other(c) for c in columns]
        if len({len(column) for column in found}) > 1:
            raise MappingError("arrays differ in length", where=self.where, field="columns", value=list(columns))
        return np.column_stack(found)

    def place(self, row: int) -> str:
        """Index of the frame."""
        return f"frame {row}"

    def _value(self, index: int) -> Array:
        array = self.table.array(self.name)
        values = self._selected(array, self.layout or USUAL_LAYOUTS.get(array.ndim, ()))
        if index >= values.shape[1]:
            hint = f"there are the values 0 to {values.shape[1] - 1}; check columns and layout"
            raise MappingError("no such value", where=self.where, field="columns", value=index, hint=hint)
        return np.asarray(values[:, index])

    def _other(self, name: str) -> Array:
        """An array of its own: time, confidence, or a single coordinate; laid out as the positions, without values."""
        array = self.table.array(name)
        axes = self.layout or USUAL_LAYOUTS.get(array.ndim + 1, ())
        return self._selected(array, ("time",) if array.ndim == 1 else tuple(a for a in axes if a != "value"))[:, 0]

    def _selected(self, array: NDArray[np.generic], axes: tuple[Name, ...]) -> Array:
        """One point of an array, (time, values)."""
        if len(axes) != array.ndim or "time" not in axes:
            hint = 'name each axis, as layout = ["time", "{person}", "{point}", "value"]'
            problem = f"the layout does not fit an array of shape {array.shape}"
            raise MappingError(problem, where=self.where, field="layout", value=list(axes), hint=hint)
        kept = [axis for axis in axes if axis in ("time", "value")]
        picks = [
            slice(None) if axis in ("time", "value") else self._pick(axis, size)
            for axis, size in zip(axes, array.shape, strict=True)
        ]
        part = np.moveaxis(array[tuple(picks)], kept.index("time"), 0)
        return np.asarray(part.reshape(part.shape[0], -1), dtype=np.float64)

    def _pick(self, axis: Name, size: int) -> int:
        index = axis if isinstance(axis, int) else self.index_of(axis)
        if index >= size:
            hint = f"that axis has the indices 0 to {size - 1}; check layout, person and point"
            field = f"layout: {axis}"
            raise MappingError("the index is out of range", where=self.where, field=field, value=index, hint=hint)
        return index


def _loaded(file: Path) -> dict[str, NDArray[np.generic]]:
    with file.open("rb") as stream:  # opened here, because numpy leaves broken archives open
        loaded = np.load(stream, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            return {file.name: loaded}
        return {name: loaded[name] for name in loaded.files}
