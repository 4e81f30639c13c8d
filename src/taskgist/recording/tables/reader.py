"""Reads tracks from the sources of a mapping; each file is opened once.

A reference (source, point) is resolved in five steps: find the part of a table that belongs to the point, read
positions, blank out what the tracker did not know, read times and orientations, and go from the source's axes to the
room's.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from taskgist.errors import MappingError
from taskgist.recording.mapping.model import Mapping, PointRef, SignalColumn
from taskgist.recording.mapping.source_model import Columns, Frame, Name, Rotation, Source
from taskgist.recording.rotations import Array, changed_frame
from taskgist.recording.tables.array_table import ArrayPart, ArrayTable
from taskgist.recording.tables.csv_table import CsvPart, CsvTable
from taskgist.recording.tables.orientation import wxyz_from_numbers
from taskgist.recording.tables.part import Part
from taskgist.recording.tables.smoothing import smoothed
from taskgist.recording.tables.times import read_times
from taskgist.recording.tables.tokens import Tokens
from taskgist.recording.tables.track import Track
from taskgist.recording.tables.zeros import check_zeros
from taskgist.world.geometry.rotations import matrix_from_wxyz


class Tables:
    """The tables of a mapping, opened as they are needed.

    Args:
        mapping: A loaded mapping.
    """

    def __init__(self, mapping: Mapping) -> None:
        self._mapping = mapping
        self._opened: dict[tuple[Path, str], CsvTable | ArrayTable] = {}

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
        wxyz = None if source.rotation is None else _orientations(part, tokens, source.rotation, lost)
        position[lost] = np.nan
        times_s = read_times(part, source.clock, len(position))
        track = _in_room(times_s, position, wxyz, source.frame, ref, part.where)
        return smoothed(track, source.smooth_s, max_gap_s=self._mapping.timeline.max_gap_s)

    def signal(self, column: SignalColumn) -> tuple[Array, Array]:
        """Times in seconds and values of a signal, (n,) each.

        Raises:
            MappingError: As ``track``.
            UnknownNameError: As ``track``.
        """
        source = self._mapping.source(column.source)
        tokens = Tokens(source, "", column.name, f"{self._mapping.file}: signals.{column.name}")
        part = self._part(source, tokens)
        values = part.numbers(tokens.columns(Columns((column.column,))))[:, 0]
        return read_times(part, source.clock, len(values)), values

    def _part(self, source: Source, tokens: Tokens) -> Part:
        file = self._mapping.data_dir / tokens.filled(source.file)
        table = self._table(file, source, tokens.where)
        form = source.table
        if isinstance(table, CsvTable):
            return CsvPart(table, table.rows_where([(c, tokens.filled(text)) for c, text in form.where]))
        name = None if form.array is None else tokens.filled(form.array)
        return ArrayPart(table, name, form.layout, tokens.index_of)

    def _table(self, file: Path, source: Source, where: str) -> CsvTable | ArrayTable:
        key = (file, source.name)
        if key not in self._opened:
            is_text = source.kind == "csv"
            self._opened[key] = CsvTable(file, source.table, where) if is_text else ArrayTable(file, where)
        return self._opened[key]


def _lost(part: Part, tokens: Tokens, position: Array) -> NDArray[np.bool_]:
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


def _orientations(part: Part, tokens: Tokens, rotation: Rotation, lost: NDArray[np.bool_]) -> Array:
    numbers = part.numbers(tokens.columns(rotation.columns))
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
    return wxyz


def _is_sentinel(numbers: Array, source: Source) -> NDArray[np.bool_]:
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
