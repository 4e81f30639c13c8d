"""The page of docs: each mark has its table, and each table its mark."""

from __future__ import annotations

import re
from pathlib import Path

from taskgist_lab.evaluation.experiments import demonstrations_needed, transfer
from taskgist_lab.evaluation.learner import PAPER, Coded
from taskgist_lab.evaluation.robustness import compared, robustness
from tests.lab.evaluation.pools import study_pool
from tools.evaluation_page import about, tables
from tools.markdown import filled

PAGE = Path(__file__).parents[3] / "docs" / "research" / "evaluation.md"
MARK = re.compile(r"^<!-- (?!end)(.+) -->$", re.MULTILINE)


def parts() -> dict[str, str]:
    pool = study_pool(18)
    coded = Coded.of(pool)
    found = tables(
        demonstrations_needed(coded, runs=2, seed=0),
        transfer(coded, runs=2, seed=0),
        robustness(coded, runs=2, seed=0, rules=(PAPER,)),
        compared(coded, runs=2, seed=0, peers={}),
    )
    return {"pool": about(pool, 2), **dict(found)}


def test_marks_and_tables_are_the_same() -> None:
    page = PAGE.read_text(encoding="utf-8")
    marks = MARK.findall(page)
    assert len(marks) == len(set(marks)) == page.count("<!-- end -->")
    assert set(marks) == parts().keys() | {"study"}


def test_filling_changes_the_tables_alone_and_can_be_repeated() -> None:
    page = "before\n<!-- scores -->\nold\n<!-- end -->\nbetween\n<!-- peers -->\n<!-- end -->\nafter\n"
    texts = {"scores": ["| new |"], "peers": ["| also |"], "elsewhere": ["nothing"]}
    once = filled(page, texts)
    assert (
        once
        == "before\n<!-- scores -->\n| new |\n<!-- end -->\nbetween\n<!-- peers -->\n| also |\n<!-- end -->\nafter\n"
    )
    assert filled(once, texts) == once


def test_tables_are_markdown() -> None:
    for name, text in parts().items():
        rows = [line for line in text.splitlines() if line.startswith("|")]
        assert len({line.count("|") for line in rows}) <= 1, name
