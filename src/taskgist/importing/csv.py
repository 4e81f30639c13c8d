"""Tables of text: comma, semicolon, tab or blank between columns, one row per frame (or per frame and body)."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.errors import MappingError, UnknownNameError
from taskgist.importing.mapping import Name, TableFormat

# --- Lines of text to cells, and cells to numbers.

_DELIMITERS = ("\t", ";", ",", "|")
_SAMPLE_LINES = 20


def split(lines: list[str], delimiter: str) -> list[list[str]]:
    """Cells of each line; "whitespace" cuts at runs of blanks."""
    if delimiter == "whitespace":
        return [line.split() for line in lines]
    return list(csv.reader(lines, delimiter=delimiter, skipinitialspace=True))


def sniffed(lines: list[str], decimal: str) -> str:
    """The delimiter on whose number of columns most of the first lines agree; the more columns, the better."""
    best, most = "whitespace", (0, 1)
    for delimiter in _DELIMITERS:
        widths = Counter(len(row) for row in split(lines[:_SAMPLE_LINES], delimiter))
        width, agreeing = widths.most_common(1)[0]
        if delimiter != decimal and width > 1 and (agreeing, width) > most:
            best, most = delimiter, (agreeing, width)
    return best


def comparable(text: str) -> str:
    """A text for comparison: 1, 1.0 and 01 are the same."""
    value = number(text.strip())
    return text.strip() if math.isnan(value) else repr(value)


def number(text: str) -> float:
    """The number that a text stands for, or NaN."""
    try:
        return float(text)
    except ValueError:
        return math.nan


MOST_SHOWN = 12
"""Values of a column that a message lists."""
_MISSING = frozenset({"", "nan", "na", "n/a", "none", "null"})


class CsvTable:
    """A file of text, taken apart once; columns become numbers when they are first asked for.

    Args:
        file: The file.
        form: How to take it apart.
        where: The mapping and source that name it, for messages.

    Raises:
        MappingError: The file is missing, empty, no text, or has rows of different lengths.
    """

    def __init__(self, file: Path, form: TableFormat, where: str) -> None:
        self.where = f"{where}: {file}"
        self._decimal = form.decimal
        kept = self._kept_lines(file, form)
        lines = list(kept.values())
        rows = self._split(lines, form.delimiter or sniffed(lines, form.decimal))
        named = form.header if form.header is not None else not any(map(self._is_number, rows[0]))
        self._header = tuple(cell.strip() for cell in rows[0]) if named else None
        self._rows = rows[1:] if named else rows
        self._lines = list(kept)[1 if named else 0 :]
        self._check_lengths(len(rows[0]))
        self._columns: dict[int, tuple[Array, dict[int, str]]] = {}
        self._groups: dict[tuple[int, ...], dict[tuple[str, ...], list[int]]] = {}

    def rows_where(self, conditions: Sequence[tuple[Name, str]]) -> Indices:
        """Indices of the rows that have these texts (or equal numbers) in these columns."""
        if not conditions:
            return np.arange(len(self._rows))
        columns = tuple(self._index(column) for column, _ in conditions)
        groups = self._groups.setdefault(columns, {}) or self._group(columns)
        found = groups.get(tuple(comparable(text) for _, text in conditions))
        if found is None:
            wanted = {str(column): text for column, text in conditions}
            hint = f"change where, person or point ({_held(list(wanted), groups)})"
            raise MappingError("no row has these values", where=self.where, field="where", value=wanted, hint=hint)
        return np.array(found)

    def numbers(self, columns: Sequence[Name], rows: Indices) -> Array:
        """Numbers in some columns of some rows, (rows, columns); NaN where cells are empty.

        Raises:
            UnknownNameError: There is no such column.
            MappingError: A cell holds no number.
        """
        result = np.empty((len(rows), len(columns)))
        for k, column in enumerate(columns):
            values, bad = self._column(self._index(column))
            if bad and (hit := next((row for row in rows.tolist() if row in bad), None)) is not None:
                raise MappingError(
                    "is no number",
                    where=f"{self.where}, {self.place(hit)}",
                    field=f"column {column!r}",
                    value=bad[hit],
                    hint="mend the cell or leave it empty; check delimiter and decimal",
                )
            result[:, k] = values[rows]
        return result

    def place(self, row: int) -> str:
        """Where a row stands in the file."""
        return f"line {self._lines[row]}"

    def _kept_lines(self, file: Path, form: TableFormat) -> dict[int, str]:
        """Lines with something in them, by their number in the file."""
        lines = {
            line_number: line
            for line_number, line in enumerate(self._text(file).splitlines(), start=1)
            if line_number > form.skip_rows and line.strip() and not (form.comment and line.startswith(form.comment))
        }
        if not lines:
            raise MappingError("the table is empty", where=self.where, hint="check file and skip_rows")
        return lines

    def _split(self, lines: list[str], delimiter: str) -> list[list[str]]:
        try:
            return split(lines, delimiter)
        except csv.Error as problem:
            raise MappingError(f"no table of text: {problem}", where=self.where, hint="set format") from None

    def _text(self, file: Path) -> str:
        try:
            return file.read_text(encoding="utf-8-sig")
        except OSError as problem:
            reason = problem.strerror or str(problem)
            hint = "check file, person and point, and the data folder"
            raise MappingError("cannot read the table", where=self.where, value=reason, hint=hint) from None
        except UnicodeDecodeError:
            hint = "save it as UTF-8 text, or set format"
            raise MappingError("the table is not text", where=self.where, hint=hint) from None

    def _is_number(self, cell: str) -> bool:
        return cell.strip() != "" and not math.isnan(self._number(cell))

    def _number(self, cell: str) -> float:
        text = cell.strip()
        return number(text.replace(self._decimal, ".") if self._decimal != "." else text)

    def _check_lengths(self, width: int) -> None:
        if not self._rows:
            raise MappingError("the table has no rows below its header", where=self.where)
        for row, cells in enumerate(self._rows):
            if len(cells) != width:
                raise MappingError(
                    f"the row has {len(cells)} cells, the first one {width}",
                    where=f"{self.where}, {self.place(row)}",
                    hint="the file may be cut off; else set delimiter, skip_rows or comment",
                )

    def _index(self, column: Name) -> int:
        """Position of a column; a text of digits is an index where there is no header."""
        if self._header is None and isinstance(column, str) and column.isdigit():
            column = int(column)
        if isinstance(column, int):
            if column >= len(self._rows[0]):
                hint = f"the table has columns 0 to {len(self._rows[0]) - 1}; check delimiter, first and step"
                raise MappingError("no such column", where=self.where, field="columns", value=column, hint=hint)
            return column
        if self._header is None:
            hint = "give indices from 0, or set header = true"
            raise MappingError("the table has no header", where=self.where, field="columns", value=column, hint=hint)
        if self._header.count(column) > 1:
            hint = "give its index from 0"
            raise MappingError("two columns have the name", where=self.where, value=column, hint=hint)
        if column not in self._header:
            raise UnknownNameError("column", column, self._header, where=self.where)
        return self._header.index(column)

    def _column(self, index: int) -> tuple[Array, dict[int, str]]:
        """Numbers of a whole column, and the texts in it that are none (they matter only in rows that are used)."""
        if index not in self._columns:
            bad: dict[int, str] = {}
            values = np.full(len(self._rows), np.nan)
            for row, cells in enumerate(self._rows):
                text = cells[index].strip()
                if text.lower() in _MISSING:
                    continue
                values[row] = self._number(text)
                if not math.isfinite(values[row]):
                    bad[row] = text
            self._columns[index] = values, bad
        return self._columns[index]

    def _group(self, columns: tuple[int, ...]) -> dict[tuple[str, ...], list[int]]:
        groups = self._groups[columns]
        for row, cells in enumerate(self._rows):
            groups.setdefault(tuple(comparable(cells[column]) for column in columns), []).append(row)
        return groups


@dataclass(frozen=True, eq=False)
class CsvPart:
    """The rows of a table of text that belong to one point.

    Attributes:
        table: The whole table.
        rows: Indices of the rows, (n,).
    """

    table: CsvTable
    rows: Indices

    @property
    def where(self) -> str:
        """Mapping, source and file."""
        return self.table.where

    def numbers(self, columns: Sequence[Name]) -> Array:
        """Numbers in these columns, (rows, columns); errors as of the table."""
        return self.table.numbers(columns, self.rows)

    def place(self, row: int) -> str:
        """Line in the file."""
        return self.table.place(int(self.rows[row]))


def _held(columns: Sequence[str], groups: Collection[tuple[str, ...]]) -> str:
    """What each column holds, a dozen values of it at most."""
    values = [sorted({key[k].removesuffix(".0") for key in groups}) for k in range(len(columns))]
    texts = [", ".join(v[:MOST_SHOWN]) + (", ..." if len(v) > MOST_SHOWN else "") for v in values]
    return "; ".join(f"{column} has: {text}" for column, text in zip(columns, texts, strict=True))
