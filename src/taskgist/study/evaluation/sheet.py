"""A table of text, and how numbers stand in it."""

from __future__ import annotations

from dataclasses import dataclass

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


def until(needed: Spread, reached: float, *, spread: bool = True) -> str:
    """Demonstrations needed, with the share of draws that reached it where that is not all."""
    if needed.mean is None:
        return "never"
    text = spread_text(needed, as_percent=False) if spread else f"{needed.mean:.1f}"
    return text if reached == 1.0 else f"{text} [{percent(reached)}]"


def spread_text(value: Spread, *, as_percent: bool = True) -> str:
    """Mean, and the quantiles on both sides in brackets."""
    if value.mean is None or value.low is None or value.high is None:
        return NONE
    if as_percent:
        return f"{percent(value.mean)} ({value.low:.0%}-{value.high:.0%})"
    return f"{value.mean:.1f} ({value.low:.0f}-{value.high:.0f})"


def mean_text(value: Spread) -> str:
    """The mean alone, in whole percent."""
    return NONE if value.mean is None else percent(value.mean)


def truth_text(true: float, unknown: float) -> str:
    """Share that is true, and the unknown one where there is any."""
    return percent(true) if round(unknown, 2) == 0 else f"{percent(true)} ?{percent(unknown)}"


def percent(share: float) -> str:
    """A share in whole percent."""
    return f"{share:.0%}"
