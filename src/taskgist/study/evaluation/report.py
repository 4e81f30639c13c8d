"""Which tables tell a result."""

from __future__ import annotations

from collections.abc import Iterable

from taskgist.study.evaluation.comparison import Comparison
from taskgist.study.evaluation.needed import Needs
from taskgist.study.evaluation.result import Result
from taskgist.study.evaluation.robustness import Robustness
from taskgist.study.evaluation.robustness_sheets import robustness_sheet, rules_sheet
from taskgist.study.evaluation.rules import PAPER
from taskgist.study.evaluation.sheet import Sheet
from taskgist.study.evaluation.sheets import (
    curve_sheet,
    needed_sheet,
    peers_sheet,
    single_sheet,
    transfer_sheets,
)
from taskgist.study.evaluation.transfer import Transfer


def sheets_of(result: Result) -> Iterable[Sheet]:
    """The tables that tell a result."""
    if isinstance(result, Needs):
        return (needed_sheet(result), single_sheet(result), curve_sheet(result))
    if isinstance(result, Transfer):
        return tuple(transfer_sheets(result, (1, 5, 10)))
    if isinstance(result, Robustness):
        return (robustness_sheet(result, PAPER.name), rules_sheet(result))
    assert isinstance(result, Comparison)
    return (peers_sheet(result),)
