"""Lines of text to cells, and cells to numbers."""

from __future__ import annotations

import csv
import math
from collections import Counter

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
