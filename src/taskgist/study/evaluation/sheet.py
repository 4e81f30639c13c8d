"""A table of text, and how numbers stand in it."""

from __future__ import annotations

from dataclasses import dataclass

from taskgist.study.evaluation.needed import Waiting
from taskgist.study.evaluation.spread import Spread

NONE = "-"


@dataclass(frozen=True)
class Sheet:
    """A table.

    Args:
        title: What it shows.
        header: Names of the columns.
        rows: Cells, the first of each row names it.
        note: How to read it.
    """

    title: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def waiting_text(needed: Waiting) -> str:
    """Median, and the quantiles on both sides in brackets."""
    median, low, high = ("never" if each is None else str(each) for each in (needed.median, needed.low, needed.high))
    return median if median == low == high else f"{median} ({low}-{high})"


def spread_text(value: Spread) -> str:
    """Mean, and the quantiles on both sides in brackets, in percent."""
    if value.mean is None or value.low is None or value.high is None:
        return NONE
    return f"{percent(value.mean)} ({value.low:.0%}-{value.high:.0%})"


def mean_text(value: Spread) -> str:
    """The mean alone, in whole percent."""
    return NONE if value.mean is None else percent(value.mean)


def truth_text(true: float, unknown: float) -> str:
    """Share that is true, and the unknown one where there is any."""
    return percent(true) if round(unknown, 2) == 0 else f"{percent(true)} ?{percent(unknown)}"


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{share:.0%}"
