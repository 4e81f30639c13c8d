"""Tables 2, 3 and 4, figures and ablations, on values whose results are known."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from taskgist.facts import Observation
from taskgist.learning import Experience, understand
from taskgist.learning.estimate import Verdict as Finding
from taskgist_lab.paper import Judged, Verdict
from taskgist_lab.paper.clauses_and_ablations import ablations_section, figures_section
from taskgist_lab.paper.published import COLUMNS, NEEDED, NEEDED_BY_COLUMN, understood
from taskgist_lab.paper.tables import (
    ALL,
    TABLE_2_PRINTED,
    TABLE_3_PRINTED,
    WIDE,
    agrees,
    compared_row,
    lasting_from,
    needed_in_all_orders,
    table_2_section,
    table_3_section,
    table_4_section,
)
from tests.lab.paper.paper_samples import JudgedStudy, judged_study
from tests.learning.learning_samples import STUDY, study


def test_table_2_is_the_papers_in_exact_fractions() -> None:
    section = table_2_section(judged_study())
    *rows, wide = section.results
    assert [result.verdict for result in rows] == [*[Verdict.EQUAL] * 3, Verdict.DIFFERS_EXPLAINED]
    ours = rows[3].ours
    assert ours == {
        "observed": "On_Support",
        "value": "In_Hand",
        "Q": "2/3",
        "P": "3/4",
        "NRE": "1/3",
        "d1": "7/15",
        "d2": "3/5",
        "CF": "1/3",
    }
    assert rows[3].explanation.startswith("CF is the difference of rounded columns (0.66667 − 0.33333 = 0.33334)")
    assert (wide.verdict, wide.ours) == (Verdict.EQUAL, {"d1": "4/15", "verdict": Finding.CONFUSING.value})
    assert wide.paper == WIDE
    question = str(section.details["question"])
    assert question.startswith("What does “show” mean: that the object ends in a hand (in show 1, show 2, and show 3)")


def test_another_difference_than_that_of_rounding_fails() -> None:
    """One more demonstration that ends in a hand: every number of the last row is another."""
    judged = judged_study()
    judged["show"] = (*judged["show"][:3], judged["show"][0])
    row, wide = table_2_section(judged).results[3:]
    assert row.verdict is Verdict.FAILS
    assert wide.verdict is Verdict.FAILS


@pytest.mark.parametrize(
    ("printed", "exact", "same"),
    [
        ("0.66667", Fraction(2, 3), True),
        ("0.33334", Fraction(1, 3), False),
        ("0.33333", Fraction(1, 3), True),
        ("0.675", Fraction(27, 40), True),
        ("1", Fraction(99_999, 100_000), False),
    ],
)
def test_rounding_is_to_five_decimals(printed: str, exact: Fraction, same: bool) -> None:
    assert agrees(printed, exact) is same
    assert len(TABLE_2_PRINTED) == 4


def test_figures_show_what_each_demonstration_prunes() -> None:
    section = figures_section(judged_study())
    assert {result.verdict for result in section.results} == {Verdict.EQUAL}
    reversed_order: JudgedStudy = {**judged_study(), "show": judged_study()["show"][::-1]}
    assert Verdict.FAILS in {result.verdict for result in figures_section(reversed_order).results}


def test_table_3_compares_numbers_and_never_calls_a_time_equal() -> None:
    section = table_3_section(judged_study())
    by_name = {result.name: result for result in section.results}
    assert by_name["hide away: seconds"].explanation == "12.0 times faster, on another computer"
    assert by_name["hide away: demonstrations"].verdict is Verdict.EQUAL
    slow = {task: tuple(replace(each, seconds=2.4) for each in of_task) for task, of_task in judged_study().items()}
    again = {result.name: result for result in table_3_section(slow).results}
    assert again["hide away: seconds"].explanation == "2.0 times slower, on another computer"
    assert {again[f"{task}: seconds"].verdict for task in STUDY} == {Verdict.DIFFERS_EXPLAINED}


def test_tasks_are_ordered_by_the_times_that_were_measured() -> None:
    judged = judged_study()
    for task, (_, seconds) in TABLE_3_PRINTED.items():
        judged[task] = tuple(replace(each, seconds=seconds / 10) for each in judged[task])
    assert table_3_section(judged).results[-2].verdict is Verdict.EQUAL
    judged["give"] = tuple(replace(each, seconds=2.4) for each in judged["give"])
    order = table_3_section(judged).results[-2]
    assert order.verdict is Verdict.DIFFERS_EXPLAINED
    assert order.ours == ("give", "hide away", "hide", "show", "put away", "make accessible")
    assert order.explanation.startswith("ours takes longest for give, as measured (give 2.400 s, hide away 0.120 s, ")


def test_hide_away_needs_most_effort_in_the_end() -> None:
    judged = judged_study()
    assert table_3_section(judged).results[-1].verdict is Verdict.EQUAL
    judged["hide away"] = tuple(_at_hand(each) for each in judged["hide away"])
    assert table_3_section(judged).results[-1].verdict is Verdict.FAILS


def _at_hand(judged: Judged) -> Judged:
    """The same, but that everything takes no effort in the end."""
    effortless = {f"{ability}.effort.2": Observation("No_Effort_Required") for ability in ("reach", "grasp", "see")}
    explanation = replace(judged.explanation, nodes={**judged.explanation.nodes, **effortless})
    return replace(judged, explanation=explanation)


@pytest.mark.parametrize("task", STUDY)
def test_every_order_is_what_learning_one_by_one_in_it_gives(task: str) -> None:
    explanations = list(study(task).explanations.values())
    orders = list(needed_in_all_orders(task, explanations))
    for order, needed in list(zip(permutations(explanations), orders, strict=True))[:: max(1, len(orders) // 6)]:
        steps = range(1, len(order) + 1)
        history = [understood(understand(Experience.of(task, order[:count]))) for count in steps]
        for column in COLUMNS:
            assert needed[column] == lasting_from([cells[column] for cells in history])
        assert needed[ALL] == lasting_from([all(cells.values()) for cells in history])


def test_table_4_is_the_papers() -> None:
    section = table_4_section(judged_study())
    totals = {result.name.partition(":")[0]: result.ours for result in section.results if result.name.endswith(ALL)}
    assert totals == NEEDED
    assert Verdict.FAILS not in {result.verdict for result in section.results}


def test_what_is_never_understood_fails() -> None:
    judged = judged_study()
    judged["hide"] = judged["hide"][:1]
    results = {result.name: result for result in table_4_section(judged).results}
    assert results["hide: all"].ours is None
    assert results["hide: all"].verdict is Verdict.FAILS


def test_an_order_that_hardly_any_is_explains_nothing() -> None:
    """Of 20 orders one is enough, of 21 it is not."""
    ours = dict.fromkeys((*COLUMNS, ALL), 99)
    theirs = {**NEEDED_BY_COLUMN["show"], ALL: NEEDED["show"]}
    for others, verdict in ((19, Verdict.DIFFERS_EXPLAINED), (20, Verdict.FAILS)):
        assert {each.verdict for each in compared_row("show", [*[ours] * others, theirs])} == {verdict}


@given(st.lists(st.booleans(), max_size=8))
def test_lasting_is_the_first_step_from_which_on_all_hold(history: list[bool]) -> None:
    step = lasting_from(history)
    if step is None:
        assert not history or not history[-1]
    else:
        assert all(history[step - 1 :])
        assert step == 1 or not history[step - 2]


def test_smaller_trees_lose_what_the_paper_says() -> None:
    section = ablations_section(judged_study())
    assert {result.verdict for result in section.results} == {Verdict.EQUAL}
    lost = section.details["without the nature level"]
    assert lost["make accessible"]["lost"] == ("(Nature_Effort_Class_to_See = Supportive)",)  # type: ignore[index, call-overload]
