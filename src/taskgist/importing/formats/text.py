"""Text files of motion capture: their lines, and rows of numbers below headers that each program lays out otherwise."""

from __future__ import annotations

import math
from array import array
from codecs import BOM_UTF8
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array
from taskgist.common.files import read_whole
from taskgist.errors import MappingError
from taskgist.importing.csv import number

LOST = frozenset({"", "nan", "-nan", "nan(ind)", "-nan(ind)", "null", "none"})
"""What programs write for points that they did not see."""
LARGEST = 1e9
"""No length, angle or number of a frame is larger (ours)."""


def read_lines(path: Path, where: str, most_bytes: int) -> list[str]:
    """The lines of a text file, without their ends.

    Raises:
        MappingError: It cannot be read, is too large, or is no text.
    """
    content = read_whole(path, most_bytes=most_bytes, setting="table_bytes", error=MappingError)
    try:
        return content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        try:
            return content.decode("cp1252").splitlines()  # names with accents, written on Windows
        except UnicodeDecodeError:
            raise MappingError("the file is not text", where=where, hint="save it as UTF-8") from None


def begins(head: bytes, beginnings: bytes | tuple[bytes, ...]) -> bool:
    """Whether a text that begins with some bytes begins so, a mark of UTF-8 left aside."""
    return head.removeprefix(BOM_UTF8).startswith(beginnings)


def cells(line: str, delimiter: str) -> list[str]:
    """The cells of a line of a header, without quotes and blanks around them."""
    return [cell.strip().strip('"').strip() for cell in line.split(delimiter)]


def number_rows(
    lines: Iterable[tuple[int, str]], columns: Sequence[str], delimiter: str, where: str, *, whole: int = 0
) -> Array:
    """Rows of numbers, (rows, columns); NaN where a cell is empty.

    Args:
        lines: Number in the file and text of each row.
        columns: What messages call the columns.
        delimiter: Between cells.
        where: The file, for messages.
        whole: Columns that a point takes, where programs leave out the empty cells of the last points of a row.

    Raises:
        MappingError: A row is shorter or longer than the header, or a cell holds no number.
    """
    values, width = array("d"), len(columns)
    for line, text in lines:
        row = text.split(delimiter)
        if len(row) != width:
            row = _fitted(row, width, whole, f"{where}, line {line}")
        # Python would also take 1_0 and the digits of every script for numbers
        quick = (float, _float_or_lost) if text.isascii() and "_" not in text else ()
        for convert in quick:
            try:
                values.extend(map(convert, row))
                break
            except ValueError:  # an empty cell, or no number
                del values[len(values) - len(values) % width :]
        else:
            place = f"{where}, line {line}"
            values.extend([_number(cell, place, name) for cell, name in zip(row, columns, strict=True)])
    found = np.frombuffer(values).reshape(-1, width).copy() if values else np.empty((0, width))
    if (np.abs(found) > LARGEST).any():  # NaN is not
        row, column = np.argwhere(np.abs(found) > LARGEST)[0]
        value = float(found[row, column])
        place = f"{where}, row {row + 1} of numbers"
        raise MappingError("is too large", where=place, field=f"column {columns[column]}", value=value, hint="mend it")
    return found


def _float_or_lost(cell: str) -> float:
    return float(cell) if cell and not cell.isspace() else math.nan


def _fitted(row: list[str], width: int, whole: int, where: str) -> list[str]:
    """A row as long as the header: without empty cells at its end, or with those that the program left out."""
    if not any(cell.strip() for cell in row[width:]):
        row = row[:width]
    short = width - len(row)
    if short and not (whole and short > 0 and short % whole == 0):
        hint = "the file may be cut off: export it again"
        raise MappingError(f"the row has {len(row)} cells, its header {width}", where=where, hint=hint)
    return [*row, *[""] * short]


def _number(cell: str, where: str, column: str) -> float:
    text = cell.strip().strip('"').lower()
    value = math.nan if text in LOST else number(text)
    if math.isnan(value) and text not in LOST:
        hint = "mend the cell or leave it empty"
        raise MappingError("is no number", where=where, field=f"column {column}", value=cell.strip(), hint=hint)
    return value


def header_number(text: str, where: str, field: str) -> float:
    """A positive number of a header.

    Raises:
        MappingError: It is none.
    """
    value = number(text.strip())
    if not value > 0.0:
        raise MappingError("must be a positive number", where=where, field=field, value=text, hint="mend the header")
    return value


UNITS = {
    spelled: unit
    for unit, names in {
        "m": ("m", "meter", "meters", "metre", "metres"),
        "cm": ("cm", "centimeter", "centimeters", "centimetre", "centimetres"),
        "mm": ("mm", "millimeter", "millimeters", "millimetre", "millimetres"),
        "inch": ("in", "inch", "inches"),
    }.items()
    for spelled in names
}
"""Units as programs spell them, and as a mapping does."""


def unit_of(text: str) -> str | None:
    """The unit that a header names, if it is one of ours."""
    return UNITS.get(text.strip().lower())
