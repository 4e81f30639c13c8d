"""The shipped recordings of the study, judged: the paper's results come out."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from taskgist.errors import InputError
from taskgist.pipeline import shipped_study
from taskgist_lab.paper import Goal, Judged, Verdict, judge_study, report, shipped_displacements
from tools.markdown import filled
from tools.paper_page import parts


@cache
def judged() -> dict[str, tuple[Judged, ...]]:
    told: list[float] = []
    found = judge_study(processes=1, progress=lambda _, share: told.append(share))
    assert told == pytest.approx([(number + 1) / 23 for number in range(23)])
    return found


def test_no_result_of_the_paper_fails() -> None:
    found = report(judged(), shipped_displacements())
    assert [result for result in found.results if result.verdict is Verdict.FAILS] == []
    assert [result for result in found.goals if result.verdict is Goal.NOT_MET] == []
    assert not found.failed
    assert {result.verdict for result in found.section("figures").results} == {Verdict.EQUAL}
    assert {result.verdict for result in found.section("ablations").results} == {Verdict.EQUAL}


def test_judging_tells_what_it_took() -> None:
    for task, of_task in judged().items():
        for each in of_task:
            assert each.explanation.task == task
            assert 0.0 < each.seconds < 60.0
            assert 0.0 < each.perspective_seconds < 60.0
            assert each.length_s > 1.0


def test_no_process_is_refused() -> None:
    with pytest.raises(InputError, match=r"processes: too small \(got 0\)"):
        judge_study(processes=0)


def test_processes_change_nothing_but_the_times() -> None:
    paths = {"hide": shipped_study()["hide"][:2]}
    apart = judge_study(paths, processes=2)
    assert [each.explanation for each in apart["hide"]] == [each.explanation for each in judged()["hide"][:2]]


PAGE = Path(__file__).parents[3] / "docs" / "research" / "study.md"
MEASURED_ELSEWHERE = {"table 3"}
"""What of the page holds times of the computer on which it was made."""


def test_the_page_says_what_comes_out() -> None:
    """Otherwise: python -m tools.paper_page."""
    page = PAGE.read_text(encoding="utf-8")
    told = parts(report(judged(), shipped_displacements()), judged())
    assert filled(page, {name: lines for name, lines in told.items() if name not in MEASURED_ELSEWHERE}) == page
    assert set(re.findall(r"^<!-- (.*) -->$", page, flags=re.MULTILINE)) == {*told, "end"}


def test_every_row_of_the_page_has_as_many_cells_as_its_head() -> None:
    tables = re.findall(r"(?:^\|.*\|$\n)+", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert len(tables) > 10
    for table in tables:
        assert len({row.count("|") for row in table.splitlines()}) == 1, table
