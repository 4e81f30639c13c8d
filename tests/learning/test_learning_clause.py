"""Clauses: three-valued truth, and the empty one."""

from __future__ import annotations

import pytest

from taskgist.facts import UNKNOWN, Observation, Value
from taskgist.learning import Clause, Experience, Literal, clause_of, understand
from tests.learning.learning_samples import study

CLAUSE = Clause("show", (Literal("a", "A", "1", None), Literal("b", "B", "2", 1)))


@pytest.mark.parametrize(
    ("values", "truth"),
    [
        ({"a": "1", "b": "2"}, True),
        ({"a": "1", "b": "3"}, False),
        ({"a": "1", "b": UNKNOWN}, UNKNOWN),
        ({"a": "1"}, UNKNOWN),
        ({"a": UNKNOWN, "b": "3"}, False),
        ({}, UNKNOWN),
    ],
)
def test_false_beats_unknown_beats_true(values: dict[str, Value], truth: object) -> None:
    assert CLAUSE.holds({name: Observation(value) for name, value in values.items()}) is truth


def test_effects_and_preconditions() -> None:
    assert [literal.title for literal in CLAUSE.effects] == ["A"]
    assert [literal.title for literal in CLAUSE.preconditions] == ["B"]
    assert str(CLAUSE) == "Task(show) ← (A = 1) ∧ (B = 2)"


def test_without_demonstrations_there_is_nothing_in_common() -> None:
    assert str(clause_of(understand(Experience("show")))) == "Task(show) ← nothing in common"


def test_one_demonstration_is_learned_whole_and_concretely() -> None:
    clause = clause_of(understand(study("show", 1)))
    assert {literal.node for literal in clause.literals} >= {
        "see.state.2",
        "see.action.2",
        "see.state.1",
        "posture.value.1",
    }
    assert not {literal.node for literal in clause.literals} & {"see.class", "see.effort.1", "posture.class"}
