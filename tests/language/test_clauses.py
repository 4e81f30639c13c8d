"""Sentences on whole clauses."""

from __future__ import annotations

from dataclasses import replace

import pytest

from taskgist.common.frozen import FrozenMap
from taskgist.facts import vocabulary as v
from taskgist.facts.standard import STANDARD_TREE
from taskgist.facts.values import NEGLIGIBLE
from taskgist.language.clauses import by_chance, compared, oddness, supported
from taskgist.language.phrases import phrase_of
from taskgist.learning.background import NEUTRAL
from taskgist.learning.clauses import ClausePosterior, Support
from taskgist.learning.literals import SetLiteral
from taskgist.learning.task_clauses import Odd
from tests.learning.learning_samples import STUDY, explained


@pytest.mark.parametrize(
    ("share", "told"),
    [
        (0.004, "1 of 250"),
        (0.125, "1 of 8"),
        (0.5, "1 of 2"),
        (0.53, "1 of 2"),
        (0.72, "7 of 10"),
        (0.97, "97 of 100"),
        (0.998, "99 of 100"),
    ],
)
def test_chance_is_told_as_a_frequency(share: float, told: str) -> None:
    assert by_chance(share) == told
    assert supported(Support(9, 10, share)) == f"in 9 of 10; by chance in {told}"


@pytest.mark.parametrize(
    ("kinds", "told"),
    [
        ({}, "compared with nothing, so that nothing is learned"),
        ({NEUTRAL + "lift": 200, NEUTRAL + "move": 45}, "compared with 245 neutral manipulations"),
        ({"hide": 3}, "compared with 1 other task"),
        ({"hide": 3, "give": 2, NEUTRAL + "lift": 245}, "compared with 2 other tasks and 245 neutral manipulations"),
    ],
)
def test_what_it_was_compared_with(kinds: dict[str, int], told: str) -> None:
    assert compared(ClausePosterior("show", (), (), (), FrozenMap(kinds))) == told


def test_an_odd_demonstration_is_told_with_what_it_looks_like() -> None:
    odd = Odd(explained("show", 1, STUDY["show"][0]), 0.1, ("give", "hide"))
    assert oddness(odd) == "show 1 looks like 'give' or 'hide': is its label right?"
    assert oddness(replace(odd, looks_like=())) == "show 1 is not like the others: was it done as it should be?"


@pytest.mark.parametrize(
    ("node", "values", "but", "bound", "told"),
    [
        ("placement.status.2", (v.IN_HAND,), False, "", "the object ends in a hand"),
        ("placement.status.2", (v.IN_HAND,), True, "", "it is not so that the object ends in a hand"),
        ("see.effort.2", v.SEE_EFFORTS[:2], False, "≤", "seeing the object takes turning the head afterwards, or less"),
        (
            "see.effort.2",
            v.SEE_EFFORTS[1:],
            False,
            "≥",
            "seeing the object takes turning the head afterwards, or more, or is not possible",
        ),
        (
            "reach.effort.2",
            v.REACH_EFFORTS[1:3],
            False,
            "to",
            "effort to reach is arm effort, arm torso effort, or between",
        ),
        ("visibility.score.2", ("0.1", "0.2"), False, "≥", "the object fills 0.1 of its view afterwards, or more"),
    ],
)
def test_sets_of_values_are_told_in_words(node: str, values: tuple[str, ...], but: bool, bound: str, told: str) -> None:
    found = STANDARD_TREE.node(node)
    literal = SetLiteral(found.name, found.title, values, but, bound, instant=found.instant)
    assert phrase_of(found, literal) == told


def test_what_is_next_to_nothing_is_no_equation() -> None:
    assert str(SetLiteral("visibility.score.2", "Score", (NEGLIGIBLE,))) == "(Score ≈ 0)"
