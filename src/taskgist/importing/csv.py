"""Tables of text: comma, semicolon, tab or blank between columns, one row per frame (or per frame and body)."""

from __future__ import annotations

import csv
import io
import math
import re
from array import array
from collections import Counter, deque
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path
from typing import IO

import numpy as np

from taskgist.common.arrays import Array, Indices
from taskgist.common.files import reading, shown_path
from taskgist.common.text import shortened
from taskgist.errors import MappingError, UnknownNameError, most_read
from taskgist.importing.mapping import Name, TableFormat
from taskgist.settings import DEFAULT

# --- Lines of text to cells, and cells to numbers.

_DELIMITERS = ("\t", ";", ",", "|")
_SAMPLE_LINES = 20


def split(lines: Iterable[str], delimiter: str) -> Iterator[list[str]]:
    """Cells of each line; "whitespace" cuts at runs of blanks."""
    if delimiter == "whitespace":
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=delimiter, skipinitialspace=True)


def sniffed(lines: list[str], decimal: str) -> str:
    """The delimiter on whose number of columns most of the first lines agree; the more columns, the better."""
    best, most = "whitespace", (0, 1)
    for delimiter in _DELIMITERS:
        widths = Counter(len(row) for row in split(lines, delimiter))
        width, agreeing = widths.most_common(1)[0]
        if delimiter != decimal and width > 1 and (agreeing, width) > most:
            best, most = delimiter, (agreeing, width)
    return best


NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
"""How data sheets write numbers; Python would also take ``1_0``, ``infinity`` and the digits of every script."""


def number(text: str) -> float:
    """The number that a text stands for, or NaN."""
    return float(text) if NUMBER.fullmatch(text) else math.nan


LONGEST_LINE = 2**24
"""Characters of a line: a million columns."""
TEXT_BYTES = 200
"""What a cell takes that is kept as text, beside its letters."""
_MISSING = frozenset({"", "nan", "na", "n/a", "none", "null"})


class CsvTable:
    """A file of text, taken apart once: its numbers by row and column, and the texts among them.

    Args:
        file: The file.
        form: How to take it apart.
        where: The mapping and source that name it, for messages.
        most_bytes: What the table may take in memory.

    Raises:
        MappingError: The file is missing, empty, no text, too large, or has rows of different lengths.
    """

    def __init__(
        self, file: Path, form: TableFormat, where: str, *, most_bytes: int = DEFAULT.limits.table_bytes
    ) -> None:
        self.where = f"{where}: {shown_path(file)}"
        self._decimal = form.decimal
        self._header: tuple[str, ...] | None = None
        self._lines = array("q")
        """Number in the file of the line that each row ends with."""
        self._texts: dict[int, dict[int, str]] = {}
        """Cells that are no numbers and not empty, by column and row."""
        self._groups: dict[tuple[int, ...], dict[tuple[str, ...], list[int]]] = {}
        hint = "check file, person and point, and the data folder"
        with (
            self._told(file),
            reading(file, error=MappingError, hint=hint) as stream,
            io.TextIOWrapper(stream, encoding="utf-8-sig") as text,
        ):
            self._values = self._read(text, form, most_bytes)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns; none without a header."""
        return self._header or ()

    def rows_where(self, conditions: Sequence[tuple[Name, str]]) -> Indices:
        """Indices of the rows that have these texts (or equal numbers) in these columns."""
        if not conditions:
            return np.arange(len(self._values))
        columns = tuple(self._index(column) for column, _ in conditions)
        groups = self._groups.setdefault(columns, {}) or self._group(columns)
        found = groups.get(tuple(self._comparable(text) for _, text in conditions))
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
        indices = [self._index(column) for column in columns]
        for column, index in zip(columns, indices, strict=True):
            texts = self._texts.get(index, {})
            bad = {row for row, text in texts.items() if text.lower() not in _MISSING}
            if bad and (hit := next((row for row in rows.tolist() if row in bad), None)) is not None:
                raise MappingError(
                    "is no number",
                    where=f"{self.where}, {self.place(hit)}",
                    field=f"column {column!r}",
                    value=texts[hit],
                    hint="mend the cell or leave it empty; check delimiter and decimal",
                )
        return np.asarray(self._values[rows[:, None], np.array(indices, dtype=np.intp)])

    def place(self, row: int) -> str:
        """Where a row stands in the file."""
        return f"line {self._lines[row]}"

    def _read(self, text: IO[str], form: TableFormat, most_bytes: int) -> Array:
        """Take the file apart: many lines at once where they hold nothing but numbers, else line after line."""
        kept = self._kept_lines(text, form)
        first = list(islice(kept, _SAMPLE_LINES))
        if not first:
            raise MappingError("the table is empty", where=self.where, hint="check file and skip_rows")
        delimiter = form.delimiter or sniffed([line for _, line in first], form.decimal)
        rows = _Rows(chain(first, kept), delimiter)
        values, width, left = array("d"), 0, most_bytes
        while True:
            block = rows.numbers(form.decimal, width) if width else None
            if block is None:
                cells = next(rows, None)
                if cells is None:
                    break
                if not width:
                    width = len(cells)
                    if form.header or (form.header is None and not any(map(self._is_number, cells))):
                        self._header = tuple(cell.strip() for cell in cells)
                        continue
                self._check_length(cells, width, rows.at)
                left -= 8 * (width + 1) + self._add(cells, values)
                self._lines.append(rows.at)
            else:
                left -= 8 * (width + 1) * len(block)
                values.frombytes(block.tobytes())
                self._lines.extend(rows.block)
            if left < 0:
                hint = most_read(most_bytes, "table_bytes")
                raise MappingError("the table is too large", where=f"{self.where}, line {rows.at}", hint=hint)
        if not len(self._lines):
            raise MappingError("the table has no rows below its header", where=self.where)
        return np.frombuffer(values).reshape(-1, width)

    def _add(self, cells: list[str], values: array[float]) -> int:
        """Add a row; what its texts take, bytes."""
        taken, row = 0, len(self._lines)
        for column, cell in enumerate(cells):
            text = cell.strip()
            value = self._number(text) if text else math.nan
            if not math.isfinite(value):
                value = math.nan
                if text:
                    self._texts.setdefault(column, {})[row] = text
                    taken += TEXT_BYTES + len(text)
            values.append(value)
        return taken

    def _kept_lines(self, text: IO[str], form: TableFormat) -> Iterator[tuple[int, str]]:
        """Lines with something in them, and their number in the file."""
        for number_, line in enumerate(iter(lambda: text.readline(LONGEST_LINE), ""), start=1):
            if len(line) >= LONGEST_LINE:
                hint = "save it as a table with a line for each frame, or set format"
                raise MappingError("a line without end", where=f"{self.where}, line {number_}", hint=hint)
            if number_ > form.skip_rows and line.strip() and not (form.comment and line.startswith(form.comment)):
                yield number_, line.rstrip("\r\n")

    @contextmanager
    def _told(self, file: Path) -> Iterator[None]:
        try:
            yield
        except MappingError as problem:
            problem.where = self.where if problem.where == shown_path(file) else problem.where
            raise
        except UnicodeDecodeError:
            hint = "save it as UTF-8 text, or set format"
            raise MappingError("the table is not text", where=self.where, hint=hint) from None
        except csv.Error as problem:
            raise MappingError(f"no table of text: {problem}", where=self.where, hint="set format") from None

    def _is_number(self, cell: str) -> bool:
        return not math.isnan(self._number(cell.strip()))

    def _number(self, text: str) -> float:
        return number(text.replace(self._decimal, ".") if self._decimal != "." else text)

    def _comparable(self, text: str) -> str:
        """A text for comparison: 1, 1.0 and 01 are the same."""
        value = self._number(text.strip())
        return text.strip() if math.isnan(value) else repr(value)

    def _check_length(self, cells: list[str], width: int, line: int) -> None:
        if len(cells) != width:
            raise MappingError(
                f"the row has {len(cells)} cells, the first one {width}",
                where=f"{self.where}, line {line}",
                hint="the file may be cut off; else set delimiter, skip_rows or comment",
            )

    def _index(self, column: Name) -> int:
        """Position of a column; a text of digits is an index where there is no header."""
        if self._header is None and isinstance(column, str) and column.isdecimal():
            column = int(column)
        if isinstance(column, int):
            width = self._values.shape[1]
            if column >= width:
                hint = f"the table has columns 0 to {width - 1}; check delimiter, first and step"
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

    def _group(self, columns: tuple[int, ...]) -> dict[tuple[str, ...], list[int]]:
        groups = self._groups[columns]
        for row in range(len(self._values)):
            groups.setdefault(tuple(self._cell(row, column) for column in columns), []).append(row)
        return groups

    def _cell(self, row: int, column: int) -> str:
        """A cell for comparison."""
        value = float(self._values[row, column])
        return self._texts.get(column, {}).get(row, "") if math.isnan(value) else repr(value)


class _Rows(Iterator[list[str]]):
    """Rows of a text: one after another as their cells, or many at once as numbers.

    Args:
        lines: Number in the file and text of each line.
        delimiter: Between cells.

    Attributes:
        at: Number of the line that was read last.
        block: Those of the lines of the last ``numbers``.
    """

    def __init__(self, lines: Iterator[tuple[int, str]], delimiter: str) -> None:
        self._lines, self._delimiter = lines, delimiter
        self._waiting: deque[tuple[int, str]] = deque()
        self._rows = split(self._numbered(), delimiter)
        self._looked_at = False
        self.at, self.block = 0, [0]

    def __next__(self) -> list[str]:
        return next(self._rows)

    def _numbered(self) -> Iterator[str]:
        while self._waiting or self._wait():
            self.at, line = self._waiting.popleft()
            yield line

    def _wait(self) -> bool:
        self._waiting.extend(islice(self._lines, BLOCK_LINES))
        self._looked_at = False
        return bool(self._waiting)

    def numbers(self, decimal: str, width: int) -> Array | None:
        """The next lines, (lines, width), if all their cells are finite numbers or empty; else they go on waiting.

        Lines that wait after a look were found to hold something else; they are taken one by one.
        """
        if (self._looked_at and self._waiting) or not (self._waiting or self._wait()):
            return None
        self._looked_at = True
        found = _numbers([line for _, line in self._waiting], self._delimiter, decimal, width)
        if found is not None:
            self.block = [number_ for number_, _ in self._waiting]
            self.at = self.block[-1]
            self._waiting.clear()
        return found


BLOCK_LINES = 2048
_NUMERIC = b"0123456789eE+-., ;\t|\n"
"""All that stands in a table of numbers alone."""


def _numbers(lines: list[str], delimiter: str, decimal: str, width: int) -> Array | None:
    """Lines as numbers, (lines, width), NaN where a cell is empty; None if a cell is anything else."""
    text = "\n".join(lines)
    if delimiter == decimal or not text.isascii() or text.encode().translate(None, _NUMERIC):
        return None
    if decimal != ".":
        text = text.replace(decimal, ".")
    if delimiter != "whitespace":
        text = _filled(f"\n{text}\n", delimiter)[1:-1]
    try:
        found = np.loadtxt(text.split("\n"), delimiter=None if delimiter == "whitespace" else delimiter, ndmin=2)
    except ValueError:
        return None
    return found if found.shape == (len(lines), width) and not np.isinf(found).any() else None


def _filled(text: str, delimiter: str) -> str:
    """A text whose empty cells are NaN."""
    twice = delimiter * 2
    if twice in text:
        text = text.replace(twice, f"{delimiter}nan{delimiter}").replace(twice, f"{delimiter}nan{delimiter}")
    return text.replace(f"\n{delimiter}", f"\nnan{delimiter}").replace(f"{delimiter}\n", f"{delimiter}nan\n")


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

    @property
    def oriented(self) -> bool:
        """All points of a table are alike."""
        return True

    def numbers(self, columns: Sequence[Name]) -> Array:
        """Numbers in these columns, (rows, columns); errors as of the table."""
        return self.table.numbers(columns, self.rows)

    def place(self, row: int) -> str:
        """Line in the file."""
        return self.table.place(int(self.rows[row]))


def _held(columns: Sequence[str], groups: Collection[tuple[str, ...]]) -> str:
    """What each column holds, a dozen values of it at most."""
    values = [sorted({key[k].removesuffix(".0") for key in groups}) for k in range(len(columns))]
    return "; ".join(f"{column} has: {shortened(held)}" for column, held in zip(columns, values, strict=True))
