"""Pages in Markdown: tables, and parts that are measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # tools that measure what a command loads load nothing themselves
    from taskgist_lab.evaluation.sheets import Sheet


def header(*titles: str) -> Iterator[str]:
    """The first two lines of a table."""
    yield row(*titles)
    yield row(*["---"] * len(titles))


def row(*cells: object) -> str:
    """One line of a table."""
    return f"| {' | '.join(map(str, cells))} |"


def sheet_lines(sheet: Sheet) -> Iterator[str]:
    """A table of an evaluation, its note below."""
    yield from header(*sheet.header)
    yield from (row(*cells) for cells in sheet.rows)
    if sheet.note:
        yield ""
        yield f"*{sheet.note}*"


def filled(page: str, parts: Mapping[str, Iterable[str]]) -> str:
    """A page with lines between each ``<!-- NAME -->`` and the next ``<!-- end -->``; the rest stays as it is.

    Parts that the page has no place for are left out.
    """
    for name, lines in parts.items():
        before, mark, rest = page.partition(f"<!-- {name} -->\n")
        if mark:
            text = "".join(f"{line}\n" for line in lines)
            page = before + mark + text + "<!-- end -->" + rest.partition("<!-- end -->")[2]
    return page
