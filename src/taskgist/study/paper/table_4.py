"""Table 4: how many demonstrations it takes to understand what people understand, by task and column."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import permutations

from taskgist.facts import Json
from taskgist.learning import Experience, Explanation, understand
from taskgist.study.intuition import COLUMNS, INTUITION, NEEDED, NEEDED_BY_COLUMN, understood
from taskgist.study.paper.demonstrations import Judged
from taskgist.study.paper.result import Result, Section, compared

ALL = "all"
"""All columns together: the table's last one."""
LEAST_SHARE = 0.05
"""Of all orders that must give the paper's number before their order explains ours: what hardly any does, an order of
theirs is no likely reason for."""
ABOUT = (
    "The first demonstration from which on the cell holds to the end, in the study's order; in brackets the fewest and "
    "the most over all orders of the same demonstrations. Cells that are blank in the paper are not compared."
)
OTHER_ORDER = (
    "the paper's number comes out of {percent:.0f} % of the orders in which the same demonstrations can be shown; "
    "which values its own had, it does not print"
)

Needed = Mapping[str, int | None]
"""Demonstrations by column; None: not understood in the end."""


def table_4_section(judged: Mapping[str, tuple[Judged, ...]]) -> Section:
    """Compare Table 4 cell by cell.

    Args:
        judged: The judged demonstrations by task.
    """
    results: list[Result] = []
    details: dict[str, Json] = {}
    for task in INTUITION:
        explanations = [each.explanation for each in judged[task]]
        orders = list(needed_in_all_orders(task, explanations))
        results += compared_row(task, orders)
        details[task] = {column: _span(orders, column) for column in (*COLUMNS, ALL)}
    return Section("table_4", "Table 4: demonstrations until understood as people do", tuple(results), ABOUT, details)


def needed_in_all_orders(task: str, explanations: Sequence[Explanation]) -> Iterator[Needed]:
    """How many demonstrations each column takes, in every order of them; the given one comes first.

    Args:
        task: A task of the table.
        explanations: Its demonstrations.
    """

    @cache
    def holds(shown: frozenset[int]) -> Mapping[str, bool]:
        cells = understood(understand(Experience.of(task, (explanations[each] for each in sorted(shown)))))
        return {**cells, ALL: all(cells.values())}

    for order in permutations(range(len(explanations))):
        history = [holds(frozenset(order[:count])) for count in range(1, len(order) + 1)]
        yield {column: lasting_from([step[column] for step in history]) for column in (*COLUMNS, ALL)}


def lasting_from(history: Sequence[bool]) -> int | None:
    """From which step on, counted from one, something held to the end; None if it did not."""
    lasting = len(history)
    while lasting and history[lasting - 1]:
        lasting -= 1
    return None if lasting == len(history) else lasting + 1


def compared_row(task: str, orders: Sequence[Needed]) -> Iterator[Result]:
    """A result for each cell that the paper prints; orders other than the first one are what may explain it."""
    for column, theirs in {**NEEDED_BY_COLUMN[task], ALL: NEEDED[task]}.items():
        share = sum(order[column] == theirs for order in orders) / len(orders)
        explanation = OTHER_ORDER.format(percent=100 * share) if share >= LEAST_SHARE else ""
        yield compared(f"{task}: {column}", "Table 4", theirs, orders[0][column], explanation=explanation)


def _span(orders: Sequence[Needed], column: str) -> Json:
    found = [count for order in orders if (count := order[column]) is not None]
    return {
        "ours": orders[0][column],
        "fewest": min(found, default=None),
        "most": max(found, default=None) if len(found) == len(orders) else None,
    }
