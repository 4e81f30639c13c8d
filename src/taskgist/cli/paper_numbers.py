"""The paper's tables of numbers, with ours in the same cells."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest

from rich.table import Table
from rich.text import Text

from taskgist.cli.paper_words import plain_table, verdict_text
from taskgist.facts import Json
from taskgist.study.paper import Result, Section

COLUMNS = ("see", "reach", "object", "all")


def table_2(section: Section) -> Table:
    """Table 2: each row as printed, and below it our exact fractions."""
    columns = [column for column in _map(section.results[0].paper) if column != "value"]
    table = plain_table("", "demonstration", "", *columns, "verdict")
    for result in section.results:
        for who, row in (("paper", _map(result.paper)), ("ours", _map(result.ours))):
            name = result.name.removeprefix("demonstration ") if who == "paper" else ""
            cells = [_cell(row, column) for column in columns]
            if "verdict" in row:  # what the wide band makes of the last row
                cells[0] = _cell(row, "verdict")
            table.add_row(name, who, *cells, verdict_text(result) if who == "ours" else "")
    return table


def table_3(section: Section) -> Table:
    """Table 3: seconds per demonstration, theirs and ours."""
    header = ("task", "demonstrations", "paper, s", "ours, s", "perspective, s", "ours is", "verdict")
    table = plain_table("", *header, numbers=5)
    named = {result.name: result for result in section.results}
    for task, figures in section.details.items():
        count, time = named[f"{task}: demonstrations"], named[f"{task}: seconds"]
        counts = f"{count.paper}" if count.paper == count.ours else f"{count.paper}, ours {count.ours}"
        perspective = _map(figures)["perspective_s"]
        factor = time.explanation.partition(",")[0]
        table.add_row(
            task, counts, f"{time.paper}", f"{time.ours:.3f}", f"{perspective:.3f}", factor, verdict_text(time)
        )
    return table


def table_4(section: Section) -> Table:
    """Table 4: demonstrations needed, paper / ours (fewest-most over all orders)."""
    table = plain_table("", "paper / ours", *COLUMNS, "verdict")
    named = {result.name: result for result in section.results}
    for task, spans in section.details.items():
        own = {column: named.get(f"{task}: {column}") for column in COLUMNS}
        cells = [_needed(own[column], _map(_map(spans)[column])) for column in COLUMNS]
        table.add_row(task, *cells, _worst([result for result in own.values() if result]))
    return table


def lost_table(tasks: Json) -> Table:
    """What each clause loses in a smaller tree, and what it says instead; tasks that lose nothing are left out."""
    rows = []
    for task, change in _map(tasks).items():
        lost, instead = (_texts(_map(change)[key]) for key in ("lost", "instead"))
        pairs = zip_longest(lost, instead, fillvalue="")
        rows += [("" if number else task, *pair) for number, pair in enumerate(pairs)]
    columns = 3 if any(after for _, _, after in rows) else 2
    table = plain_table("", *("task", "loses", "has instead")[:columns])
    for row in rows:
        table.add_row(*row[:columns])
    return table


def _map(value: Json) -> Mapping[str, Json]:
    assert isinstance(value, Mapping), value
    return value


def _texts(value: Json) -> list[str]:
    assert not isinstance(value, int | float | Mapping | None), value
    return [str(each).strip("()") for each in value]


def _cell(row: Mapping[str, Json], column: str) -> str:
    return str(row.get(column, ""))


def _needed(result: Result | None, span: Mapping[str, Json]) -> str:
    theirs = result.paper if result else "-"
    ours, fewest, most = (span[key] if span[key] is not None else "never" for key in ("ours", "fewest", "most"))
    return f"{theirs} / {ours}" + ("" if fewest == most else f" ({fewest}-{most})")


def _worst(results: list[Result]) -> Text:
    order = ("fails", "differs, explained", "equal")
    texts = [verdict_text(result) for result in results]
    return min(texts, key=lambda text: order.index(text.plain))
