"""Attributes: what they accept, and the symbols that raw values become."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from taskgist.errors import FactsError
from taskgist.facts import NEGLIGIBLE, REACH_EFFORTS, STANDARD_TREE, UNKNOWN, Attribute, score_bin
from taskgist.settings import DEFAULT, Vision

POSTURE, HANDS, SCORE = (STANDARD_TREE.attributes[name] for name in ("posture", "hands", "visibility.score"))
SEEDED = settings(derandomize=True)


@pytest.mark.parametrize(
    ("attribute", "raw", "message"),
    [
        (POSTURE, "Siting", "posture: no such value (got 'Siting'); did you mean 'Sitting'?"),
        (POSTURE, 3, "posture: not a symbol (got 3)"),
        (STANDARD_TREE.attributes["see.action"], "", "give a text that is not empty"),
        (HANDS, "Free_of_Object", "not a status by side"),
        (HANDS, {}, "not a status by side"),
        (
            HANDS,
            {"left": "Free_Object"},
            "hands.left: no such value (got 'Free_Object'); did you mean 'Free_of_Object'?",
        ),
        (SCORE, 1.5, "not a visibility score (got 1.5)"),
        (SCORE, math.nan, "not a visibility score"),
        (SCORE, True, "not a visibility score"),
        (SCORE, "0.5", "a number from 0 to 1"),
    ],
)
def test_wrong_values_are_refused_with_a_way_out(attribute: Attribute, raw: object, message: str) -> None:
    with pytest.raises(FactsError) as caught:
        attribute.read(raw, field=attribute.name)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("raw", "symbol"),
    [
        ({"left": "Free_of_Object", "right": "Free_of_Object"}, "Free_of_Object"),
        ({"right": "Free_of_Object"}, "Free_of_Object"),
        (
            {"right": "Free_of_Object", "left": "Resting_on_Support"},
            "left: Resting_on_Support, right: Free_of_Object",
        ),
        ({"left": None, "right": "Holding_Object"}, UNKNOWN),
    ],
)
def test_hands_become_one_symbol(raw: dict[str, str | None], symbol: object) -> None:
    assert HANDS.symbol(HANDS.read(raw), DEFAULT) == symbol


@pytest.mark.parametrize(
    ("score", "label"),
    [
        (0.0, NEGLIGIBLE),
        (4.8e-8, NEGLIGIBLE),
        (4.9e-8, "0.0000049-0.0000098 %"),
        (1.6e-5, "0.0013-0.0025 %"),
        (0.99e-4, "0.005-0.01 %"),
        (1e-4, "0.01-0.02 %"),
        (0.0100, "0.64-1.3 %"),
        (1.0, "82-100 %"),
    ],
)
def test_scores_become_bins(score: float, label: str) -> None:
    assert score_bin(score, DEFAULT.vision) == label


@SEEDED
@given(st.floats(1e-4, 1.0), st.floats(1e-4, 1.0), st.sampled_from([0.5, 1.0, 3.0, 10.0, 40.0]))
def test_bins_are_as_wide_as_they_say_and_no_two_share_a_label(one: float, other: float, per_doubling: float) -> None:
    vision = dataclasses.replace(Vision(), bins_per_doubling=per_doubling)
    apart = abs(math.log2(one / other)) * per_doubling
    if score_bin(one, vision) == score_bin(other, vision):
        assert apart <= 1.0 + 1e-9
    else:
        assert apart > 0.0


def test_effort_ladders_are_those_of_figure_6() -> None:
    assert STANDARD_TREE.attributes["reach.effort"].values == REACH_EFFORTS
    assert STANDARD_TREE.attributes["grasp.effort"].values[1] == "Arm_Effort"
    assert STANDARD_TREE.attributes["see.effort"].values[1:3] == ("Head_Effort", "Head_Torso_Effort")
