"""Verdicts are computed: equal is equal, a difference needs its explanation, and everything else fails."""

from __future__ import annotations

import json

import pytest

from taskgist.facts import STANDARD_TREE
from taskgist.learning import clause_of, understand
from taskgist_lab.paper import Result, Verdict, report, tally
from taskgist_lab.paper.clauses_and_ablations import compared_clause
from taskgist_lab.paper.published import CLAUSES, SHORT_SHOW, WITHOUT_ABILITIES, compared
from tests.lab.paper.paper_samples import judged_study
from tests.learning import test_paper_clauses
from tests.learning.learning_samples import STUDY, study


def test_equal_needs_no_explanation_and_a_difference_does() -> None:
    assert compared("n", "Eq. 1", [1, 2], (1, 2), explanation="never told") == Result(
        "n", "Eq. 1", (1, 2), (1, 2), Verdict.EQUAL
    )
    assert compared("n", "Eq. 1", 1, 2, explanation="why").verdict is Verdict.DIFFERS_EXPLAINED
    assert compared("n", "Eq. 1", 1, 2).verdict is Verdict.FAILS


def test_the_tally_names_what_was_not_measured_only_if_there_is_any() -> None:
    results = [compared("a", "", 1, 1), compared("b", "", 1, 2), Result("c", "", 1, None, None)]
    assert tally(results) == {"equal": 1, "differs, explained": 0, "fails": 1, "not measured": 1}
    assert tally(results[:1]) == {"equal": 1, "differs, explained": 0, "fails": 0}


def test_two_people_read_the_same_clauses_in_the_paper() -> None:
    for task, published in CLAUSES.items():
        read = {STANDARD_TREE.node(each.node).title: each.value for each in published.predicates}
        assert read == test_paper_clauses.CLAUSES[task]
    show = [(each.node, each.value) for each in CLAUSES["show"].predicates]
    assert [(each.node, each.value) for each in SHORT_SHOW.predicates] == show


def test_what_is_printed_and_how_it_is_read_differ_only_for_a_reason() -> None:
    for clause in (*CLAUSES.values(), SHORT_SHOW, *WITHOUT_ABILITIES):
        for predicate in clause.predicates:
            values = STANDARD_TREE.node(predicate.node).values
            assert predicate.value in values or not values
            assert predicate.printed or predicate.reason, "what is not printed needs a reason"


@pytest.mark.parametrize("task", STUDY)
def test_a_clause_is_its_own_and_no_others(task: str) -> None:
    clause = clause_of(understand(study(task)))
    for other, published in CLAUSES.items():
        verdicts = {result.verdict for result in compared_clause(published, clause)}
        assert (Verdict.FAILS in verdicts) is (other != task), other


def test_one_predicate_less_or_more_fails() -> None:
    clause = clause_of(understand(study("show", 3)))  # three demonstrations agree on more than all four do
    failed = [result for result in compared_clause(CLAUSES["show"], clause) if result.verdict is Verdict.FAILS]
    assert {result.name for result in failed if result.paper is None} >= {
        "show: Final_Posture",
        "show: Object_Final_Status",
    }
    assert {result.name for result in failed if result.ours is None} == {"show: Relative_Posture"}
    assert all(result.explanation for result in failed)


def test_the_values_of_the_study_reproduce_the_paper() -> None:
    found = report(judged_study())
    assert not found.failed
    assert [section.name for section in found.sections] == [
        *("clauses", "draws", "figures", "table_2", "table_3", "table_4", "ablations")
    ]
    assert {result.verdict for result in found.section("draws").results} == {None}, "nothing was displaced"
    explained = [result for result in found.results if result.verdict is Verdict.DIFFERS_EXPLAINED]
    assert all(result.explanation for result in explained)


def test_other_demonstrations_fail() -> None:
    judged = judged_study()
    judged["show"] = judged["show"][:3]
    found = report(judged)
    assert found.failed
    failing = {result.name for result in found.results if result.verdict is Verdict.FAILS}
    assert "show: demonstrations" in failing
    assert "deepest of posture after 4" in failing
    assert not {name for name in failing if name.startswith("give")}


def test_the_document_says_all_of_it() -> None:
    found = report(judged_study())
    document = json.loads(json.dumps(found.to_json()))
    assert set(document) == {"machine", "verdicts", "goals", "sections"}
    results = [result for section in document["sections"] for result in section["results"]]
    assert len(found.results) == sum(document["verdicts"].values())
    assert len(found.goals) == sum(document["goals"].values()) > 50
    assert len(results) == len(found.results) + len(found.goals)
    assert {frozenset(result) for result in results} == {
        frozenset({"name", "where", "paper", "ours", "verdict", "explanation"})
    }
