"""Tables, headings and verdicts in the style of the comparison with the paper."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence

from rich.table import Table
from rich.text import Text

from taskgist.cli.output import console
from taskgist.facts import Json
from taskgist.study.paper import Goal, Result, Section, Verdict, wilson

WIDTH = 112
"""Columns of the widest table, and of paragraphs."""
STYLES: Mapping[Verdict | Goal, str] = {
    Verdict.EQUAL: "green",
    Verdict.DIFFERS_EXPLAINED: "yellow",
    Verdict.FAILS: "bold red",
    Goal.MET: "green",
    Goal.OPEN: "yellow",
    Goal.NOT_MET: "bold red",
}


def heading(section: Section) -> None:
    """Print a section's title, and what was done."""
    console.print(Text(section.title, style="bold"))
    paragraph(section.about)


def paragraph(text: str, *, indent: str = "", style: str = "dim") -> None:
    """Print running text, in lines of readable length."""
    for line in textwrap.wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent):
        console.print(Text(line, style=style))


def plain_table(title: str, *columns: str, numbers: int = 0) -> Table:
    """An empty table without lines; its last ``numbers`` columns before the verdict are aligned to the right."""
    table = Table(title=title or None, title_justify="left", title_style="bold", box=None, padding=(0, 2, 0, 0))
    for place, column in enumerate(columns):
        right = len(columns) - 1 - numbers <= place < len(columns) - 1
        table.add_column(column, justify="right" if right else "left", header_style="dim", no_wrap=True)
    return table


def show(table: Table) -> None:
    """Print a table as wide as it wants to be, also where the output is no terminal."""
    table.width = console.measure(table, options=console.options.update(max_width=WIDTH)).maximum
    console.print(table)


def verdict_text(result: Result) -> Text:
    """The verdict in its colour."""
    if result.verdict is None:
        return Text("not measured", style="dim")
    return Text(result.verdict.value, style=STYLES[result.verdict])


def share_words(result: Result, drawn: Json) -> str:
    """The share of draws with its 95 % interval, whose ends are rounded outwards; nothing if none was measured.

    Args:
        result: What is held to the goal.
        drawn: What else is known of the draws of its task.
    """
    if not isinstance(result.ours, float) or not isinstance(drawn, Mapping):
        return ""
    count = drawn["draws"]
    assert isinstance(count, int)
    low, high = wilson(round(result.ours * count), count)
    return f"{result.ours:.1%} ({math.floor(1000 * low) / 10:.1f}-{math.ceil(1000 * high) / 10:.1f}%)"


def words(value: Json) -> str:
    """A value in a cell: a list by its parts; a mapping by its size, as its names are told elsewhere."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Mapping):
        return f"{len(value)} predicates"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ", ".join(map(str, value)) or "nothing"
    return "nothing" if value is None else str(value)
