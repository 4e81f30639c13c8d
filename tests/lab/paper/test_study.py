"""The shipped recordings of the study, judged: the paper's results come out."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

from taskgist.errors import InputError
from taskgist.facts.vocabulary import EFFORT_LEVELS
from taskgist.pipeline import shipped_study
from taskgist_lab.paper import Goal, Judged, Verdict, judge_study, report, shipped_displacements
from taskgist_lab.paper.published import CLAUSES
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


def levels(each: Judged, ability: str) -> tuple[int, int]:
    """Effort levels at the start and the end of a demonstration."""
    nodes = each.explanation.nodes
    start, end = (str(nodes[f"{ability}.effort.{instant}"].value) for instant in (1, 2))
    return EFFORT_LEVELS[start], EFFORT_LEVELS[end]


@pytest.mark.parametrize(
    ("task", "ability"),
    [
        (task, node.removesuffix(".class"))
        for task, clause in CLAUSES.items()
        for node in (predicate.node for predicate in clause.predicates)
        if node in ("see.class", "reach.class", "grasp.class")
    ],
)
def test_where_a_class_is_printed_demonstrations_end_at_several_levels(task: str, ability: str) -> None:
    """Else the more special value, one level, would be learned."""
    assert len({levels(each, ability)[1] for each in judged()[task]}) >= 2


def test_the_page_of_the_recordings_tells_what_they_show() -> None:
    page = Path("docs/research/recordings.md").read_text(encoding="utf-8")
    for each in (each for of_task in judged().values() for each in of_task):
        name = each.explanation.demonstration
        reach, see = (" → ".join(map(str, levels(each, ability))) for ability in ("reach", "see"))
        assert re.search(rf"^\| {name} \| {reach} \| {see} \|", page, re.MULTILINE), (name, reach, see)
