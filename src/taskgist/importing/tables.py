"""Reads tracks from the sources of a mapping; each file is opened once.

A reference (source, point) is resolved in five steps: find the part of a table that belongs to the point, read
positions, blank out what the tracker did not know, read times and orientations, and go from the source's axes to the
room's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from collections.abc import Mapping as AnyMapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.common.array_files import ArrayFile
from taskgist.common.arrays import Array, Mask
from taskgist.common.files import shown_path
from taskgist.errors import MappingError
from taskgist.importing.csv import CsvPart, CsvTable
from taskgist.importing.mapping import (
    Columns,
    Frame,
    ImportMapping,
    Markers,
    Name,
    PointRef,
    Rotation,
    SignalColumn,
    Source,
)
from taskgist.importing.mat import MatFile
from taskgist.importing.readers import READERS, read_take
from taskgist.importing.table_values import (
    Part,
    Tokens,
    Track,
    check_identities,
    check_zeros,
    is_identity,
    read_times,
    smoothed,
    wxyz_from_numbers,
)
from taskgist.importing.takes import Take, part_of, series_of
from taskgist.settings import DEFAULT, Limits
from taskgist.world.geometry.transforms import changed_frame, matrix_from_wxyz

# --- Tables as NumPy arrays: one array with an axis for time, or several (NPZ).

USUAL_LAYOUTS: dict[int, tuple[Name, ...]] = {
    1: ("time",),
    2: ("time", "value"),
    3: ("time", "{point}", "value"),
    4: ("time", "{person}", "{point}", "value"),
}
"""Axes of an array whose layout the mapping leaves out, by their number."""


class ArrayTable:
    """The arrays of an NPZ or NPY file, or of one of MATLAB.

    Args:
        file: The file.
        kind: "npz", "npy" or "mat".
        where: The mapping and source that name it, for messages.
        most_bytes: What the arrays that are asked for may take together; of MATLAB, the whole file.

    Raises:
        MappingError: The file is missing or holds no plain arrays.
    """

    def __init__(self, file: Path, kind: str, where: str, *, most_bytes: int = DEFAULT.limits.table_bytes) -> None:
        self.where = f"{where}: {shown_path(file)}"
        self._arrays: ArrayFile | MatFile
        if kind == "mat":
            self._arrays = MatFile(file, most_bytes=most_bytes, where=self.where)
        else:
            self._arrays = ArrayFile(file, most_bytes=most_bytes, where=self.where, error=MappingError)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the arrays."""
        return self._arrays.names

    def array(self, name: str | None) -> NDArray[np.generic]:
        """An array by name; ``None`` is the only one.

        Raises:
            UnknownNameError: There is no such array.
            MappingError: It holds no numbers, nothing, or more than may be loaded; or no name is given, and there are
                several.
        """
        names = self._arrays.names
        if name is None and len(names) == 1:
            name = names[0]
        if name is None:
            hint = f'add array = "NAME" (known: {", ".join(names)})'
            raise MappingError("the file holds several arrays", where=self.where, field="array", hint=hint)
        array = self._arrays.array(name)
        if array.dtype.kind not in "fiu":
            raise MappingError("not an array of numbers", where=self.where, field=name, value=str(array.dtype))
        if not array.size:
            hint = "the table is empty: check the file"
            raise MappingError("holds no numbers", where=self.where, field=name, value=array.shape, hint=hint)
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

    @property
    def oriented(self) -> bool:
        """All points of an array are alike."""
        return True

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

    def beside(self, name: str) -> ArrayPart:
        """The same point in another array, laid out alike; another axis at its end is one more of values.

        Raises:
            UnknownNameError: There is no such array.
            MappingError: It holds no numbers, or more than may be loaded.
        """
        axes, more = self.table.array(self.name).ndim, self.table.array(name).ndim
        layout = self.layout or USUAL_LAYOUTS.get(axes, ())
        return replace(self, name=name, layout=(*layout, *(("value",) * (more - axes))))

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


def input_files(mapping: ImportMapping) -> tuple[Path, ...]:
    """Every file that an import reads: mappings, tables and meshes. None of them may be written over.

    Args:
        mapping: A loaded mapping.
    """
    refs = [(ref.source, person.token, ref.point) for person in mapping.people for p in person.points for ref in p.refs]
    refs += [(each.pose.source, "", each.pose.point) for each in mapping.posed if isinstance(each.pose, PointRef)]
    refs += [(ref.source, "", ref.point) for t in mapping.objects if isinstance(t.pose, Markers) for ref in t.pose.refs]
    refs += [(robot.joints.source, "", "") for robot in mapping.robots if robot.joints is not None]
    refs += [(signal.source, "", signal.name) for signal in mapping.signals]
    tables = [
        mapping.data_dir / Tokens(source, person, point, "").filled(source.file)
        for name, person, point in refs
        for source in [mapping.source(name)]
    ]
    meshes = [shape.mesh for thing in mapping.objects for shape in thing.shapes if shape.mesh is not None]
    return tuple(dict.fromkeys([*mapping.files, *tables, *meshes]))


Samples = AnyMapping[str, tuple[tuple[PointRef, Track], ...]]
"""The source points of each landmark of one person, and their samples."""


class Tables:
    """The tables of a mapping, opened as they are needed.

    Args:
        mapping: A loaded mapping.
        limits: How much is read of a table.
    """

    def __init__(self, mapping: ImportMapping, *, limits: Limits = DEFAULT.limits) -> None:
        self._mapping = mapping
        self._most_bytes = limits.table_bytes
        self._opened: dict[tuple[Path, str], CsvTable | ArrayTable | Take] = {}

    def track(self, ref: PointRef, person: Name = "") -> Track:
        """Samples of one point.

        Args:
            ref: Source and point.
            person: What ``{person}`` stands for.

        Raises:
            MappingError: The table is missing or broken; times run backwards; a cell holds no number, or no rotation.
            UnknownNameError: A column, array or point that does not exist.
        """
        source = self._mapping.source(ref.source)
        tokens = Tokens(source, person, ref.point, f"{self._mapping.file}: sources.{source.name}")
        part = self._part(source, tokens)
        position = part.numbers(tokens.columns(source.position))
        lost = _lost(part, tokens, position)
        wxyz = None
        if source.rotation is not None and part.oriented:
            turns = self._turns(part, tokens, source.rotation.array)
            wxyz = _orientations(turns, tokens, source.rotation, lost)
            if source.rotation.identity_is_lost:
                lost = lost | is_identity(wxyz)
                wxyz[lost] = np.nan
        position[lost] = np.nan
        _check_near(part, position, source.frame.scale_m)
        times_s, kept = read_times(part, source.clock, len(position))
        wxyz = None if wxyz is None else wxyz[kept]
        track = _in_room(times_s, position[kept], wxyz, source.frame, ref, part.where)
        return smoothed(track, source.smooth_s, max_gap_s=self._mapping.timeline.max_gap_s)

    def signal(self, column: SignalColumn) -> tuple[Array, Array]:
        """Times in seconds and values of a signal, (n,) each.

        Raises:
            MappingError: As ``track``.
            UnknownNameError: As ``track``.
        """
        return self._numbers(column.source, column.column, f"signals.{column.name}", column.name)

    def column(self, source: str, column: str) -> tuple[Array, Array]:
        """Times in seconds and values of a column of a source, (n,) each; errors as of ``track``."""
        return self._numbers(source, column, f"sources.{source}", column)

    def columns(self, source: str) -> frozenset[str]:
        """Names of the columns that a source has: series of a file of motion capture, else columns or arrays."""
        found = self._mapping.source(source)
        table = self._table(self._mapping.data_dir / found.file, found, f"{self._mapping.file}: sources.{source}")
        return frozenset(table.series if isinstance(table, Take) else table.names)

    def _numbers(self, name: str, column: Name, field: str, point: str) -> tuple[Array, Array]:
        source = self._mapping.source(name)
        tokens = Tokens(source, "", point, f"{self._mapping.file}: {field}")
        file = self._mapping.data_dir / tokens.filled(source.file)
        table = self._table(file, source, tokens.where)
        if isinstance(table, Take):
            series = series_of(table, str(column), f"{tokens.where}: {shown_path(file)}")
            return series.times_s + source.clock.offset_s, series.values
        part = self._part(source, tokens)
        values = part.numbers(tokens.columns(Columns((column,))))[:, 0]
        times_s, kept = read_times(part, source.clock, len(values))
        return times_s, values[kept]

    def _part(self, source: Source, tokens: Tokens) -> Part:
        file = self._mapping.data_dir / tokens.filled(source.file)
        table = self._table(file, source, tokens.where)
        form = source.table
        if isinstance(table, Take):
            return part_of(table, tokens.person, tokens.point, f"{tokens.where}: {shown_path(file)}")
        if isinstance(table, CsvTable):
            return CsvPart(table, table.rows_where([(c, tokens.filled(text)) for c, text in form.where]))
        name = None if form.array is None else tokens.filled(form.array)
        return ArrayPart(table, name, form.layout, tokens.index_of)

    def _turns(self, part: Part, tokens: Tokens, array: str | None) -> Part:
        """The part with the orientations of a point: that of its positions, or another array of the same file."""
        if array is None:
            return part
        assert isinstance(part, ArrayPart)  # others have no arrays
        return part.beside(tokens.filled(array))

    def _table(self, file: Path, source: Source, where: str) -> CsvTable | ArrayTable | Take:
        key = (file, source.name)
        if key not in self._opened:
            self._opened[key] = _opened(file, source, where, self._most_bytes)
        return self._opened[key]


def _opened(file: Path, source: Source, where: str, most_bytes: int) -> CsvTable | ArrayTable | Take:
    if source.kind in READERS:
        return read_take(file, source.kind, where=f"{where}: {shown_path(file)}", most_bytes=most_bytes)
    if source.kind == "csv":
        return CsvTable(file, source.table, where, most_bytes=most_bytes)
    return ArrayTable(file, source.kind, where, most_bytes=most_bytes)


def _lost(part: Part, tokens: Tokens, position: Array) -> Mask:
    """Rows in which the tracker did not know the point."""
    source = tokens.source
    _check_finite(part, position, "position")
    lost = np.isnan(position).any(axis=1) | _is_sentinel(position, source)
    if source.missing is None:
        check_zeros(part, tokens, position)
    if source.confidence is not None:
        column = Columns((source.confidence.column,))
        confidence = part.numbers(tokens.columns(column))[:, 0]
        lost |= ~(confidence >= source.confidence.least)  # NaN is no confidence at all
    return np.asarray(lost)


def _orientations(part: Part, tokens: Tokens, rotation: Rotation, lost: Mask) -> Array:
    numbers = part.numbers(tokens.columns(rotation.columns))
    if len(numbers) != len(lost):
        problem, hint = f"there are {len(lost)} positions, but {len(numbers)} orientations", "check array and layout"
        raise MappingError(problem, where=part.where, field="rotation", hint=hint)
    _check_finite(part, numbers, "rotation")
    numbers[lost | _is_sentinel(numbers, tokens.source)] = np.nan
    wxyz, bad = wxyz_from_numbers(numbers, rotation)
    if bad.any():
        row = int(np.argmax(bad))
        raise MappingError(
            "the numbers are no rotation",
            where=f"{part.where}, {part.place(row)}",
            field=f"rotation ({rotation.kind})",
            value=[float(number) for number in numbers[row]],
            hint='check kind and columns; rows that mean "not tracked" are declared by missing = 0',
        )
    if rotation.identity_is_lost is None:
        check_identities(part, tokens, wxyz)
    return wxyz


def _is_sentinel(numbers: Array, source: Source) -> Mask:
    sentinel = np.zeros(len(numbers), dtype=np.bool_)
    for value in source.missing or ():
        sentinel |= (numbers == value).all(axis=1)
    return sentinel


def _check_finite(part: Part, numbers: Array, field: str) -> None:
    infinite = np.isinf(numbers).any(axis=1)
    if infinite.any():
        row = int(np.argmax(infinite))
        raise MappingError(
            "is infinite",
            where=f"{part.where}, {part.place(row)}",
            field=field,
            value=[float(number) for number in numbers[row]],
            hint="leave the cell empty, or write NaN, where the tracker knew nothing",
        )


FARTHEST_M = 1e6
"""Nothing that is tracked is farther away; squares of larger numbers would be infinite at some time (ours)."""


def _check_near(part: Part, position: Array, scale_m: float) -> None:
    far = (np.abs(position) * scale_m > FARTHEST_M).any(axis=1)
    if far.any():
        row = int(np.argmax(far))
        raise MappingError(
            "is too far away",
            where=f"{part.where}, {part.place(row)}",
            field="position",
            value=[float(number) for number in position[row]],
            hint="check units, or declare by missing what stands for not tracked",
        )


def _in_room(times_s: Array, position: Array, wxyz: Array | None, frame: Frame, ref: PointRef, where: str) -> Track:
    """Into the room's axes.

    A left-handed source reflects; the body's own z axis is then flipped, so that its orientation stays a rotation, and
    ``signs`` says so.
    """
    axes = np.array(frame.turn) @ np.array(frame.axes)
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
    position_m = position * frame.scale_m @ axes.T + np.array(frame.position_m)
    if wxyz is not None:
        wxyz = changed_frame(wxyz, axes, np.diag(signs))
    if ref.offset_m is not None:
        if wxyz is None:
            hint = "drop offset_m, or add the rotation to the source"
            raise MappingError("a bare point has no axes for an offset", where=where, field="offset_m", hint=hint)
        position_m = position_m + matrix_from_wxyz(wxyz) @ (signs * np.array(ref.offset_m))
    return Track(times_s, position_m, wxyz, signs, where)
